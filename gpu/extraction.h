#pragma once
#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "foreview/scene/camera_frame.h"
#include "foreview/scene/chart_layout.h"

namespace foreview {

class TextureStore;

enum class PipelineKind { batched, per_polygon };                            ///< design 5
enum class ArtefactSuppression { none, diamond, alternating, progressive };  ///< spec 5
enum class HoleFilling { none, pyramid, iterative };                         ///< spec 9

struct ExtractionOptions {
  ArtefactSuppression artefacts = ArtefactSuppression::diamond;
  int passes = 3;          ///< diamond passes, or n of the bilinear variants
  double alpha_c = 3.5;    ///< diamond threshold on the sum of four alphas; 3 <= alpha_c < 3.875 (spec 5)
  int small_texture = 12;  ///< pixels: a perspective texture with a shorter side is not suppressed (would vanish)
  HoleFilling fill = HoleFilling::pyramid;
  bool occlusion_query = true;  ///< iterative filling: stop when a pass changed nothing, asked by an occlusion query
  double near_plane = 0.02;     ///< metres
  /// Rule 5 of BatchedExtraction; the per-polygon pipeline has nothing like it. Off unless asked for, as the commands
  /// do.
  bool compensate_exposure = false;
  /// Throws InputError naming the option that is out of its range.
  void validate() const;
};

/// The steps of spec 12's table, for timings. A pipeline that does several in one pass books them under the first.
enum class ExtractionStep {
  upload,         ///< picture to the GPU, undistortion
  projection,     ///< which polygons are in the picture, and where ("perspective texture")
  occlusion,      ///< depth and owner; per polygon also the mask
  suppression,    ///< artefact suppression, occluders' contours
  normalisation,  ///< normalisation and scaling; here with fusion, in one pass
  fusion,         ///< only where it is a pass of its own
  filling,        ///< holes, and the levels of the charts
  publishing,     ///< bringing an older set of textures up to date, handing over the new one
  other,
};
inline constexpr std::size_t kExtractionSteps = 9;
[[nodiscard]] const char* to_string(ExtractionStep step);

/// How steps are timed.
enum class ExtractionTiming {
  off,      ///< not at all: nothing waits
  finish,   ///< glFinish and wall clock after every step: true everywhere, but steps cannot overlap
  queries,  ///< GL timestamps, read at the picture's end; only where timer_queries_are_truthful()
};

/// One step of one picture, in milliseconds since extract() was entered.
struct StepSpan {
  ExtractionStep step = ExtractionStep::other;
  double cpu_begin = 0, cpu_end = 0;  ///< issuing its commands
  double gpu_begin = 0, gpu_end = 0;  ///< carrying them out; with `finish` from the first command to the finish
};

/// What became of one picture.
struct ExtractionStatistics {
  std::size_t polygons_visible = 0;  ///< front faces with a part in the picture, whose textures were touched
  std::size_t polygons_skipped_back_face = 0, polygons_skipped_outside = 0, polygons_skipped_too_small = 0;
  std::size_t polygons_exempt_small = 0;  ///< not suppressed because of small_texture
  std::size_t charts_touched = 0;
  std::size_t texels_written = 0;  ///< that the extraction looked at, by area: all that it computed a position for
  std::size_t texels_filled = 0;   ///< that hole filling and the levels went over (level 0, whole blocks)
  /// Of texels_written those that took a colour, or (batched) would have, had a late picture not found one there; only
  /// counted when asked for (it costs a read-back); else 0.
  std::size_t texels_observed = 0;
  std::size_t passes = 0;      ///< draws and dispatches that a barrier or a change of target parts
  std::size_t draw_calls = 0;  ///< draws and dispatches
  /// Filled only when timing is switched on.
  std::array<double, kExtractionSteps> step_ms{};  ///< by ExtractionStep
  double total_ms = 0;
  std::vector<StepSpan> spans;  ///< in order; per polygon, a step occurs many times
  [[nodiscard]] double ms(ExtractionStep step) const { return step_ms[static_cast<std::size_t>(step)]; }
  /// Sums everything but the spans, which are dropped.
  ExtractionStatistics& operator+=(const ExtractionStatistics& other);
};

/// Turns delayed pictures into textures of the store's charts. One picture at a time; after extract() returns, all its
/// GL commands are issued and the store shows either all of the picture's textures or none. A GL context that shares
/// with the store's must be current.
class ExtractionPipeline {
 public:
  virtual ~ExtractionPipeline() = default;
  ExtractionPipeline() = default;
  ExtractionPipeline(const ExtractionPipeline&) = delete;
  ExtractionPipeline& operator=(const ExtractionPipeline&) = delete;
  /// Fuses the frame's picture. Newest wins by capture stamp: a frame older than what a polygon's texture already holds
  /// only fills what is not valid there.
  virtual ExtractionStatistics extract(const CameraFrame& frame) = 0;
  /// Forgets all that has been seen.
  virtual void clear() = 0;
  /// Takes over what the store's charts hold now (after textures were loaded from a file).
  virtual void adopt_store() = 0;
  /// Fill the statistics' times; anything but `off` slows the pipeline down.
  virtual void set_timing(ExtractionTiming timing) = 0;
  /// Fill texels_observed; waits for the GPU.
  virtual void set_counting(bool on) = 0;
};

/// `charts` are the options that the store was laid out with; the store must outlive the pipeline. Throws InputError
/// where the options are out of range, or ask the batched pipeline for a variant that only the per-polygon one has.
[[nodiscard]] std::unique_ptr<ExtractionPipeline> make_extraction_pipeline(PipelineKind kind, TextureStore& store,
                                                                           const ChartOptions& charts,
                                                                           const ExtractionOptions& options);

/// Throws InputError where the frame cannot be extracted from: no finite, positive focal length, poses that are not
/// finite, another number of parts than the model's.
void check_frame(const CameraFrame& frame, const PolygonModel& model);

}  // namespace foreview
