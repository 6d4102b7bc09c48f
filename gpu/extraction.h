#pragma once
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
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
  bool operator==(const ExtractionOptions&) const = default;
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

/// A kind of slices, and a first guess of what one costs on a software rasteriser (two cores): constant_ms +
/// per_unit_ms * size. What it costs here must be learnt (FrameSchedule does).
struct SliceKind {
  const char* name = "";
  ExtractionStep step = ExtractionStep::other;  ///< that its time belongs to
  double constant_ms = 0, per_unit_ms = 0;
  const char* unit = "";  ///< of sizes, such as "megapixels"
};

/// The work that is due next on a picture.
struct ExtractionSlice {
  std::size_t kind = 0;  ///< index into slice_kinds()
  double size = 0;       ///< all that is left of this step, in the kind's unit; more than 0
  double least = 0;      ///< the smallest piece of it that can be run; at most `size`
};

/// Turns delayed pictures into textures of the store's charts. One picture at a time, in one of two ways:
///
/// *At once*: after extract() returns, all its GL commands are issued.
///
/// *In slices*, between which the GPU is free for others (spec 10: the display's frames):
/// @code
///   pipeline.begin(frame);
///   while (pipeline.is_busy()) {
///     if (const auto slice = pipeline.pending_slice()) {
///       pipeline.run_slice(how much of it fits in now);
///       wait until the GPU has done it;
///     } else {
///       do something else: the textures to write into are still being displayed
///     }
///   }
/// @endcode
/// Both give the same textures, bit by bit, however a picture was cut. Either way the store shows all of a picture's
/// textures or none. A GL context that shares with the store's must be current; between slices others may be, and this
/// one's state may be changed.
class ExtractionPipeline {
 public:
  virtual ~ExtractionPipeline() = default;
  ExtractionPipeline() = default;
  ExtractionPipeline(const ExtractionPipeline&) = delete;
  ExtractionPipeline& operator=(const ExtractionPipeline&) = delete;
  /// Fuses the frame's picture. Newest wins by capture stamp: a frame older than what a polygon's texture already holds
  /// only fills what is not valid there.
  /// Not while is_busy().
  virtual ExtractionStatistics extract(const CameraFrame& frame) = 0;

  /// Fixed for life. By default there is one kind, a whole picture.
  [[nodiscard]] virtual std::span<const SliceKind> slice_kinds() const;
  /// Takes a picture in, to be extracted in slices; the rules are extract()'s. Next to nothing is issued to the GPU.
  /// Throws as extract() does, and then nothing is begun. Not while is_busy(). Whoever passes a picture on to others
  /// clones it: it must not change before the picture is finished.
  virtual void begin(CameraFrame frame);
  /// Whether a picture was begun, and neither finished nor abandoned.
  [[nodiscard]] virtual bool is_busy() const;
  /// What is due next. None if no picture is_busy(), or if it cannot go on just now, because the display still reads
  /// the textures that the picture would be written into (see TextureStore::begin_picture()): then ask again later.
  /// Never waits. What run_slice() was given last must have been done by the GPU.
  [[nodiscard]] virtual std::optional<ExtractionSlice> pending_slice();
  /// Issues a piece of the pending slice, at most `size` of it, but `least` at the least; returns the size issued. Only
  /// if there is a pending slice. The GPU has done it when a fence behind it has passed, or after glFinish().
  /// With the last one the picture is handed over to the store, and is_busy() ends.
  virtual double run_slice(double size);
  /// Of the last picture that was finished in slices. Its times are not filled in, and texels_filled and
  /// texels_observed only as far as they are known without waiting.
  [[nodiscard]] virtual const ExtractionStatistics& statistics() const;

  /// Forgets all that has been seen. A picture that was begun is abandoned: no texture will show anything of it.
  virtual void clear() = 0;
  /// Takes over what the store's charts hold now (after textures were loaded from a file). Not while is_busy(): before
  /// a store is written to by others, the picture must be finished, or abandoned by clear().
  virtual void adopt_store() = 0;
  /// Fill the statistics' times; anything but `off` slows the pipeline down.
  virtual void set_timing(ExtractionTiming timing) = 0;
  /// Fill texels_observed; waits for the GPU.
  virtual void set_counting(bool on) = 0;

 protected:
  /// Of pipelines that do not cut pictures up themselves: forgets the one that was begun.
  void abandon_whole_picture() { whole_picture_.reset(); }

 private:
  std::optional<CameraFrame> whole_picture_;
  ExtractionStatistics whole_picture_statistics_;
};

/// `charts` are the options that the store was laid out with; the store must outlive the pipeline. Throws InputError
/// where the options are out of range, or ask the batched pipeline for a variant that only the per-polygon one has.
[[nodiscard]] std::unique_ptr<ExtractionPipeline> make_extraction_pipeline(PipelineKind kind, TextureStore& store,
                                                                           const ChartOptions& charts,
                                                                           const ExtractionOptions& options);

/// How messages name a frame: "picture at 1.5 s".
[[nodiscard]] std::string name_of(const CameraFrame& frame);

/// Throws InputError where the frame cannot be extracted from: no finite, positive focal length, poses that are not
/// finite, another number of parts than the model's.
void check_frame(const CameraFrame& frame, const PolygonModel& model);

}  // namespace foreview
