#include "foreview/gpu/per_polygon/hole_filler.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "foreview/gpu/dispatch.h"

namespace foreview::per_polygon {

namespace {

constexpr int kTipTexels = 2030;  // of all levels together, as per_polygon_pyramid_tip.comp.glsl has room for

glm::ivec2 halved(const glm::ivec2& size) {
  return (size + 1) / 2;
}

bool fits_tip(glm::ivec2 size) {
  int texels = size.x * size.y;
  while (texels <= kTipTexels && (size.x > 1 || size.y > 1)) {
    size = halved(size);
    texels += size.x * size.y;
  }
  return texels <= kTipTexels;
}

}  // namespace

HoleFiller::HoleFiller(const ExtractionOptions& options, const PolygonModel& model, const PolygonTextures& textures)
    : variant_(options.fill),
      occlusion_query_(options.occlusion_query),
      pull_(make_compute_program("per_polygon_pull.comp.glsl")),
      tip_(make_compute_program("per_polygon_pyramid_tip.comp.glsl")),
      tip_base_(make_compute_program("per_polygon_pyramid_tip.comp.glsl", "#define BASE\n")),
      filled_(make_texture_2d(GL_RGBA8, textures.widest(), textures.highest())) {
  const int widest = textures.widest(), highest = textures.highest();
  collect_outlines(model, textures);
  // No smaller texture needs more levels than one that has the longest of both sides.
  for (glm::ivec2 size(widest, highest); !fits_tip(size);) {
    size = halved(size);
    levels_.push_back(make_texture_2d(GL_RGBA32F, size.x, size.y));
  }
  if (variant_ != HoleFilling::iterative) {
    push_ = make_compute_program("per_polygon_push.comp.glsl");
    push_base_ = make_compute_program("per_polygon_push.comp.glsl", "#define BASE\n");
    if (variant_ == HoleFilling::none) open_ = make_compute_program("per_polygon_open_holes.comp.glsl");
    return;
  }
  grey_ = make_compute_program("per_polygon_grey.comp.glsl");
  copy_ = make_program("fullscreen.vert.glsl", "per_polygon_iterate.frag.glsl", "#define COPY\n");
  iterate_ = make_program("fullscreen.vert.glsl", "per_polygon_iterate.frag.glsl");
  for (int i = 0; i < 2; ++i) {
    iterated_[i] = make_texture_2d(GL_RGBA32F, widest, highest);
    iterated_framebuffer_[i] = make_framebuffer(iterated_[i].id());
  }
  no_vertices_ = GlVertexArray::create();
  changed_ = GlOcclusionQuery::create();
}

void HoleFiller::collect_outlines(const PolygonModel& model, const PolygonTextures& textures) {
  std::vector<glm::vec4> edges;
  outlines_.resize(textures.size());
  for (std::size_t i = 0; i < outlines_.size(); ++i) {
    const PolygonTextures::Item& item = textures[i];
    Outline& outline = outlines_[i];
    outline.width = item.width;
    outline.height = item.height;
    if (variant_ != HoleFilling::none) continue;
    outline.first_edge = static_cast<int>(edges.size());
    outline.edges = static_cast<int>(model.polygons()[i].corner_count);
    std::vector<glm::dvec2> corners;
    glm::dvec2 middle(0);
    for (std::size_t k = 0; k < model.polygons()[i].corner_count; ++k) {
      corners.push_back(item.frame.plane_from_part(model.corner(i, k)) / item.frame.extent *
                        glm::dvec2(item.width, item.height));
      middle += corners.back() / static_cast<double>(model.polygons()[i].corner_count);
    }
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const glm::dvec2 along = corners[(k + 1) % corners.size()] - corners[k];
      glm::dvec2 inwards = glm::dvec2(-along.y, along.x) / std::max(glm::length(along), 1e-9);
      if (glm::dot(inwards, middle - corners[k]) < 0) inwards = -inwards;
      edges.emplace_back(inwards, -glm::dot(inwards, corners[k]), 0);
    }
  }
  if (edges.empty()) return;
  edges_ = GlBuffer::create();
  glNamedBufferStorage(edges_.id(), static_cast<GLsizeiptr>(edges.size() * sizeof(glm::vec4)), edges.data(), 0);
}

void HoleFiller::fill(GLuint fused, std::uint32_t polygon, GLuint states, bool write_state) {
  const Outline& outline = outlines_[polygon];
  const int width = outline.width, height = outline.height;
  if (variant_ == HoleFilling::iterative) iterate(fused, width, height);
  if (variant_ != HoleFilling::iterative || write_state) {
    run_pyramid(fused, width, height, states, write_state ? static_cast<int>(polygon) : -1);
  }
  if (variant_ == HoleFilling::none) open_holes(fused, outline);
}

void HoleFiller::run_pyramid(GLuint fused, int width, int height, GLuint states, int polygon) {
  // Up to a level that is small enough for one work group.
  std::size_t top = 0;
  glm::ivec2 size(width, height);
  std::vector<glm::ivec2> sizes{size};
  if (!fits_tip(size)) glUseProgram(pull_.id());
  while (!fits_tip(size)) {
    glUniform2i(0, size.x, size.y);
    size = halved(size);
    glUniform2i(1, size.x, size.y);
    glBindTextureUnit(0, top == 0 ? fused : levels_[top - 1].id());
    glBindImageTexture(0, levels_[top].id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    dispatch_over(size.x, size.y);
    image_barrier();
    sizes.push_back(size);
    ++top;
  }

  const bool down = variant_ != HoleFilling::iterative;
  glUseProgram(top == 0 ? tip_base_.id() : tip_.id());
  glUniform2i(0, size.x, size.y);
  glUniform1i(1, polygon);
  glUniform1i(2, down ? 1 : 0);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, states);
  if (top == 0) {
    glBindTextureUnit(0, fused);
    glBindImageTexture(0, filled_.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
  } else {
    glBindImageTexture(0, levels_[top - 1].id(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  }
  count_draw();
  glDispatchCompute(1, 1, 1);
  image_barrier();
  if (!down || top == 0) return;

  glUseProgram(push_.id());
  for (; top > 1; --top) {
    glUniform2i(0, sizes[top - 1].x, sizes[top - 1].y);
    glUniform2i(1, sizes[top].x, sizes[top].y);
    glBindTextureUnit(0, levels_[top - 1].id());
    glBindImageTexture(0, levels_[top - 2].id(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    dispatch_over(sizes[top - 1].x, sizes[top - 1].y);
    image_barrier();
  }
  glUseProgram(push_base_.id());
  glUniform2i(0, width, height);
  glUniform2i(1, sizes[1].x, sizes[1].y);
  glBindTextureUnit(0, levels_[0].id());
  glBindTextureUnit(1, fused);
  glBindImageTexture(0, filled_.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
  dispatch_over(width, height);
  image_barrier();
}

void HoleFiller::iterate(GLuint fused, int width, int height) {
  glMemoryBarrier(GL_FRAMEBUFFER_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glViewport(0, 0, width, height);
  glBindVertexArray(no_vertices_.id());
  glUseProgram(iterate_.id());
  glUniform2i(0, width, height);
  const auto draw = [this](const GlProgram& program) {
    glUseProgram(program.id());
    count_draw(&program == &copy_);  // into the copy's target
    glDrawArrays(GL_TRIANGLES, 0, 3);
  };
  int current = 0;
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, iterated_framebuffer_[current].id());
  glBindTextureUnit(0, fused);
  draw(copy_);
  // From one valid texel, this many passes reach the farthest corner (eq. 5.30).
  const int most = std::max(width, height) - 1;
  for (int pass = 0; pass < most; ++pass) {
    glBindTextureUnit(0, iterated_[current].id());
    current = 1 - current;
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, iterated_framebuffer_[current].id());
    draw(copy_);
    if (!occlusion_query_) {
      draw(iterate_);
      continue;
    }
    glBeginQuery(GL_ANY_SAMPLES_PASSED, changed_.id());
    draw(iterate_);
    glEndQuery(GL_ANY_SAMPLES_PASSED);
    GLuint any = 0;
    glGetQueryObjectuiv(changed_.id(), GL_QUERY_RESULT, &any);
    if (any == 0) break;
  }
  glBindVertexArray(0);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  paint_grey(iterated_[current].id(), fused, width, height);
}

void HoleFiller::open_holes(GLuint fused, const Outline& outline) {
  glUseProgram(open_.id());
  glUniform2i(0, outline.width, outline.height);
  glUniform2i(1, outline.first_edge, outline.edges);
  glBindTextureUnit(0, fused);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, edges_.id());
  glBindImageTexture(0, filled_.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
  dispatch_over(outline.width, outline.height);
  image_barrier();
}

void HoleFiller::paint_grey(GLuint colours, GLuint fused, int width, int height) {
  glUseProgram(grey_.id());
  glUniform2i(0, width, height);
  glBindTextureUnit(0, colours);
  glBindTextureUnit(1, fused);
  glBindImageTexture(0, filled_.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
  dispatch_over(width, height);
  image_barrier();
}

}  // namespace foreview::per_polygon
