#include "foreview/gpu/texture_store.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>
#include <string>
#include <utility>

#include "foreview/gpu/draw_tally.h"
#include "foreview/scene/errors.h"

namespace foreview {

static_assert(kChartAlignment == 16 && kChartLevels == 5, "chart_levels.comp.glsl makes levels 1..4 of 16 x 16 blocks");
static_assert(sizeof(TextureStore::PolygonState) == 16, "a vec4 in std430");

namespace {

constexpr unsigned kPassesPerCheck = 16;
/// Fewest that GL guarantees along an axis of a dispatch is 65535.
constexpr std::size_t kGroupsPerRow = 1024, kGroupsPerDispatch = kGroupsPerRow * 1024;

GlBuffer make_buffer(const void* data, std::size_t bytes, GLbitfield flags) {
  GlBuffer buffer = GlBuffer::create();
  // A buffer of no bytes is an error, and a model without any neighbours is none.
  static constexpr std::uint32_t kNothing = 0;
  glNamedBufferStorage(buffer.id(), static_cast<GLsizeiptr>(std::max<std::size_t>(bytes, sizeof kNothing)),
                       bytes == 0 ? &kNothing : data, flags);
  return buffer;
}

std::uint32_t pack_block(int column, int row, std::uint32_t page) {
  return static_cast<std::uint32_t>(column) | static_cast<std::uint32_t>(row) << 10 | page << 20;
}

void check_limits(const ChartLayout& layout) {
  GLint max_size = 0, max_layers = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &max_size);
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &max_layers);
  // What chart_levels.comp.glsl can address.
  max_size = std::min(max_size, 1024 * kChartAlignment);
  max_layers = std::min(max_layers, 4096);
  if (layout.page_size > max_size) {
    throw InputError("texture pages", "a page of " + std::to_string(layout.page_size) + " x " +
                                          std::to_string(layout.page_size) +
                                          " texels is larger than this graphics driver's limit of " +
                                          std::to_string(max_size) + "; use fewer texels per polygon (--max-texels)");
  }
  if (layout.pages > static_cast<std::uint32_t>(max_layers)) {
    throw InputError("texture pages", std::to_string(layout.pages) + " pages are more than this graphics driver's " +
                                          std::to_string(max_layers) + "; use a lower density (--density)");
  }
}

}  // namespace

struct TextureStore::Tools {
  GlProgram levels = make_compute_program("chart_levels.comp.glsl");
  GlProgram spread_begin = make_compute_program("spread_begin.comp.glsl");
  GlProgram spread_pass = make_compute_program("spread_pass.comp.glsl");
  GlProgram spread_end = make_compute_program("spread_end.comp.glsl");
  GlBuffer blocks, first_neighbour, neighbours, rims, changed;
  std::vector<std::uint32_t> block_list, group_list;
};

TextureStore::TextureStore(const PolygonModel& model, ChartLayout layout) : model_(model), layout_(std::move(layout)) {
  const std::size_t polygons = model_.polygons().size();
  assert(layout_.charts.size() == polygons);
  assert(layout_.page_size % kChartAlignment == 0 && layout_.pages > 0);
  check_limits(layout_);

  while (glGetError() != GL_NO_ERROR) {
  }
  pages_ = make_texture_2d_array(GL_RGBA8, layout_.page_size, layout_.page_size, static_cast<int>(layout_.pages),
                                 kChartLevels);
  if (glGetError() == GL_OUT_OF_MEMORY) {
    throw GraphicsError("the graphics memory does not hold " + std::to_string(layout_.memory_bytes >> 20) +
                        " MiB of texture pages; use a lower density (--density)");
  }
  glTextureParameteri(pages_.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(pages_.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);

  tools_ = std::make_unique<Tools>();
  polygon_states_ = make_buffer(nullptr, polygons * sizeof(PolygonState), GL_DYNAMIC_STORAGE_BIT);
  std::size_t blocks = 0;
  assert(layout_.members.size() == polygons && layout_.outline.size() == model_.corners().size());
  for (const ChartGroup& chart : layout_.groups) {
    assert(chart.origin.x % kChartAlignment == 0 && chart.origin.y % kChartAlignment == 0);
    assert(chart.size.x % kChartAlignment == 0 && chart.size.y % kChartAlignment == 0);
    assert(chart.page < layout_.pages && chart.origin.x + chart.size.x <= layout_.page_size &&
           chart.origin.y + chart.size.y <= layout_.page_size);
    blocks += static_cast<std::size_t>(chart.size.x / kChartAlignment * (chart.size.y / kChartAlignment));
  }
  tools_->block_list.reserve(blocks);
  tools_->blocks = make_buffer(nullptr, blocks * sizeof(std::uint32_t), GL_DYNAMIC_STORAGE_BIT);

  std::vector<std::uint32_t> first, neighbours;
  for (std::size_t i = 0; i < polygons; ++i) {
    first.push_back(static_cast<std::uint32_t>(neighbours.size()));
    const auto own = model_.neighbours_of(i);
    neighbours.insert(neighbours.end(), own.begin(), own.end());
  }
  first.push_back(static_cast<std::uint32_t>(neighbours.size()));
  tools_->first_neighbour = make_buffer(first.data(), first.size() * sizeof(std::uint32_t), 0);
  tools_->neighbours = make_buffer(neighbours.data(), neighbours.size() * sizeof(std::uint32_t), 0);
  tools_->rims = make_buffer(nullptr, polygons * sizeof(std::uint32_t), 0);
  tools_->changed = make_buffer(nullptr, (polygons + kPassesPerCheck + 1) * sizeof(std::uint32_t), 0);
  clear();
}

TextureStore::~TextureStore() = default;

void TextureStore::clear() {
  for (int level = 0; level < kChartLevels; ++level) {
    glClearTexImage(pages_.id(), level, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  }
  const PolygonState unseen{0.5F, 0.5F, 0.5F, 0.0F};
  glClearNamedBufferData(polygon_states_.id(), GL_RGBA32F, GL_RGBA, GL_FLOAT, &unseen);
}

void TextureStore::update_levels(const std::vector<std::uint32_t>& polygons) {
  std::vector<std::uint32_t>& blocks = tools_->block_list;
  blocks.clear();
  std::vector<std::uint32_t>& groups = tools_->group_list;
  groups.clear();
  for (const std::uint32_t polygon : polygons) groups.push_back(layout_.charts[polygon].group);
  std::sort(groups.begin(), groups.end());
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  for (const std::uint32_t group : groups) {
    const ChartGroup& chart = layout_.groups[group];
    const glm::ivec2 first = chart.origin / kChartAlignment, count = chart.size / kChartAlignment;
    for (int y = 0; y < count.y; ++y) {
      for (int x = 0; x < count.x; ++x) blocks.push_back(pack_block(first.x + x, first.y + y, chart.page));
    }
  }
  if (blocks.empty()) return;
  glNamedBufferSubData(tools_->blocks.id(), 0, static_cast<GLsizeiptr>(blocks.size() * sizeof(std::uint32_t)),
                       blocks.data());
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
  glUseProgram(tools_->levels.id());
  glBindTextureUnit(0, pages_.id());
  glBindSampler(0, 0);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, tools_->blocks.id());
  for (int level = 1; level < kChartLevels; ++level) {
    glBindImageTexture(static_cast<GLuint>(level - 1), pages_.id(), level, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA8);
  }
  for (std::size_t first = 0; first < blocks.size(); first += kGroupsPerDispatch) {
    const std::size_t count = std::min(kGroupsPerDispatch, blocks.size() - first);
    const std::size_t columns = std::min(count, kGroupsPerRow);
    glUniform1ui(0, static_cast<GLuint>(first));
    glUniform1ui(1, static_cast<GLuint>(count));
    count_draw();
    glDispatchCompute(static_cast<GLuint>(columns), static_cast<GLuint>((count + columns - 1) / columns), 1);
  }
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT |
                  GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

void TextureStore::spread_to_never_seen() {
  const auto polygons = static_cast<GLuint>(model_.polygons().size());
  const GLuint groups = (polygons + 63) / 64;
  const std::array<GLuint, 5> buffers{polygon_states_.id(), tools_->first_neighbour.id(), tools_->neighbours.id(),
                                      tools_->rims.id(), tools_->changed.id()};
  for (GLuint i = 0; i < buffers.size(); ++i) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffers[i]);
  glClearNamedBufferData(tools_->changed.id(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr);

  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  glUseProgram(tools_->spread_begin.id());
  glUniform1ui(0, polygons);
  count_draw();
  glDispatchCompute(groups, 1, 1);

  glUseProgram(tools_->spread_pass.id());
  glUniform1ui(0, polygons);
  // Every pass but the last colours at least one polygon, so there are never more passes than polygons.
  for (GLuint pass = 1; pass <= polygons; ++pass) {
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    glUniform1ui(1, pass);
    count_draw();
    glDispatchCompute(groups, 1, 1);
    if (pass % kPassesPerCheck == 0) {
      glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
      GLuint changed = 0;
      glGetNamedBufferSubData(tools_->changed.id(), static_cast<GLintptr>(pass * sizeof changed), sizeof changed,
                              &changed);
      if (changed == 0) break;
    }
  }

  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  glUseProgram(tools_->spread_end.id());
  glUniform1ui(0, polygons);
  count_draw();
  glDispatchCompute(1, 1, 1);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

std::vector<cv::Mat> TextureStore::read_pages() const {
  glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
  std::vector<cv::Mat> pages;
  for (std::uint32_t page = 0; page < layout_.pages; ++page) {
    cv::Mat& picture = pages.emplace_back(layout_.page_size, layout_.page_size, CV_8UC4);
    glGetTextureSubImage(pages_.id(), 0, 0, 0, static_cast<GLint>(page), layout_.page_size, layout_.page_size, 1,
                         GL_BGRA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(picture.total() * 4), picture.data);
  }
  return pages;
}

std::vector<TextureStore::PolygonState> TextureStore::read_polygon_states() const {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  std::vector<PolygonState> states(model_.polygons().size());
  glGetNamedBufferSubData(polygon_states_.id(), 0, static_cast<GLsizeiptr>(states.size() * sizeof(PolygonState)),
                          states.data());
  return states;
}

void TextureStore::write_pages(const std::vector<cv::Mat>& pages, const std::vector<PolygonState>& states) {
  assert(pages.size() == layout_.pages && states.size() == model_.polygons().size());
  glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  for (std::uint32_t page = 0; page < layout_.pages; ++page) {
    const cv::Mat& picture = pages[page];
    assert(picture.type() == CV_8UC4 && picture.isContinuous());
    assert(picture.rows == layout_.page_size && picture.cols == layout_.page_size);
    glTextureSubImage3D(pages_.id(), 0, 0, 0, static_cast<GLint>(page), layout_.page_size, layout_.page_size, 1,
                        GL_BGRA, GL_UNSIGNED_BYTE, picture.data);
  }
  glNamedBufferSubData(polygon_states_.id(), 0, static_cast<GLsizeiptr>(states.size() * sizeof(PolygonState)),
                       states.data());
  std::vector<std::uint32_t> all(model_.polygons().size());
  std::iota(all.begin(), all.end(), 0U);
  update_levels(all);
}

std::size_t TextureStore::count_observed_texels() const {
  std::size_t observed = 0;
  for (const cv::Mat& page : read_pages()) {
    observed += static_cast<std::size_t>(
        std::count_if(page.begin<cv::Vec4b>(), page.end<cv::Vec4b>(), [](const cv::Vec4b& t) { return t[3] == 255; }));
  }
  return observed;
}

}  // namespace foreview
