#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "foreview/gpu/gl_objects.h"

namespace foreview {

namespace gl_detail {
inline void create_timestamp_query(GLuint* id) {
  glCreateQueries(GL_TIMESTAMP, 1, id);
}
}  // namespace gl_detail
using GlTimestampQuery = GlObject<gl_detail::create_timestamp_query, gl_detail::delete_query>;

/// GL timestamps from query objects that are made once and used again. Belongs to the context that it was first used
/// in: queries are not shared.
class TimerQueries {
 public:
  /// Forgets the marks so far; their query objects are used again.
  void restart() { used_ = 0; }
  /// A timestamp when all commands issued so far have been carried out. Returns its number.
  std::size_t mark();
  /// Nanoseconds of GL's clock for each mark since restart(), in order. Waits for the GPU.
  [[nodiscard]] std::vector<std::int64_t> resolve() const;

 private:
  std::vector<GlTimestampQuery> queries_;
  std::size_t used_ = 0;
};

/// What timestamps said about work whose length the wall clock knows.
struct TimerCheck {
  struct Work {
    const char* kind = "";  ///< "dispatch", "draw", "passes": draws into two targets in turn
    double wall_ms = 0;     ///< from before the first command to after glFinish
    double query_ms = 0;    ///< between timestamps before and after
  };
  std::vector<Work> works;
  bool truthful = false;  ///< timestamps exist, advance, and agree within 20 % for every kind of work
};

/// Times at least 5 ms of work of each kind, the shortest of three tries, in the current context. Takes some 100 ms;
/// changes the context's program and bindings.
[[nodiscard]] TimerCheck check_timer_queries();
/// check_timer_queries() in the context that is current at the first call, once a process.
[[nodiscard]] const TimerCheck& startup_timer_check();
/// Whether ExtractionTiming::queries can be believed: what startup_timer_check() found. False on software rasterisers,
/// which report 0.0 to 0.6 ms for 80 to 110 ms of work.
[[nodiscard]] bool timer_queries_are_truthful();

}  // namespace foreview
