#pragma once
#include <cstdint>
#include <vector>

#include "foreview/gpu/extraction.h"
#include "foreview/gpu/gl_objects.h"
#include "foreview/gpu/per_polygon/polygon_textures.h"

namespace foreview::per_polygon {

/// Rule 7 of PerPolygonExtraction (spec 9): a copy of a polygon's texture without holes.
class HoleFiller {
 public:
  HoleFiller(const ExtractionOptions& options, const PolygonModel& model, const PolygonTextures& textures);
  /// Fills what is not valid in `fused`, a GL_RGBA8 texture of the polygon's size, into filled(). With `write_state`,
  /// writes the pyramid's top to the polygon's entry of `states` (GL_SHADER_STORAGE_BUFFER of
  /// TextureStore::PolygonState) if there is any valid texel.
  void fill(GLuint fused, std::uint32_t polygon, GLuint states, bool write_state);
  /// GL_RGBA8; alpha is that of the fused texture.
  [[nodiscard]] GLuint filled() const { return filled_.id(); }

 private:
  /// A polygon's outline in its texture.
  struct Outline {
    int width = 0, height = 0;  ///< texels, of the texture
    int first_edge = 0, edges = 0;
  };
  void collect_outlines(const PolygonModel& model, const PolygonTextures& textures);
  void run_pyramid(GLuint fused, int width, int height, GLuint states, int polygon);
  void open_holes(GLuint fused, const Outline& outline);
  void iterate(GLuint fused, int width, int height);
  void paint_grey(GLuint colours, GLuint fused, int width, int height);

  std::vector<Outline> outlines_;  ///< by polygon
  GlBuffer edges_;                 ///< vec4 each, see per_polygon_open_holes.comp.glsl; only where holes stay open
  HoleFilling variant_;
  bool occlusion_query_;
  GlProgram pull_, push_, push_base_, tip_, tip_base_, grey_, open_, copy_, iterate_;
  GlTexture filled_;
  // Single precision: half floats, which a driver may cut instead of rounding, darken a little with every pass.
  std::vector<GlTexture> levels_;  ///< the pyramid's from 1 on, GL_RGBA32F
  GlTexture iterated_[2];          ///< GL_RGBA32F
  GlFramebuffer iterated_framebuffer_[2];
  GlVertexArray no_vertices_;
  GlOcclusionQuery changed_;
};

}  // namespace foreview::per_polygon
