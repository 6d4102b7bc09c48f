#include "foreview/viewer/gap_filler.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace foreview {
namespace {

constexpr std::size_t kMostLevels = 7;  ///< what is further away than 2^7 pixels has nothing to say
constexpr double kCracksOfHeight = 30;
constexpr std::array<GLenum, 2> kBoth{GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
constexpr GLuint kUnits = 4;

/// The level whose pixels are as wide as a crack may be.
std::size_t crack_level(int height, std::size_t levels) {
  const double level = std::round(std::log2(std::max(2.0, height / kCracksOfHeight)));
  return std::min(static_cast<std::size_t>(level), levels) - 1;
}

}  // namespace

GapFiller::GapFiller()
    : first_pull_(make_program("fullscreen.vert.glsl", "view_gap_pull.frag.glsl", "#define FIRST 1\n")),
      pull_(make_program("fullscreen.vert.glsl", "view_gap_pull.frag.glsl")),
      push_(make_program("fullscreen.vert.glsl", "view_gap_push.frag.glsl")),
      finish_(make_program("fullscreen.vert.glsl", "view_gap_finish.frag.glsl")),
      sampler_(make_clamped_sampler()),
      no_vertices_(GlVertexArray::create()) {}

void GapFiller::resize(int width, int height) {
  if (width == width_ && height == height_) return;
  view_ = make_texture_2d(GL_RGBA8, width, height);
  view_depth_ = make_texture_2d(GL_DEPTH_COMPONENT32F, width, height);
  into_view_ = make_framebuffer(view_.id(), view_depth_.id());
  levels_.clear();
  width_ = width;
  height_ = height;
  while (levels_.empty() || (levels_.size() < kMostLevels && std::max(width, height) > 1)) {
    Level level;
    level.width = width = (width + 1) / 2;
    level.height = height = (height + 1) / 2;
    level.pulled = make_texture_2d(GL_RGBA32F, width, height);
    level.pulled_depth = make_texture_2d(GL_RG32F, width, height);
    level.filled = make_texture_2d(GL_RGBA16F, width, height);
    level.into_pulled = make_framebuffer(level.pulled.id());
    glNamedFramebufferTexture(level.into_pulled.id(), GL_COLOR_ATTACHMENT1, level.pulled_depth.id(), 0);
    glNamedFramebufferDrawBuffers(level.into_pulled.id(), 2, kBoth.data());
    level.into_filled = make_framebuffer(level.filled.id());
    levels_.push_back(std::move(level));
  }
}

void GapFiller::fill(GLuint framebuffer, int first_x, int end_x, int y, int height, bool unseen) {
  if (end_x <= first_x || height < 1) return;
  resize(end_x - first_x, height);
  glBlitNamedFramebuffer(framebuffer, into_view_.id(), first_x, y, end_x, y + height, 0, 0, width_, height_,
                         GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT, GL_NEAREST);
  for (GLuint unit = 0; unit < kUnits; ++unit) glBindSampler(unit, sampler_.id());
  glBindVertexArray(no_vertices_.id());
  const auto draw = [](const Level& level, const GlFramebuffer& into, const GlProgram& program) {
    glBindFramebuffer(GL_FRAMEBUFFER, into.id());
    glViewport(0, 0, level.width, level.height);
    glUseProgram(program.id());
    glDrawArrays(GL_TRIANGLES, 0, 3);
  };
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    glBindTextureUnit(0, i == 0 ? view_.id() : levels_[i - 1].pulled.id());
    glBindTextureUnit(1, i == 0 ? view_depth_.id() : levels_[i - 1].pulled_depth.id());
    draw(levels_[i], levels_[i].into_pulled, i == 0 ? first_pull_ : pull_);
  }
  for (std::size_t i = levels_.size(); i-- > 0;) {
    const bool has_coarser = i + 1 < levels_.size();
    glBindTextureUnit(0, levels_[i].pulled.id());
    glBindTextureUnit(1, levels_[i].pulled_depth.id());
    glBindTextureUnit(2, has_coarser ? levels_[i + 1].filled.id() : 0);
    glProgramUniform1i(push_.id(), 0, has_coarser ? 1 : 0);
    draw(levels_[i], levels_[i].into_filled, push_);
  }
  glBindTextureUnit(0, view_.id());
  glBindTextureUnit(1, view_depth_.id());
  glBindTextureUnit(2, levels_.front().filled.id());
  glBindTextureUnit(3, levels_[crack_level(height, levels_.size())].pulled_depth.id());
  glProgramUniform2i(finish_.id(), 0, first_x, y);
  glProgramUniform1i(finish_.id(), 1, unseen ? 1 : 0);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(first_x, y, width_, height_);
  glUseProgram(finish_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);

  glScissor(first_x, y, width_, height_);
  glEnable(GL_SCISSOR_TEST);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_TRUE);
  glClearColor(0, 0, 0, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDisable(GL_SCISSOR_TEST);
  for (GLuint unit = 0; unit < kUnits; ++unit) glBindSampler(unit, 0);
  glBindVertexArray(0);
  glUseProgram(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

}  // namespace foreview
