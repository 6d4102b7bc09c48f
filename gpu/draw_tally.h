#pragma once
#include <cstddef>

namespace foreview {

/// Draws and dispatches that this thread has issued through the functions that count them: what statistics take the
/// difference of.
struct DrawTally {
  std::size_t draw_calls = 0;
  std::size_t passes = 0;  ///< draws and dispatches that a barrier or a change of target parts
};

namespace gl_detail {
inline thread_local DrawTally draw_tally;
}  // namespace gl_detail

[[nodiscard]] inline DrawTally draw_tally() {
  return gl_detail::draw_tally;
}
/// A draw or dispatch that begins a pass, or belongs to the pass of the one before.
inline void count_draw(bool begins_pass = true) {
  ++gl_detail::draw_tally.draw_calls;
  if (begins_pass) ++gl_detail::draw_tally.passes;
}

}  // namespace foreview
