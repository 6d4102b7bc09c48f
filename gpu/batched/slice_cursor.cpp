#include "foreview/gpu/batched/slice_cursor.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace foreview::batched {

double SliceCursor::left() const {
  double sum = 0;
  for (std::size_t i = pass_; i < passes_.size(); ++i) {
    const std::size_t units = passes_[i].units - (i == pass_ ? done_ : 0);
    sum += static_cast<double>(units) * passes_[i].unit_size;
  }
  return sum;
}

double SliceCursor::least() const {
  return is_at_end() ? 0 : passes_[pass_].unit_size;
}

std::optional<SliceCursor::Piece> SliceCursor::take(double size, bool at_least_one) {
  assert(!is_at_end());
  const Pass& pass = passes_[pass_];
  const std::size_t left = pass.units - done_;
  // What was offered as a whole must be taken as a whole, whatever rounding does to the sum.
  const double fitting = std::floor(size / pass.unit_size * (1 + 1e-9));
  const std::size_t count = std::max<std::size_t>(
      fitting >= static_cast<double>(left) ? left : static_cast<std::size_t>(std::max(fitting, 0.0)),
      at_least_one ? 1 : 0);
  if (count == 0) return std::nullopt;
  const Piece piece{pass_, {done_, count}, static_cast<double>(count) * pass.unit_size};
  done_ += count;
  skip_empty();
  return piece;
}

void SliceCursor::set_units_left(std::size_t pass, std::size_t units) {
  // The present pass may just have been left because nothing of it seemed to be left.
  assert(pass + 1 >= pass_ && pass < passes_.size());
  if (pass < pass_) {
    if (units == 0) return;
    pass_ = pass;
    done_ = passes_[pass].units;
  }
  passes_[pass].units = units + (pass == pass_ ? done_ : 0);
  skip_empty();
}

void SliceCursor::skip_empty() {
  while (pass_ < passes_.size() && done_ >= passes_[pass_].units) {
    ++pass_;
    done_ = 0;
  }
}

}  // namespace foreview::batched
