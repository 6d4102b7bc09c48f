#include "foreview/gpu/texture_store.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <numeric>
#include <opencv2/core.hpp>
#include <string>
#include <utility>

#include "foreview/gpu/chart_blocks.h"
#include "foreview/gpu/draw_tally.h"
#include "foreview/scene/errors.h"

namespace foreview {

static_assert(kChartAlignment == 16 && kChartLevels == 5, "chart_levels.comp.glsl makes levels 1..4 of 16 x 16 blocks");
static_assert(sizeof(TextureStore::PolygonState) == 16, "a vec4 in std430");

namespace {

/// Passes of spreading whose dispatch commands are in the buffer at once.
constexpr unsigned kPassesPerRound = 16;
/// As glDispatchComputeIndirect() reads it.
struct DispatchCommand {
  GLuint x = 0, y = 1, z = 1;
};
GlBuffer make_buffer(const void* data, std::size_t bytes, GLbitfield flags) {
  GlBuffer buffer = GlBuffer::create();
  // A buffer of no bytes is an error, and a model without any neighbours is none.
  static constexpr std::uint32_t kNothing = 0;
  glNamedBufferStorage(buffer.id(), static_cast<GLsizeiptr>(std::max<std::size_t>(bytes, sizeof kNothing)),
                       bytes == 0 ? &kNothing : data, flags);
  return buffer;
}

/// Workgroups of 64 for one invocation per polygon.
GLuint groups_of(std::size_t polygons) {
  return static_cast<GLuint>((polygons + 63) / 64);
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
  explicit Tools(const ChartLayout& layout) : blocks(layout) {}
  GlProgram levels = make_compute_program("chart_levels.comp.glsl");
  GlProgram spread_begin = make_compute_program("spread_begin.comp.glsl");
  GlProgram spread_pass = make_compute_program("spread_pass.comp.glsl");
  GlProgram spread_end = make_compute_program("spread_end.comp.glsl");
  ChartBlocks blocks;
  GlBuffer first_neighbour, neighbours, rims;
  GlBuffer first_commands;  ///< what `commands` begin as: the first pass for all polygons, no other pass
  GlBuffer commands;        ///< of the passes of a round, and of the first pass of the next
  std::vector<std::uint32_t> group_list;
};

TextureStore::TextureStore(const PolygonModel& model, ChartLayout layout, Publishing publishing, Making making)
    : model_(model), layout_(std::move(layout)) {
  const std::size_t polygons = model_.polygons().size();
  assert(layout_.charts.size() == polygons);
  assert(layout_.page_size % kChartAlignment == 0 && layout_.pages > 0);
  check_limits(layout_);

  sets_ = std::make_unique<TextureSets>(layout_, polygons, publishing, making);
  tools_ = std::make_unique<Tools>(layout_);
  assert(layout_.members.size() == polygons && layout_.outline.size() == model_.corners().size());
  for (const ChartGroup& chart : layout_.groups) {
    assert(chart.origin.x % kChartAlignment == 0 && chart.origin.y % kChartAlignment == 0);
    assert(chart.size.x % kChartAlignment == 0 && chart.size.y % kChartAlignment == 0);
    assert(chart.page < layout_.pages && chart.origin.x + chart.size.x <= layout_.page_size &&
           chart.origin.y + chart.size.y <= layout_.page_size);
  }

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
  std::array<DispatchCommand, kPassesPerRound + 1> commands;
  commands[0].x = groups_of(polygons);
  tools_->first_commands = make_buffer(commands.data(), sizeof commands, 0);
  tools_->commands = make_buffer(commands.data(), sizeof commands, 0);
}

TextureStore::~TextureStore() = default;

bool TextureStore::begin_picture() {
  return sets_->begin(TextureSets::Begin::update);
}

bool TextureStore::begin_picture_in_pieces() {
  return sets_->begin(TextureSets::Begin::later);
}

void TextureStore::wait_for_free_set() {
  sets_->wait_for_free_set();
}

void TextureStore::end_picture(const std::vector<std::uint32_t>& touched_polygons,
                               const std::optional<Timestamp>& captured) {
  sets_->end(touched_polygons, true, captured);
}

void TextureStore::set_capture_time(const std::vector<std::uint32_t>& polygons, std::int32_t time) {
  for (const std::uint32_t polygon : polygons) {
    const Chart& chart = layout_.charts[polygon];
    const glm::ivec2 first = chart.origin / kChartAlignment, size = chart.size / kChartAlignment;
    glClearTexSubImage(capture_times(), 0, first.x, first.y, static_cast<GLint>(chart.page), size.x, size.y, 1,
                       GL_RED_INTEGER, GL_INT, &time);
  }
}

template <class Write>
void TextureStore::publish(TextureSets::Begin how, const Write& write) {
  const bool inside_a_picture = sets_->is_writing();
  if (!inside_a_picture) {
    sets_->wait_for_free_set();
    // What is free stays so until it is begun: the display takes nothing but the newest complete set.
    [[maybe_unused]] const bool begun = sets_->begin(how);
    assert(begun);
  }
  write();
  if (!inside_a_picture) sets_->end({}, false);
}

void TextureStore::clear() {
  publish(TextureSets::Begin::replace, [&] {
    sets_->touch_all();
    sets_->clear();
  });
}

void TextureStore::update_levels(const std::vector<std::uint32_t>& polygons) {
  assert(sets_->is_writing() || sets_->publishing() == Publishing::direct);
  std::vector<std::uint32_t>& groups = tools_->group_list;
  groups.clear();
  for (const std::uint32_t polygon : polygons) groups.push_back(layout_.charts[polygon].group);
  std::sort(groups.begin(), groups.end());
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  ChartBlocks& blocks = tools_->blocks;
  blocks.list(groups);
  if (blocks.empty()) return;
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
  glUseProgram(tools_->levels.id());
  glBindTextureUnit(0, pages());
  glBindSampler(0, 0);
  for (int level = 1; level < kChartLevels; ++level) {
    glBindImageTexture(static_cast<GLuint>(level - 1), pages(), level, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA8);
  }
  blocks.dispatch();
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT |
                  GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

void TextureStore::spread_to_never_seen() {
  spread(static_cast<unsigned>(model_.polygons().size()), true);
}

void TextureStore::spread_to_never_seen(unsigned max_rims) {
  spread(max_rims, false);
}

void TextureStore::spread(unsigned max_rims, bool may_wait) {
  publish(TextureSets::Begin::update, [&] { spread_in_current_set(max_rims, may_wait); });
}

void TextureStore::bind_for_spreading() {
  const std::array<GLuint, 5> buffers{polygon_states(), tools_->first_neighbour.id(), tools_->neighbours.id(),
                                      tools_->rims.id(), tools_->commands.id()};
  for (GLuint i = 0; i < buffers.size(); ++i) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffers[i]);
}

void TextureStore::begin_spreading() {
  const std::size_t polygons = model_.polygons().size();
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  glUseProgram(tools_->spread_begin.id());
  glUniform1ui(0, static_cast<GLuint>(polygons));
  count_draw();
  glDispatchCompute(groups_of(polygons), 1, 1);
}

void TextureStore::spread_rims(unsigned first, unsigned count) {
  glUseProgram(tools_->spread_pass.id());
  glUniform1ui(0, static_cast<GLuint>(model_.polygons().size()));
  glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, tools_->commands.id());
  for (unsigned rim = first; rim < first + count; ++rim) {
    const unsigned pass = rim % kPassesPerRound;
    if (pass == 0) {
      glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
      glCopyNamedBufferSubData(tools_->first_commands.id(), tools_->commands.id(), 0, 0,
                               (kPassesPerRound + 1) * sizeof(DispatchCommand));
    }
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
    glUniform1ui(1, rim + 1);
    glUniform1ui(2, pass + 1);
    count_draw();
    glDispatchComputeIndirect(static_cast<GLintptr>(pass * sizeof(DispatchCommand)));
  }
  glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, 0);
}

void TextureStore::end_spreading() {
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  glUseProgram(tools_->spread_end.id());
  glUniform1ui(0, static_cast<GLuint>(model_.polygons().size()));
  count_draw();
  glDispatchCompute(1, 1, 1);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

void TextureStore::spread_in_current_set(unsigned max_rims, bool may_wait) {
  bind_for_spreading();
  begin_spreading();
  for (unsigned done = 0; done < max_rims;) {
    const unsigned passes = std::min(kPassesPerRound, max_rims - done);
    spread_rims(done, passes);
    done += passes;
    if (may_wait) {
      glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
      DispatchCommand next;
      glGetNamedBufferSubData(tools_->commands.id(), static_cast<GLintptr>(passes * sizeof next), sizeof next, &next);
      if (next.x == 0) break;
    }
  }
  end_spreading();
}

void TextureStore::spread_to_never_seen(unsigned max_rims, unsigned first_piece, unsigned pieces) {
  assert(sets_->is_writing() && first_piece + pieces <= spread_pieces(max_rims));
  bind_for_spreading();
  const unsigned end = first_piece + pieces;
  if (first_piece == 0 && pieces > 0) begin_spreading();
  const unsigned first_rim = std::max(first_piece, 1U), rims_end = std::min(end, max_rims + 1);
  if (first_rim < rims_end) spread_rims(first_rim - 1, rims_end - first_rim);
  if (end == spread_pieces(max_rims) && pieces > 0) end_spreading();
}

std::vector<cv::Mat> TextureStore::read_pages() const {
  glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
  std::vector<cv::Mat> result;
  for (std::uint32_t page = 0; page < layout_.pages; ++page) {
    cv::Mat& picture = result.emplace_back(layout_.page_size, layout_.page_size, CV_8UC4);
    glGetTextureSubImage(pages(), 0, 0, 0, static_cast<GLint>(page), layout_.page_size, layout_.page_size, 1, GL_BGRA,
                         GL_UNSIGNED_BYTE, static_cast<GLsizei>(picture.total() * 4), picture.data);
  }
  return result;
}

std::vector<TextureStore::PolygonState> TextureStore::read_polygon_states() const {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  std::vector<PolygonState> states(model_.polygons().size());
  glGetNamedBufferSubData(polygon_states(), 0, static_cast<GLsizeiptr>(states.size() * sizeof(PolygonState)),
                          states.data());
  return states;
}

Exposure TextureStore::read_exposure() const {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  Exposure result;
  glGetNamedBufferSubData(exposure(), 0, sizeof result, &result);
  return result;
}

std::vector<cv::Mat> TextureStore::read_capture_times() const {
  glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
  const int blocks = layout_.page_size / kChartAlignment;
  std::vector<cv::Mat> result;
  for (std::uint32_t page = 0; page < layout_.pages; ++page) {
    cv::Mat& times = result.emplace_back(blocks, blocks, CV_32S);
    glGetTextureSubImage(capture_times(), 0, 0, 0, static_cast<GLint>(page), blocks, blocks, 1, GL_RED_INTEGER, GL_INT,
                         static_cast<GLsizei>(times.total() * sizeof(std::int32_t)), times.data);
  }
  return result;
}

TextureStore::Contents TextureStore::read_as_shown() const {
  Contents contents{read_pages(), read_polygon_states()};
  const Exposure exposure = read_exposure();
  const auto& [red, green, blue, unused] = exposure.shown;
  if (red == 1 && green == 1 && blue == 1) return contents;
  cv::Mat table(1, 256, CV_8UC4);
  for (int i = 0; i < 256; ++i) {
    const auto shown = [i](float gain) {
      return cv::saturate_cast<std::uint8_t>(255 * exposed(static_cast<float>(i) / 255, gain));
    };
    table.at<cv::Vec4b>(0, i) = {shown(blue), shown(green), shown(red), static_cast<std::uint8_t>(i)};
  }
  for (cv::Mat& page : contents.pages) cv::LUT(page, table, page);
  for (PolygonState& state : contents.states) {
    state.red = std::min(exposed(state.red, red), 1.0F);
    state.green = std::min(exposed(state.green, green), 1.0F);
    state.blue = std::min(exposed(state.blue, blue), 1.0F);
  }
  return contents;
}

void TextureStore::write_pages(const std::vector<cv::Mat>& new_pages, const std::vector<PolygonState>& states) {
  assert(new_pages.size() == layout_.pages && states.size() == model_.polygons().size());
  publish(TextureSets::Begin::replace, [&] {
    sets_->touch_all();
    glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    for (std::uint32_t page = 0; page < layout_.pages; ++page) {
      const cv::Mat& picture = new_pages[page];
      assert(picture.type() == CV_8UC4 && picture.isContinuous());
      assert(picture.rows == layout_.page_size && picture.cols == layout_.page_size);
      glTextureSubImage3D(pages(), 0, 0, 0, static_cast<GLint>(page), layout_.page_size, layout_.page_size, 1, GL_BGRA,
                          GL_UNSIGNED_BYTE, picture.data);
    }
    glNamedBufferSubData(polygon_states(), 0, static_cast<GLsizeiptr>(states.size() * sizeof(PolygonState)),
                         states.data());
    constexpr Exposure kAsTheyAre;
    glNamedBufferSubData(exposure(), 0, sizeof kAsTheyAre, &kAsTheyAre);
    sets_->forget_capture_times();
    std::vector<std::uint32_t> all(model_.polygons().size());
    std::iota(all.begin(), all.end(), 0U);
    update_levels(all);
  });
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
