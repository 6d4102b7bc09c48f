#include "foreview/gpu/batched/exposure_estimator.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "foreview/gpu/draw_tally.h"
#include "foreview/scene/polygon_geometry.h"

namespace foreview::batched {
namespace {

constexpr int kBlock = 16;  // texels along the side of what has one sample
constexpr int kBlocks = kPatchTexels / kBlock;
constexpr int kSamplesPerPatch = kBlocks * kBlocks;
constexpr std::uint32_t kNone = 0xffffffff;
constexpr GLuint kLeastSamples = 48;  // fewer tell nothing
constexpr std::size_t kBins = 128;

struct SampleOnGpu {
  glm::vec3 position{0};
  std::uint32_t polygon = kNone;
  glm::vec3 along_x{0};
  std::uint32_t texel = 0;
  glm::vec3 along_y{0};
  std::uint32_t unused = 0;
};

/// For each block of 16 x 16 texels, the texel of level kLevel near its middle that has a polygon under its centre,
/// best one that has the same under all of it.
std::vector<SampleOnGpu> choose_samples(const PolygonModel& model, const ChartLayout& layout,
                                        const ChartGeometry& geometry) {
  constexpr int kTexel = 1 << ExposureEstimator::kLevel;  // texels of level 0 along its side
  std::vector<SampleOnGpu> samples(geometry.patches().size() * kSamplesPerPatch);
  std::vector<double> costs(samples.size(), 1e300);
  for (std::uint32_t i = 0; i < model.polygons().size(); ++i) {
    const Chart& chart = layout.charts[i];
    std::vector<glm::dvec2> corners;
    glm::dvec2 lower(1e300), upper(-1e300);
    for (const std::uint32_t vertex : model.corners_of(i)) {
      corners.push_back(chart.texel_from_part(model.vertices()[vertex]));
      lower = glm::min(lower, corners.back());
      upper = glm::max(upper, corners.back());
    }
    const glm::ivec2 begin = glm::max(glm::ivec2(glm::floor(lower)), chart.origin) / kTexel;
    const glm::ivec2 end = (glm::min(glm::ivec2(glm::ceil(upper)), chart.origin + chart.size) + kTexel - 1) / kTexel;
    for (int y = begin.y; y < end.y; ++y) {
      for (int x = begin.x; x < end.x; ++x) {
        const glm::dvec2 centre = (glm::dvec2(x, y) + 0.5) * static_cast<double>(kTexel);
        const glm::ivec2 in_chart = glm::ivec2(x, y) * kTexel - chart.origin;
        const glm::ivec2 cell = in_chart / kPatchTexels, block = in_chart % kPatchTexels / kBlock;
        const int columns = patch_grid(chart.size).x;
        const std::size_t slot =
            (geometry.patches_of(chart.group).first + static_cast<std::size_t>(cell.y * columns + cell.x)) *
                kSamplesPerPatch +
            static_cast<std::size_t>(block.y * kBlocks + block.x);
        const glm::dvec2 middle = glm::dvec2(in_chart % kBlock) + 0.5 * kTexel - 0.5 * kBlock;
        double cost = glm::dot(middle, middle);
        // What decides most often comes first.
        if (cost >= costs[slot] || !is_inside_convex(corners, centre)) continue;
        for (const glm::dvec2 corner : {glm::dvec2(-0.5, -0.5), {0.5, -0.5}, {-0.5, 0.5}, {0.5, 0.5}}) {
          if (!is_inside_convex(corners, centre + corner * static_cast<double>(kTexel))) cost += 1000;
        }
        if (cost >= costs[slot]) continue;
        costs[slot] = cost;
        const glm::dvec3 position = chart.part_from_texel(centre);
        glm::dvec3 along_x = chart.part_from_texel(centre + glm::dvec2(0.25 * kTexel, 0)) - position;
        glm::dvec3 along_y = chart.part_from_texel(centre + glm::dvec2(0, 0.25 * kTexel)) - position;
        if (glm::dot(glm::cross(along_x, along_y), chart.normal) < 0) std::swap(along_x, along_y);
        const std::uint32_t part = model.polygons()[i].part;
        samples[slot] = {glm::vec3(position - geometry.part_centre(part)), i, glm::vec3(along_x),
                         static_cast<std::uint32_t>(x) | static_cast<std::uint32_t>(y) << 16, glm::vec3(along_y)};
      }
    }
  }
  return samples;
}

}  // namespace

ExposureEstimator::ExposureEstimator(const PolygonModel& model, const ChartLayout& layout,
                                     const ChartGeometry& geometry)
    : count_(make_compute_program("batched_exposure_count.comp.glsl")),
      gain_(make_compute_program("batched_exposure_gain.comp.glsl")),
      samples_(GlBuffer::create()),
      counts_(GlBuffer::create()),
      references_(GlBuffer::create()),
      linear_(make_clamped_sampler()) {
  const std::vector<SampleOnGpu> samples = choose_samples(model, layout, geometry);
  glNamedBufferStorage(samples_.id(),
                       static_cast<GLsizeiptr>(std::max<std::size_t>(samples.size(), 1) * sizeof(SampleOnGpu)),
                       samples.empty() ? nullptr : samples.data(), 0);
  glNamedBufferStorage(counts_.id(), (6 * kBins + 1) * sizeof(GLuint), nullptr, 0);
  glClearNamedBufferData(counts_.id(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr);
  glNamedBufferStorage(references_.id(),
                       static_cast<GLsizeiptr>(std::max<std::size_t>(samples.size(), 1) * 4 * sizeof(float)), nullptr,
                       0);
  clear();
}

void ExposureEstimator::clear() {
  // A picture may have been abandoned after some of it was counted.
  glClearNamedBufferData(counts_.id(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr);
  glClearNamedBufferData(references_.id(), GL_RGBA32F, GL_RGBA, GL_FLOAT, nullptr);
}

void ExposureEstimator::bind(GLuint exposure) const {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 11, counts_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 12, exposure);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 13, samples_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 14, references_.id());
}

void ExposureEstimator::count(const CameraModel& camera, double near_plane, GLuint undistorted,
                              const PictureBounds& bounds, const PatchLists& patches, GLuint observed, GLuint exposure,
                              const Run& candidates) {
  if (candidates.count == 0 || camera.width < 2 || camera.height < 2) return;
  bind(exposure);
  GLint room_width = 0, room_height = 0;
  glGetTextureLevelParameteriv(undistorted, 0, GL_TEXTURE_WIDTH, &room_width);
  glGetTextureLevelParameteriv(undistorted, 0, GL_TEXTURE_HEIGHT, &room_height);
  glUseProgram(count_.id());
  glUniform2f(0, static_cast<float>(camera.focal_length.x), static_cast<float>(camera.focal_length.y));
  glUniform2f(1, static_cast<float>(camera.principal_point.x), static_cast<float>(camera.principal_point.y));
  glUniform2f(2, static_cast<float>(camera.width), static_cast<float>(camera.height));
  glUniform1f(3, static_cast<float>(near_plane));
  glUniform1ui(4, static_cast<GLuint>(candidates.first + candidates.count));
  glUniform1ui(5, patches.picture_number());
  glUniform2f(6, 1.0F / static_cast<float>(room_width), 1.0F / static_cast<float>(room_height));
  glUniform2i(7, camera.width - 2, camera.height - 2);
  glBindTextureUnit(0, undistorted);
  glBindSampler(0, linear_.id());
  glBindTextureUnit(1, bounds.cells());
  glBindTextureUnit(2, observed);
  glUniform1ui(8, static_cast<GLuint>(candidates.first));
  const auto invocations = static_cast<GLuint>(candidates.count * kSamplesPerPatch);
  count_draw();
  glDispatchCompute((invocations + 63) / 64, 1, 1);
  glBindSampler(0, 0);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void ExposureEstimator::find_gain(GLuint exposure, bool is_late) {
  bind(exposure);
  glUseProgram(gain_.id());
  glUniform1ui(0, kLeastSamples);
  glUniform1i(1, is_late ? 1 : 0);
  count_draw();
  glDispatchCompute(1, 1, 1);
  glMemoryBarrier(GL_UNIFORM_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

}  // namespace foreview::batched
