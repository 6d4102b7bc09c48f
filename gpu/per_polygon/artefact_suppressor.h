#pragma once
#include <vector>

#include "foreview/gpu/extraction.h"
#include "foreview/gpu/gl_objects.h"

namespace foreview::per_polygon {

/// Rule 4 of PerPolygonExtraction (spec 5): grows the invalid regions of a perspective texture's alpha. Alpha is
/// GL_R32F: 31/32 and the means of many of them must come out exactly.
class ArtefactSuppressor {
 public:
  explicit ArtefactSuppressor(const ExtractionOptions& options);
  /// Before the first box of a picture of this size. Textures are created only where a picture is larger than any
  /// before it.
  void make_room(int width, int height);
  /// Where alpha is to be written before suppress().
  [[nodiscard]] GLuint alpha() const { return images_[0].id(); }
  /// Suppresses in the first width x height texels of alpha(); returns the texture that holds the result, which stays
  /// until alpha() is written again.
  [[nodiscard]] GLuint suppress(int width, int height);

 private:
  GLuint diamond(int width, int height);
  GLuint alternating(int width, int height);
  GLuint progressive(int width, int height);
  void reduce(GLuint fine, int width, int height, GLuint coarse);
  /// `own` 0: an enlargement on the way; else the last one, which decides about the texels of `own`.
  void enlarge(GLuint coarse, int width, int height, GLuint own, GLuint fine);

  ArtefactSuppression variant_;
  int passes_;
  double alpha_c_;
  GlProgram diamond_, reduce_, enlarge_;
  GlTexture images_[2];
  std::vector<GlTexture> smaller_;  ///< half the size, a quarter, ...
  int room_width_ = 0, room_height_ = 0;
};

}  // namespace foreview::per_polygon
