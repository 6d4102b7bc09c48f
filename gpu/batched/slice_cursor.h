#pragma once
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "foreview/gpu/batched/patch_lists.h"
#include "foreview/gpu/extraction.h"

namespace foreview::batched {

/// A pass over things that are counted, such as rows of the picture.
struct Pass {
  ExtractionStep step = ExtractionStep::other;
  std::size_t units = 0;
  double unit_size = 1;  ///< in the unit of the slice's kind; more than 0
};

/// Where the extraction is in a sequence of passes, and how much of a given size comes next. Pure bookkeeping.
class SliceCursor {
 public:
  SliceCursor() = default;
  /// At the beginning of `passes`; those without units are left out.
  explicit SliceCursor(std::vector<Pass> passes) : passes_(std::move(passes)) { skip_empty(); }
  [[nodiscard]] bool is_at_end() const { return pass_ == passes_.size(); }
  /// Of all that is left, and of the next unit.
  [[nodiscard]] double left() const;
  [[nodiscard]] double least() const;
  struct Piece {
    std::size_t pass = 0;
    Run run;
    double size = 0;
  };
  /// Takes what comes next of the present pass: at most `size`, none if no unit fits. With `at_least_one` one unit
  /// whatever its size. Not at the end.
  [[nodiscard]] std::optional<Piece> take(double size, bool at_least_one);
  /// A pass that has not begun turns out to have another number of units; or, of the present one, so many are left.
  void set_units_left(std::size_t pass, std::size_t units);
  [[nodiscard]] const Pass& pass(std::size_t index) const { return passes_[index]; }
  /// The pass of what take() gives next. Not at the end.
  [[nodiscard]] const Pass& present() const { return passes_[pass_]; }

 private:
  void skip_empty();

  std::vector<Pass> passes_;
  std::size_t pass_ = 0, done_ = 0;  ///< the present pass, and its units taken
};

}  // namespace foreview::batched
