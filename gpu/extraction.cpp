#include "foreview/gpu/extraction.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include "foreview/gpu/batched/batched_extraction.h"
#include "foreview/gpu/per_polygon/per_polygon_extraction.h"
#include "foreview/gpu/texture_store.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/polygon_model.h"

namespace foreview {

void ExtractionOptions::validate() const {
  const auto refuse = [](const char* option, const std::string& value, const char* expected) {
    throw InputError(option, value + " is out of range; expected " + expected);
  };
  if (passes < 0 || passes > 64) refuse("--passes", std::to_string(passes), "0 to 64");
  // From 3.875 on, texels outside the polygon would eat into it; below 3 an invalid texel does not grow.
  if (!(alpha_c >= 3 && alpha_c < 3.875)) refuse("--alpha-c", std::to_string(alpha_c), "3 or more and below 3.875");
  if (small_texture < 0) refuse("--small-texture", std::to_string(small_texture), "0 or more pixels");
  if (!(near_plane >= 1e-4 && near_plane <= 100)) {
    refuse("--near-plane", std::to_string(near_plane), "0.0001 to 100 metres");
  }
}

const char* to_string(ExtractionStep step) {
  static constexpr const char* kNames[kExtractionSteps] = {
      "upload", "projection", "occlusion", "suppression", "normalisation", "fusion", "filling", "publishing", "other"};
  return kNames[static_cast<std::size_t>(step)];
}

ExtractionStatistics& ExtractionStatistics::operator+=(const ExtractionStatistics& other) {
  polygons_visible += other.polygons_visible;
  polygons_skipped_back_face += other.polygons_skipped_back_face;
  polygons_skipped_outside += other.polygons_skipped_outside;
  polygons_skipped_too_small += other.polygons_skipped_too_small;
  polygons_exempt_small += other.polygons_exempt_small;
  charts_touched += other.charts_touched;
  texels_written += other.texels_written;
  texels_filled += other.texels_filled;
  texels_observed += other.texels_observed;
  passes += other.passes;
  draw_calls += other.draw_calls;
  for (std::size_t i = 0; i < kExtractionSteps; ++i) step_ms[i] += other.step_ms[i];
  total_ms += other.total_ms;
  spans.clear();
  return *this;
}

std::span<const SliceKind> ExtractionPipeline::slice_kinds() const {
  static constexpr std::array<SliceKind, 1> kKinds{{{"picture", ExtractionStep::other, 0, 800, "pictures"}}};
  return kKinds;
}

void ExtractionPipeline::begin(CameraFrame frame) {
  assert(!is_busy());
  whole_picture_ = std::move(frame);
}

bool ExtractionPipeline::is_busy() const {
  return whole_picture_.has_value();
}

std::optional<ExtractionSlice> ExtractionPipeline::pending_slice() {
  if (!whole_picture_) return std::nullopt;
  return ExtractionSlice{0, 1, 1};
}

double ExtractionPipeline::run_slice(double /*size*/) {
  assert(is_busy());
  const CameraFrame frame = std::move(*whole_picture_);
  whole_picture_.reset();
  whole_picture_statistics_ = extract(frame);
  return 1;
}

const ExtractionStatistics& ExtractionPipeline::statistics() const {
  return whole_picture_statistics_;
}

std::unique_ptr<ExtractionPipeline> make_extraction_pipeline(PipelineKind kind, TextureStore& store,
                                                             const ChartOptions& charts,
                                                             const ExtractionOptions& options) {
  switch (kind) {
    case PipelineKind::per_polygon:
      return std::make_unique<PerPolygonExtraction>(store, charts, options);
    case PipelineKind::batched:
      break;
  }
  return std::make_unique<BatchedExtraction>(store, options);
}

namespace {

bool is_finite(const Pose& pose) {
  const glm::dquat& q = pose.rotation;
  const glm::dvec3& t = pose.translation;
  return std::isfinite(q.w + q.x + q.y + q.z) && std::isfinite(t.x + t.y + t.z);
}

}  // namespace

std::string name_of(const CameraFrame& frame) {
  return "picture at " + frame.state.stamp.to_string() + " s";
}

void check_frame(const CameraFrame& frame, const PolygonModel& model) {
  const CameraModel& camera = frame.camera;
  const std::string where = name_of(frame);
  if (!(camera.focal_length.x > 0 && camera.focal_length.y > 0) ||
      !std::isfinite(camera.focal_length.x + camera.focal_length.y + camera.principal_point.x +
                     camera.principal_point.y)) {
    throw InputError(where, "its camera has no finite, positive focal length and principal point");
  }
  if (frame.state.world_from_part.size() != model.parts().size()) {
    throw InputError(where, "comes with poses of " + std::to_string(frame.state.world_from_part.size()) +
                                " parts, expected the model's " + std::to_string(model.parts().size()));
  }
  if (!is_finite(frame.state.world_from_camera) || !std::ranges::all_of(frame.state.world_from_part, is_finite)) {
    throw InputError(where, "a pose of the camera or a part is not finite");
  }
}

}  // namespace foreview
