#include "foreview/gpu/batched/capture_marker.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "foreview/scene/polygon_geometry.h"

namespace foreview::batched {
namespace {

constexpr int kBlock = kChartAlignment;
constexpr GLuint kBlocksPerPatch = (kPatchTexels / kBlock) * (kPatchTexels / kBlock);
static_assert(kBlocksPerPatch == 4, "as in batched_capture.comp.glsl");
constexpr std::uint32_t kNone = 0xffffffff;

struct SampleOnGpu {
  glm::vec3 position{0};
  std::uint32_t polygon = kNone;
};

/// A block's texels, those nearest to its middle first.
std::vector<glm::ivec2> texels_from_the_middle() {
  std::vector<glm::ivec2> texels;
  for (int y = 0; y < kBlock; ++y) {
    for (int x = 0; x < kBlock; ++x) texels.emplace_back(x, y);
  }
  const auto distance = [](const glm::ivec2& t) {
    const glm::ivec2 from_middle = 2 * t + 1 - kBlock;
    return from_middle.x * from_middle.x + from_middle.y * from_middle.y;
  };
  std::ranges::stable_sort(texels, {}, distance);
  return texels;
}

class Samples {
 public:
  Samples(const PolygonModel& model, const ChartLayout& layout, const ChartGeometry& geometry)
      : model_(model), layout_(layout), geometry_(geometry), blocks_(layout.page_size / kBlock) {
    samples_.resize(layout.pages * static_cast<std::size_t>(blocks_) * static_cast<std::size_t>(blocks_));
    ranks_.assign(samples_.size(), kNone);
    for (std::uint32_t i = 0; i < model.polygons().size(); ++i) choose(i);
    for (const ChartGroup& group : layout.groups) spread(group);
  }
  [[nodiscard]] const SampleOnGpu& of(std::uint32_t page, const glm::ivec2& block) const {
    return samples_[slot(page, block)];
  }

 private:
  [[nodiscard]] std::size_t slot(std::uint32_t page, const glm::ivec2& block) const {
    return (static_cast<std::size_t>(page) * static_cast<std::size_t>(blocks_) + static_cast<std::size_t>(block.y)) *
               static_cast<std::size_t>(blocks_) +
           static_cast<std::size_t>(block.x);
  }
  [[nodiscard]] SampleOnGpu sample(std::uint32_t polygon, const glm::dvec2& texel) const {
    const glm::dvec3 centre = geometry_.part_centre(model_.polygons()[polygon].part);
    return {glm::vec3(layout_.charts[polygon].part_from_texel(texel) - centre), polygon};
  }

  void choose(std::uint32_t polygon) {
    const Chart& chart = layout_.charts[polygon];
    std::vector<glm::dvec2> corners;
    glm::dvec2 lower(1e300), upper(-1e300), middle(0);
    for (const std::uint32_t vertex : model_.corners_of(polygon)) {
      corners.push_back(chart.texel_from_part(model_.vertices()[vertex]));
      lower = glm::min(lower, corners.back());
      upper = glm::max(upper, corners.back());
      middle += corners.back();
    }
    middle /= static_cast<double>(corners.size());
    const glm::ivec2 chart_first = chart.origin / kBlock, chart_last = chart_first + chart.size / kBlock - 1;
    const auto block_of = [&](const glm::dvec2& p) {
      return glm::clamp(glm::ivec2(glm::floor(p / static_cast<double>(kBlock))), chart_first, chart_last);
    };
    const glm::ivec2 first = block_of(lower), last = block_of(upper);
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        const std::size_t at = slot(chart.page, {x, y});
        for (std::uint32_t rank = 0; rank < order_.size() && rank < ranks_[at]; ++rank) {
          const glm::dvec2 texel = glm::dvec2(glm::ivec2(x, y) * kBlock + order_[rank]) + 0.5;
          if (!is_inside_convex(corners, texel)) continue;
          ranks_[at] = rank;
          samples_[at] = sample(polygon, texel);
        }
      }
    }
    // For charts whose polygons have no texel's centre in them.
    const std::size_t at = slot(chart.page, block_of(middle));
    if (ranks_[at] == kNone) {
      ranks_[at] = kNone - 1;
      samples_[at] = sample(polygon, middle);
    }
  }

  /// To blocks without a sample, from the nearest ones that have one.
  void spread(const ChartGroup& group) {
    const glm::ivec2 first = group.origin / kBlock, end = first + group.size / kBlock;
    for (bool changed = true; changed;) {
      changed = false;
      const std::vector<std::uint32_t> before = ranks_of(group);
      const int columns = end.x - first.x;
      for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
          if (ranks_[slot(group.page, {x, y})] != kNone) continue;
          for (const glm::ivec2 step : {glm::ivec2(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
            const glm::ivec2 from = glm::ivec2(x, y) + step;
            if (from.x < first.x || from.y < first.y || from.x >= end.x || from.y >= end.y) continue;
            if (before[static_cast<std::size_t>((from.y - first.y) * columns + from.x - first.x)] == kNone) continue;
            samples_[slot(group.page, {x, y})] = samples_[slot(group.page, from)];
            ranks_[slot(group.page, {x, y})] = kNone - 1;
            changed = true;
            break;
          }
        }
      }
    }
  }
  [[nodiscard]] std::vector<std::uint32_t> ranks_of(const ChartGroup& group) const {
    const glm::ivec2 first = group.origin / kBlock, end = first + group.size / kBlock;
    std::vector<std::uint32_t> ranks;
    for (int y = first.y; y < end.y; ++y) {
      for (int x = first.x; x < end.x; ++x) ranks.push_back(ranks_[slot(group.page, {x, y})]);
    }
    return ranks;
  }

  const PolygonModel& model_;
  const ChartLayout& layout_;
  const ChartGeometry& geometry_;
  const int blocks_;
  const std::vector<glm::ivec2> order_ = texels_from_the_middle();
  std::vector<SampleOnGpu> samples_;
  std::vector<std::uint32_t> ranks_;  ///< place of the sample's texel in order_; kNone: there is none
};

}  // namespace

CaptureMarker::CaptureMarker(const PolygonModel& model, const ChartLayout& layout, const ChartGeometry& geometry)
    : program_(make_compute_program("batched_capture.comp.glsl")),
      samples_(GlBuffer::create()),
      late_charts_(GlBuffer::create()),
      late_bits_((layout.groups.size() + 31) / 32 + 1) {
  const Samples chosen(model, layout, geometry);
  std::vector<SampleOnGpu> samples;
  for (const ChartGeometry::Patch& patch : geometry.patches()) {
    for (const glm::ivec2 block : {glm::ivec2(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
      const bool exists = block.x * kBlock < patch.size.x && block.y * kBlock < patch.size.y;
      const std::uint32_t page = layout.groups[patch.chart].page;
      samples.push_back(exists ? chosen.of(page, patch.origin / kBlock + block) : SampleOnGpu());
    }
  }
  glNamedBufferStorage(samples_.id(),
                       static_cast<GLsizeiptr>(std::max<std::size_t>(samples.size(), 1) * sizeof(SampleOnGpu)),
                       samples.empty() ? nullptr : samples.data(), 0);
  glNamedBufferStorage(late_charts_.id(), static_cast<GLsizeiptr>(late_bits_.size() * sizeof(GLuint)), nullptr,
                       GL_DYNAMIC_STORAGE_BIT);
}

void CaptureMarker::mark(GLuint capture_times, std::int32_t time, const PictureSetup& setup,
                         const std::vector<bool>& is_late, const CameraModel& camera, double near_plane,
                         const PictureBounds& bounds, const PatchLists& patches, const std::optional<Run>& groups) {
  if (camera.width < 2 || camera.height < 2 || patches.candidate_count() == 0) return;
  bool any_late = false;
  std::ranges::fill(late_bits_, 0U);
  for (const std::uint32_t chart : setup.charts()) {
    if (!is_late[chart]) continue;
    late_bits_[chart / 32] |= 1U << chart % 32;
    any_late = true;
  }
  if (any_late) {
    glNamedBufferSubData(late_charts_.id(), 0, static_cast<GLsizeiptr>(late_bits_.size() * sizeof(GLuint)),
                         late_bits_.data());
  }
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 13, samples_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 14, late_charts_.id());
  glBindTextureUnit(1, bounds.cells());
  glBindImageTexture(0, capture_times, 0, GL_TRUE, 0, GL_READ_WRITE, GL_R32I);
  glUseProgram(program_.id());
  glUniform2f(0, static_cast<float>(camera.focal_length.x), static_cast<float>(camera.focal_length.y));
  glUniform2f(1, static_cast<float>(camera.principal_point.x), static_cast<float>(camera.principal_point.y));
  glUniform2f(2, static_cast<float>(camera.width), static_cast<float>(camera.height));
  glUniform1f(3, static_cast<float>(near_plane));
  glUniform1i(4, time);
  glUniform1i(5, any_late ? 1 : 0);
  patches.dispatch_touched(groups);
}

}  // namespace foreview::batched
