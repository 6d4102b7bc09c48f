#pragma once
#include <vector>

#include "foreview/gpu/extraction.h"
#include "foreview/gpu/gl_objects.h"

namespace foreview::per_polygon {

/// Rule 7 of PerPolygonExtraction (spec 9): a copy of a polygon's texture without holes.
class HoleFiller {
 public:
  /// Textures up to `widest` x `highest` texels.
  HoleFiller(const ExtractionOptions& options, int widest, int highest);
  /// Fills what is not valid in `fused` (GL_RGBA8, width x height) into filled(), and writes the pyramid's top to entry
  /// `polygon` of `states` (GL_SHADER_STORAGE_BUFFER of TextureStore::PolygonState) if there is any valid texel;
  /// `polygon` < 0: no state is written.
  void fill(GLuint fused, int width, int height, GLuint states, int polygon);
  /// GL_RGBA8; alpha is that of the fused texture.
  [[nodiscard]] GLuint filled() const { return filled_.id(); }

 private:
  void run_pyramid(GLuint fused, int width, int height, GLuint states, int polygon);
  void iterate(GLuint fused, int width, int height);
  void paint_grey(GLuint colours, GLuint fused, int width, int height);

  HoleFilling variant_;
  bool occlusion_query_;
  GlProgram pull_, push_, push_base_, tip_, tip_base_, grey_, copy_, iterate_;
  GlTexture filled_;
  std::vector<GlTexture> levels_;  ///< the pyramid's from 1 on, GL_RGBA16F
  GlTexture iterated_[2];          ///< GL_RGBA16F
  GlFramebuffer iterated_framebuffer_[2];
  GlVertexArray no_vertices_;
  GlOcclusionQuery changed_;
};

}  // namespace foreview::per_polygon
