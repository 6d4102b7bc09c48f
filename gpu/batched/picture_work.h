#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "foreview/gpu/batched/capture_marker.h"
#include "foreview/gpu/batched/chart_geometry.h"
#include "foreview/gpu/batched/chart_pyramid.h"
#include "foreview/gpu/batched/chart_tables.h"
#include "foreview/gpu/batched/exposure_estimator.h"
#include "foreview/gpu/batched/gatherer.h"
#include "foreview/gpu/batched/page_targets.h"
#include "foreview/gpu/batched/patch_lists.h"
#include "foreview/gpu/batched/picture_bounds.h"
#include "foreview/gpu/batched/picture_setup.h"
#include "foreview/gpu/batched/slice_cursor.h"
#include "foreview/gpu/extraction.h"
#include "foreview/gpu/undistorter.h"

namespace foreview::batched {

/// All the work on a picture, step by step, in phases of passes: what BatchedExtraction issues, at once or in slices.
/// Each phase is a kind of slices. What is in the same phase is known beforehand, but for what the CPU counts in it;
/// what the GPU counts in one phase (how many patches are concerned) is known in the next.
class PictureWork {
 public:
  enum Phase : std::size_t {
    uploading,  ///< rule 0
    polygons,   ///< which are in the picture; on the CPU
    surfaces,   ///< rule 1
    contours,   ///< rules 2 to 4
    copying,    ///< a set of textures is chosen, and brought up to what the newest one holds
    patches,    ///< which are concerned; the picture's exposure
    gathering,  ///< rule 5, and when what was captured
    pulling,    ///< rule 6, the tips of rule 7, and which patches it concerns
    pushing,    ///< rule 7
    states,     ///< rule 8
  };
  static constexpr std::size_t kPhases = states + 1;
  [[nodiscard]] static std::span<const SliceKind> kinds();

  PictureWork(TextureStore& store, const ExtractionOptions& options);

  /// Takes a picture that check_frame() and Undistorter::check() agree with. `at_once`: each pass is going to be issued
  /// as a whole and without waiting; what the GPU counts stays on the GPU, and counts as one unit.
  void begin(CameraFrame frame, bool at_once);
  /// Enters the next phase. False, and nothing done, if that is `copying` and no set of textures is free. What was
  /// issued before must have been done, unless at_once.
  [[nodiscard]] bool enter(Phase phase);
  [[nodiscard]] SliceCursor& cursor() { return cursor_; }
  /// To be called before issue() where others may have changed the context's state since the last one.
  void resume();
  /// Issues what was taken from cursor().
  void issue(Phase phase, const SliceCursor::Piece& piece);
  /// After the last phase: hands the picture over.
  void end();
  /// Forgets all that was seen, but for the store's pages; and the picture, if one was begun.
  void forget();
  /// Of what the store's charts hold now; see BatchedExtraction::adopt_store().
  void adopt();
  /// Of the picture that was ended last: numbers of polygons, charts and texels. With counting it waits for the GPU.
  void describe(ExtractionStatistics& statistics) const;
  void set_counting(bool on);

  [[nodiscard]] const CameraModel& last_camera() const { return last_camera_; }
  [[nodiscard]] const PictureBounds& bounds() const { return bounds_; }
  [[nodiscard]] const Undistorter& undistorter() const { return undistorter_; }
  [[nodiscard]] const ChartPyramid& pyramid() const { return pyramid_; }
  [[nodiscard]] TextureStore& store() const { return store_; }

 private:
  [[nodiscard]] int diamond_passes() const;
  [[nodiscard]] const std::vector<std::uint32_t>& charts() const { return fills_all_ ? all_charts_ : setup_.charts(); }
  [[nodiscard]] std::vector<Pass> passes_of(Phase phase) const;
  void add_patch_passes(std::vector<Pass>& passes, PatchLists::List list, double texels) const;
  void compare_stamps();
  void issue_contours(std::size_t pass, const Run& run);
  void issue_patches(std::size_t pass, const Run& run);
  void issue_gathering(std::size_t pass, const Run& run);
  void issue_pulling(std::size_t pass, const Run& run);
  void issue_states(std::size_t pass, const Run& run);
  /// A run of units of `per_unit` things, of `total` in all.
  [[nodiscard]] static Run things(const Run& units, std::size_t per_unit, std::size_t total);
  [[nodiscard]] std::optional<Run> listed(const Run& units, PatchLists::List list) const;

  TextureStore& store_;
  ExtractionOptions options_;
  ChartGeometry geometry_;
  ChartTables tables_;
  PictureSetup setup_;
  Undistorter undistorter_;
  PictureBounds bounds_;
  PatchLists patches_;
  PageTargets pages_;
  Gatherer gatherer_;
  CaptureMarker marker_;
  ChartPyramid pyramid_;
  std::optional<ExposureEstimator> exposure_;  ///< none: off
  std::optional<Timestamp> newest_of_all_;
  std::vector<std::optional<Timestamp>> newest_;  ///< by chart
  std::vector<std::uint32_t> all_charts_, touched_polygons_;
  bool adopted_ = false;  ///< charts hold what others made: with the next picture all of them are filled
  bool counting_ = false;
  CameraModel last_camera_;

  // The current picture.
  CameraFrame frame_;
  bool at_once_ = false, fills_all_ = false, is_late_for_all_ = false;
  std::vector<bool> is_late_;  ///< by chart: it has been written from a newer picture
  SliceCursor cursor_;
  std::array<std::size_t, 3> lengths_{};  ///< of the patches' lists, unless at once
};

}  // namespace foreview::batched
