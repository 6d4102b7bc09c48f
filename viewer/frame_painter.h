#pragma once
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <string_view>
#include <vector>

#include "foreview/gpu/gl_objects.h"
#include "foreview/viewer/glyph_atlas.h"

namespace foreview {

/// Flat shapes and text over a frame: collected, then drawn in one call. Pixels of the frame, y down, row 0 its top.
/// Colours are red, green, blue, alpha, 0..1. Needs a current context in every member.
class FramePainter {
 public:
  FramePainter();

  void rectangle(const glm::vec2& corner, const glm::vec2& size, const glm::vec4& colour);
  /// Text in one line whose upper left is `corner` and whose height (of a line, with room above and below) is `height`.
  void text(const glm::vec2& corner, float height, std::string_view text, const glm::vec4& colour);
  [[nodiscard]] float text_width(float height, std::string_view text) const { return height * atlas_.width(text); }
  /// A bar filled with a scale of view_scale.glsl from left to right.
  enum class Scale { age, density };
  void scale(const glm::vec2& corner, const glm::vec2& size, Scale scale);

  /// Draws all that was collected, and forgets it. Nothing collected: does nothing.
  void flush(GLuint framebuffer, int width, int height);

 private:
  struct Vertex {
    glm::vec2 position{0};  ///< pixels
    glm::vec2 place{0};     ///< in the atlas; of a scale: 0..1 along it
    glm::vec4 colour{0};
    float kind = 0;  ///< view_paint.frag.glsl's
  };
  void quad(const glm::vec2& first, const glm::vec2& last, const glm::vec2& place_first, const glm::vec2& place_last,
            const glm::vec4& colour, float kind);

  static constexpr std::size_t kMostVertices = 6 * 2048;  ///< more are left out
  GlyphAtlas atlas_;
  GlProgram program_;
  GlBuffer buffer_;
  GlVertexArray vao_;
  GlSampler sampler_;
  std::vector<Vertex> vertices_;
};

}  // namespace foreview
