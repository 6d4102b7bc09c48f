#include "foreview/gpu/per_polygon/artefact_suppressor.h"

#include <algorithm>

#include "foreview/gpu/dispatch.h"

namespace foreview::per_polygon {

namespace {

int half(int size) {
  return (size + 1) / 2;
}

void bind_alpha_image(GLuint texture) {
  glBindImageTexture(0, texture, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
}

}  // namespace

ArtefactSuppressor::ArtefactSuppressor(const ExtractionOptions& options)
    : variant_(options.passes == 0 ? ArtefactSuppression::none : options.artefacts),
      passes_(options.passes),
      alpha_c_(options.alpha_c) {
  switch (variant_) {
    case ArtefactSuppression::none:
      break;
    case ArtefactSuppression::diamond:
      diamond_ = make_compute_program("per_polygon_diamond.comp.glsl");
      break;
    case ArtefactSuppression::alternating:
    case ArtefactSuppression::progressive:
      reduce_ = make_compute_program("per_polygon_reduce.comp.glsl");
      enlarge_ = make_compute_program("per_polygon_enlarge.comp.glsl");
      break;
  }
}

void ArtefactSuppressor::make_room(int width, int height) {
  if (width <= room_width_ && height <= room_height_) return;
  room_width_ = std::max(width, room_width_);
  room_height_ = std::max(height, room_height_);
  for (GlTexture& image : images_) image = make_texture_2d(GL_R32F, room_width_, room_height_);
  smaller_.clear();
  const int levels = variant_ == ArtefactSuppression::progressive   ? passes_
                     : variant_ == ArtefactSuppression::alternating ? 1
                                                                    : 0;
  int w = room_width_, h = room_height_;
  for (int i = 0; i < levels; ++i) {
    w = half(w);
    h = half(h);
    smaller_.push_back(make_texture_2d(GL_R32F, w, h));
  }
}

GLuint ArtefactSuppressor::suppress(int width, int height) {
  switch (variant_) {
    case ArtefactSuppression::none:
      break;
    case ArtefactSuppression::diamond:
      return diamond(width, height);
    case ArtefactSuppression::alternating:
      return alternating(width, height);
    case ArtefactSuppression::progressive:
      return progressive(width, height);
  }
  return alpha();
}

GLuint ArtefactSuppressor::diamond(int width, int height) {
  glUseProgram(diamond_.id());
  glUniform2i(0, width, height);
  glUniform1f(1, static_cast<float>(alpha_c_));
  int current = 0;
  for (int pass = 0; pass < passes_; ++pass) {
    glBindTextureUnit(0, images_[current].id());
    current = 1 - current;
    bind_alpha_image(images_[current].id());
    dispatch_over(width, height);
    image_barrier();
  }
  return images_[current].id();
}

GLuint ArtefactSuppressor::alternating(int width, int height) {
  int current = 0;
  for (int pass = 0; pass < passes_; ++pass) {
    reduce(images_[current].id(), width, height, smaller_[0].id());
    enlarge(smaller_[0].id(), width, height, images_[current].id(), images_[1 - current].id());
    current = 1 - current;
  }
  return images_[current].id();
}

GLuint ArtefactSuppressor::progressive(int width, int height) {
  std::vector<std::pair<int, int>> sizes{{width, height}};
  for (int pass = 0; pass < passes_; ++pass) {
    const auto [w, h] = sizes.back();
    const auto level = static_cast<std::size_t>(pass);
    reduce(pass == 0 ? alpha() : smaller_[level - 1].id(), w, h, smaller_[level].id());
    sizes.emplace_back(half(w), half(h));
  }
  // Only the sizes of the levels between are needed on the way back, not what they held.
  for (auto level = static_cast<std::size_t>(passes_) - 1; level > 0; --level) {
    enlarge(smaller_[level].id(), sizes[level].first, sizes[level].second, 0, smaller_[level - 1].id());
  }
  enlarge(smaller_[0].id(), width, height, alpha(), images_[1].id());
  return images_[1].id();
}

void ArtefactSuppressor::reduce(GLuint fine, int width, int height, GLuint coarse) {
  glUseProgram(reduce_.id());
  glUniform2i(0, width, height);
  glUniform2i(1, half(width), half(height));
  glBindTextureUnit(0, fine);
  bind_alpha_image(coarse);
  dispatch_over(half(width), half(height));
  image_barrier();
}

void ArtefactSuppressor::enlarge(GLuint coarse, int width, int height, GLuint own, GLuint fine) {
  glUseProgram(enlarge_.id());
  glUniform2i(0, half(width), half(height));
  glUniform2i(1, width, height);
  glUniform1i(2, own != 0 ? 1 : 0);
  glBindTextureUnit(0, coarse);
  glBindTextureUnit(1, own != 0 ? own : coarse);
  bind_alpha_image(fine);
  dispatch_over(width, height);
  image_barrier();
}

}  // namespace foreview::per_polygon
