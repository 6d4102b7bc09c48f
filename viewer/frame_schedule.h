#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "foreview/scene/timestamp.h"
#include "foreview/viewer/learnt_cost.h"

namespace foreview {

/// Who has the GPU next: the display, whose frames have deadlines, or extraction, which runs in bounded slices (spec
/// 10). Pure policy: no clock, no thread, no GL; time is passed in, from a clock that does not go back.
///
/// **Driving it.** Ask next(), do what it says, report it, ask again. One thing is in flight at a time; with two
/// threads, ask and report under one lock. A picture's extraction is a sequence of slices (a band of the upload, a
/// pass, a pyramid level), 2 to 3 ms each at most; offer the one that is due, or none where there is nothing to
/// extract.
/// @code
///   const auto decision = schedule.next(clock(), extraction.pending_slice());
///   switch (decision.action) {
///     case Action::draw_frame:                        // latch the operator's input now, predict for decision.until
///       frame = schedule.frame_started(clock());
///       draw(); finish();  schedule.frame_handed_over(clock());
///       swap();            schedule.frame_completed(frame, clock());
///     case Action::run_slice:
///       schedule.slice_started(slice, clock()); run(slice); finish(); schedule.slice_completed(clock());
///     case Action::wait_until:                        // or until there is something to extract
///       sleep_until(decision.until);
///   }
/// @endcode
///
/// **Frames.** Deadlines lie on a grid, `period` apart; a frame should be *complete* at its deadline. It is started as
/// late as can be, so that it shows the newest input: at its deadline less the frame's learnt cost less `margin`.
///
/// **Slices** run while the slice's learnt cost fits in before that start: the display never waits for more than the
/// rest of one slice, and not even for that unless the slice takes longer than it was said to.
///
/// **Costs** are learnt (LearntCost) as parts of declared bounds, which hold until something is known: for each kind of
/// slice a constant and a part per unit of size (a megapixel, a megatexel), for the frame a constant. By default a
/// bound is a first guess and what was learnt replaces it, upwards and downwards; a slice or a frame *exceeds its
/// bound* when it takes longer than was reckoned when it was started (cost(), frame_cost()). With cost.floor = 1
/// nothing is reckoned cheaper than declared: then frames are in time as long as slices and frames keep to the
/// *declared* bounds, whatever they did before; the price is time left unused.
///
/// **Overload.** If extraction got less than `t_diff` since the last frame, although it has had something to do ever
/// since, and its slice does not fit in before the next frame, then that frame is skipped and the slice runs at once;
/// extraction keeps the GPU for `t_min`, at most one period, as far as its slices fit in, and then as always until the
/// next frame's start. One frame only: no second one is skipped before one was drawn. So between any two frames with
/// work waiting throughout, at least one slice runs, at any load. Waiting out the time that is too short for the slice
/// would help nobody: the frame is skipped as soon as that is known.
/// With `patience` above 1, so many gaps between frames in a row must be like that: a frame that was late once, for
/// whatever reason, then costs extraction a gap and not the display a second frame.
///
/// What else can happen:
/// - *A slice exceeds its bound*: the frame is drawn at once, and is late by no more than the excess less the margin.
///   Were it late by more than a quarter of the period, its deadline is *missed* instead and the next one aimed at.
///   The cost is learnt; the second such slice is expected.
/// - *A slice is longer than a skip gives* (costs more than the period and what was left): it runs after the skip all
///   the same, or it would never run; the deadlines it is expected to run past are given up beforehand and count as
///   missed. Such slices are counted (`oversize_slices`): cut them smaller, see size_within().
/// - *Frames cost more than the period*: when the median frame does, every second (third ...) deadline is aimed at,
///   so that frames come evenly and not at drifting times; the others are missed. The rate comes back when the median
///   is a tenth below what it needs. Single frames that cost more than that are late, and no time is reserved for
///   them: it could not save them.
/// - *Backlog* after a late frame: deadlines that can be met with at most a quarter of a period's delay are still
///   served, the others missed: catching up, not drifting.
/// - *The period changes* (set_period): the new grid begins a period after the last deadline served, or as soon as a
///   frame can be ready; nothing is missed by it.
/// - *Nothing to extract*: frames at their starts, waiting in between. Work that comes during the wait may be offered
///   at once; if it does not fit it waits for the next frame without a skip, since it has not starved.
/// - *A swap that blocks* (vertical synchronisation): frame_handed_over() ends the frame's cost, when the GPU has
///   done it, and frame_completed(), when it is seen, decides whether it was late; what lies between is the display's
///   waiting and must not be learnt as cost. It may come after later events, up to four frames late. Lay the
///   deadlines on the display's instants with set_grid(), behind them by what the swap takes to return, and enlarge
///   the margin by as much.
/// - *The clock jumps* (suspended machine, debugger): when nobody asks or reports for more than a second after it was
///   due, or time goes back, that is a stop, no lateness: the grid goes on from there in its phase, nothing is missed
///   or late for it, and no duration counts for more than a second beyond its bound. Stops are counted.
class FrameSchedule {
 public:
  /// cost = constant + per_unit * size; more than nothing for every size offered.
  struct Bound {
    Duration constant;
    Duration per_unit;
  };
  struct Options {
    Duration period;                ///< 1 / F_d
    Duration frame;                 ///< declared bound of drawing a frame
    std::vector<Bound> slices;      ///< declared bounds, by kind
    Duration margin{500'000};       ///< between a frame's expected completion and its deadline: waking up, measuring
    Duration t_diff{100'000};       ///< spec 10
    Duration t_min{10'000'000};     ///< spec 10
    int patience = 1;               ///< gaps between frames with less than t_diff, the last of which costs a frame
    LearntCost::Options cost = {};  ///< of frames, and of slices where nothing else is said
    std::optional<LearntCost::Options> slice_cost = {};
  };
  struct Slice {
    std::size_t kind = 0;  ///< index into Options::slices
    double size = 1;       ///< in the unit of the kind's bound
  };
  enum class Action { draw_frame, run_slice, wait_until };
  struct Decision {
    Action action = Action::wait_until;
    /// draw_frame: the deadline, when the frame should be seen. run_slice: when it should be done. wait_until: when to
    /// ask again, unless there is something to extract sooner.
    Timestamp until;
    bool skipped_frame = false;  ///< a frame was skipped for this slice
  };
  struct Statistics {
    std::int64_t due = 0;      ///< deadlines disposed of: frames + skipped + missed
    std::int64_t frames = 0;   ///< started
    std::int64_t late = 0;     ///< of the frames completed: after their deadline
    std::int64_t skipped = 0;  ///< deadlines without a frame by the overload rule
    std::int64_t missed = 0;   ///< deadlines without a frame because something ran past them
    std::int64_t slices = 0;   ///< completed
    std::int64_t oversize_slices = 0;
    std::int64_t frame_overruns = 0, slice_overruns = 0;  ///< that exceeded what was reckoned when they started
    std::int64_t stops = 0;                               ///< jumps of the clock
    Duration extraction;                                  ///< time in slices
    Duration worst_lateness;
  };

  /// The first deadline lies a period after `start`, or the first after that which a frame can meet.
  FrameSchedule(Options options, Timestamp start);

  /// What to do now. `slice`: what extraction would do next, if anything. Nothing may be in flight.
  [[nodiscard]] Decision next(Timestamp now, const std::optional<Slice>& slice);

  /// The number by which to report the frame's completion.
  std::int64_t frame_started(Timestamp now);
  /// The GPU has drawn the frame and is free.
  void frame_handed_over(Timestamp now);
  /// The frame is to be seen: `when` decides whether it was late, and may lie before the last event reported.
  void frame_completed(std::int64_t number, Timestamp when);
  void slice_started(const Slice& slice, Timestamp now);
  void slice_completed(Timestamp now);

  /// From now on at another rate. Allowed at any time; a frame in flight keeps its deadline.
  void set_period(Duration period, Timestamp now);
  /// The same, with the deadlines whole periods from `deadline`, for displays with instants of their own: the first
  /// that a frame can meet is the next. Best when a frame was just handed over; a frame that was about to start waits
  /// for it.
  void set_grid(Duration period, Timestamp deadline, Timestamp now);
  /// From now on these kinds of slices; what others cost is forgotten. No slice may be in flight.
  void set_slices(std::vector<Bound> slices);

  /// What is reckoned now for a slice, and for a frame.
  [[nodiscard]] Duration cost(const Slice& slice) const;
  [[nodiscard]] Duration frame_cost() const;
  /// The largest slice of the kind that is reckoned to take no longer than `duration`; 0: none.
  [[nodiscard]] double size_within(std::size_t kind, Duration duration) const;
  /// The largest one that takes half of the time no longer than `duration`: by the median of what was learnt, where
  /// size_within() goes by what to reckon with. For the length of slices when no frame is near.
  [[nodiscard]] double typical_size_within(std::size_t kind, Duration duration) const;
  /// The next deadline aimed at, and when its frame is to be started: the room for slices ends there.
  [[nodiscard]] Timestamp deadline() const { return aim_; }
  [[nodiscard]] Timestamp frame_start() const;
  /// 1: every deadline is aimed at; 2: every second one, because frames cost more than the period.
  [[nodiscard]] std::int64_t submultiple() const { return submultiple_; }
  [[nodiscard]] const Statistics& statistics() const { return statistics_; }

 private:
  enum class InFlight { nothing, frame, slice };
  struct ShownFrame {
    std::int64_t number;
    Timestamp deadline;
  };

  [[nodiscard]] Duration reserve() const;  ///< a frame's cost and the margin
  /// Since the last frame there was work throughout, and less than t_diff for it.
  [[nodiscard]] bool is_starving() const { return work_waited_ && !skipped_ && extraction_ < options_.t_diff; }
  [[nodiscard]] Duration tolerance() const { return {options_.period.nanoseconds / 4}; }
  [[nodiscard]] Duration bound(const Slice& slice) const;  ///< declared
  [[nodiscard]] double size_within(std::size_t kind, Duration duration, double per_declared) const;
  /// The first of aim, aim + period, ... that a frame started at `start` meets with `delay` at most.
  [[nodiscard]] Timestamp reachable(Timestamp aim, Timestamp start, Duration delay) const;
  void aim_on_grid(Timestamp deadline, Timestamp now);
  void aim_from(Timestamp deadline);
  void pass_over_to(Timestamp deadline);
  void update_submultiple();
  void notice(Timestamp now);
  [[nodiscard]] std::optional<Duration> end_of_work(Timestamp now);

  Options options_;
  LearntCost frame_ratio_;
  std::vector<LearntCost> slice_ratios_;  ///< by kind
  std::int64_t submultiple_ = 1;

  Timestamp last_;  ///< the last deadline disposed of
  Timestamp aim_;   ///< the next frame's, on the grid after last_

  // Since the last frame was handed over:
  bool work_waited_ = false;  ///< there was something to extract whenever next() was asked
  bool skipped_ = false;
  Duration extraction_;
  int starved_gaps_ = 0;  ///< before that, in a row: gaps with work throughout and less than t_diff for it

  Timestamp grant_end_;  ///< of extraction's t_min after the last skip

  InFlight in_flight_ = InFlight::nothing;
  Slice slice_;
  Timestamp started_;
  Duration reckoned_;                             ///< of what is in flight
  std::optional<Timestamp> aim_before_oversize_;  ///< while the deadlines an oversize slice runs past are given up
  std::deque<ShownFrame> shown_;                  ///< not yet reported complete
  Timestamp latest_, expected_;                   ///< the last event; when to hear the next at the latest
  Statistics statistics_;
};

}  // namespace foreview
