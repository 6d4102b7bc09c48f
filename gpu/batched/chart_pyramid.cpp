#include "foreview/gpu/batched/chart_pyramid.h"

#include <algorithm>
#include <string>

#include "foreview/gpu/draw_tally.h"

namespace foreview::batched {
namespace {

constexpr int kTop = kChartLevels - 1;  // the pages' last level; the tip is above

GlProgram make_layer_program(const char* vertex_file, const char* fragment_file, const char* defines = "") {
  return make_program(vertex_file, fragment_file, (std::string(layer_defines()) + defines).c_str());
}

std::size_t at(int level) {
  return static_cast<std::size_t>(level);
}

}  // namespace

ChartPyramid::ChartPyramid(const TextureStore& store, const ChartTables& tables, PatchLists& patches,
                           PageTargets& pages)
    : store_(store),
      tables_(tables),
      patches_(patches),
      pages_(pages),
      pull_(make_layer_program("batched_patch.vert.glsl", "batched_pull.frag.glsl")),
      pull_tip_(make_layer_program("batched_tip.vert.glsl", "batched_tip_pull.frag.glsl")),
      push_tip_(make_layer_program("batched_tip.vert.glsl", "batched_tip_push.frag.glsl")),
      push_last_(make_layer_program("batched_tip.vert.glsl", "batched_tip_push.frag.glsl", "#define LAST\n")),
      push_(make_layer_program("batched_patch.vert.glsl", "batched_push.frag.glsl")),
      push_base_(make_layer_program("batched_patch.vert.glsl", "batched_push.frag.glsl", "#define BASE\n")),
      states_(make_compute_program("batched_states.comp.glsl")),
      chart_list_(GlBuffer::create()),
      no_vertices_(GlVertexArray::create()),
      linear_(make_clamped_sampler()) {
  glNamedBufferStorage(chart_list_.id(),
                       static_cast<GLsizeiptr>(std::max<std::size_t>(store.layout().groups.size(), 4) * sizeof(GLuint)),
                       nullptr, GL_DYNAMIC_STORAGE_BIT);
  for (int level = 0; level <= tables.tip_level(); ++level) {
    pulled_.push_back(level > 0 ? make(level) : Texture());
    filled_.push_back(level >= kTop ? make(level) : Texture());
  }
  clear();
}

ChartPyramid::Texture ChartPyramid::make(int level) const {
  Texture made;
  const ChartLayout& layout = store_.layout();
  const glm::ivec2 size = level <= kTop ? glm::ivec2(layout.page_size >> level) : tables_.tip_size(level);
  made.width = size.x;
  made.height = size.y;
  made.layers = level <= kTop ? static_cast<int>(layout.pages) : 1;
  made.texture = make_texture_2d_array(GL_RGBA8, made.width, made.height, made.layers);
  made.targets = make_layer_targets(made.texture.id(), made.layers);
  return made;
}

void ChartPyramid::clear() {
  for (const auto* levels : {&pulled_, &filled_}) {
    for (const Texture& level : *levels) {
      if (level.layers > 0) glClearTexImage(level.texture.id(), 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
    }
  }
}

void ChartPyramid::draw_charts(int level, int other_level, const Texture& into, const Run& charts) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, chart_list_.id());
  glBindVertexArray(no_vertices_.id());
  glViewport(0, 0, into.width, into.height);
  glUniform1i(0, level);
  glUniform2f(1, 2.0F / static_cast<float>(into.width), 2.0F / static_cast<float>(into.height));
  glUniform1i(3, other_level);
  for (std::size_t page = 0; page < into.targets.size(); ++page) {
    glUniform1i(2, into.targets.size() > 1 ? static_cast<GLint>(page) : -1);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, into.targets[page].id());
    glDrawArrays(GL_TRIANGLES, static_cast<GLint>(6 * charts.first), static_cast<GLsizei>(6 * charts.count));
    count_draw();
  }
}

void ChartPyramid::pull(const std::vector<std::uint32_t>& charts, Pull how) {
  list(charts);
  for (int level = 1; level <= kTop; ++level) pull_level(level, how, std::nullopt);
  for (int pass = 0; pass < tables_.tip_level() - kTop; ++pass) draw_tip(pass, {0, charts_});
}

void ChartPyramid::list(const std::vector<std::uint32_t>& charts) {
  charts_ = charts.size();
  glNamedBufferSubData(chart_list_.id(), 0, static_cast<GLsizeiptr>(charts.size() * sizeof(GLuint)), charts.data());
}

void ChartPyramid::pull_level(int level, Pull how, const std::optional<Run>& patches) {
  glUseProgram(pull_.id());
  glBindTextureUnit(0, level == 1 ? pages_.level(0).view.id() : pulled_[at(level - 1)].texture.id());
  if (level < kTop) glBindTextureUnit(1, pages_.level(level).view.id());
  // What is full is shown as it is; the pages' last level comes with the tips.
  const Texture& into = pulled_[at(level)];
  patches_.draw(PatchLists::touched, level,
                how == Pull::show && level < kTop ? pages_.together(into.texture.id(), level) : into.targets, patches);
}

int ChartPyramid::tip_passes() const {
  return 2 * (tables_.tip_level() - kTop);
}

void ChartPyramid::draw_tip(int pass, const Run& charts) {
  if (charts.count == 0) return;
  const int tip = tables_.tip_level(), up = tip - kTop;
  if (pass < up) {
    const int level = kTop + 1 + pass;
    glUseProgram(pull_tip_.id());
    glUniform1i(4, level - 1 == kTop ? 1 : 0);
    glBindTextureUnit(0, pulled_[at(level - 1)].texture.id());
    draw_charts(level, level - 1, pulled_[at(level)], charts);
    return;
  }
  const int level = tip - 1 - (pass - up), coarser = level + 1;
  glUseProgram(level == kTop ? push_last_.id() : push_tip_.id());
  if (level == kTop) glBindTextureUnit(2, pages_.level(kTop).view.id());
  glBindTextureUnit(0, (coarser == tip ? pulled_ : filled_)[at(coarser)].texture.id());
  glBindTextureUnit(1, pulled_[at(level)].texture.id());
  draw_charts(level, coarser, filled_[at(level)], charts);
}

void ChartPyramid::renew(const Run& candidates) {
  patches_.renew(filled_[at(kTop)].texture.id(), pulled_[at(kTop)].texture.id(), store_.pages(), candidates);
}

void ChartPyramid::push_level(int level, const std::optional<Run>& patches) {
  glBindSampler(0, linear_.id());
  glUseProgram(level > 0 ? push_.id() : push_base_.id());
  glBindTextureUnit(0, pages_.level(level + 1).view.id());
  if (level > 0) glBindTextureUnit(1, pulled_[at(level)].texture.id());
  if (level == 0) {
    // Only where nothing is observed: alpha there is 0.
    glEnable(GL_BLEND);
    glBlendFuncSeparate(GL_ONE_MINUS_DST_ALPHA, GL_DST_ALPHA, GL_ZERO, GL_ONE);
  }
  const float texel = 1.0F / static_cast<float>(store_.layout().page_size >> (level + 1));
  glUniform2f(5, texel, texel);
  patches_.draw(level > 0 ? PatchLists::renewed : PatchLists::holed, level, pages_.level(level).targets, patches);
  glDisable(GL_BLEND);
  glBindSampler(0, 0);
}

void ChartPyramid::write_states(GLuint polygon_states) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 9, polygon_states);
  glUseProgram(states_.id());
  glUniform1i(0, tables_.tip_level());
  glBindTextureUnit(0, pulled_.back().texture.id());
  glDispatchCompute(static_cast<GLuint>((store_.model().polygons().size() + 63) / 64), 1, 1);
  count_draw();
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                  GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
}

std::vector<cv::Mat> ChartPyramid::read_pulled(int level) const {
  const Texture& from = pulled_[at(level)];
  std::vector<cv::Mat> pages;
  for (int layer = 0; layer < from.layers; ++layer) {
    cv::Mat& page = pages.emplace_back(from.height, from.width, CV_8UC4);
    glGetTextureSubImage(from.texture.id(), 0, 0, 0, layer, from.width, from.height, 1, GL_BGRA, GL_UNSIGNED_BYTE,
                         static_cast<GLsizei>(page.total() * 4), page.data);
  }
  return pages;
}

}  // namespace foreview::batched
