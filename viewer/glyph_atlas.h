#pragma once
#include <array>
#include <glm/vec2.hpp>
#include <string_view>

#include "foreview/gpu/gl_objects.h"

namespace foreview {

/// The printable characters of ASCII in one texture, for text in frames with and without a window. Drawn once by OpenCV
/// (Hershey's simplex strokes, which need no font file). Needs a current context.
class GlyphAtlas {
 public:
  GlyphAtlas();
  /// R8, with levels: how much of a texel the character covers.
  [[nodiscard]] GLuint texture() const { return texture_.id(); }

  struct Glyph {
    glm::vec2 first{0}, last{0};  ///< texture coordinates of its cell
    float width = 0;              ///< of the cell, in heights of a line
    float advance = 0;            ///< to the next character, in heights of a line
  };
  /// A question mark for what is not printable ASCII.
  [[nodiscard]] const Glyph& glyph(char character) const;
  /// In heights of a line.
  [[nodiscard]] float width(std::string_view text) const;

 private:
  GlTexture texture_;
  std::array<Glyph, 95> glyphs_;
};

}  // namespace foreview
