#include "foreview/viewer/replay_control.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

namespace foreview {
namespace {

ViewMode next_mode(ViewMode mode) {
  const auto* const at = std::find(kViewModes.begin(), kViewModes.end(), mode);
  return at + 1 < kViewModes.end() ? *(at + 1) : kViewModes.front();
}

}  // namespace

ReplayControl::ReplayControl(Options options) : options_(std::move(options)), time_(options_.first) {}

void ReplayControl::press(Key key) {
  ViewChoice& choice = options_.choice;
  switch (key) {
    case Key::tab:
      choice.mode = next_mode(choice.mode);
      break;
    case Key::m:
      choice.overlays.edges = !choice.overlays.edges;
      if (choice.overlays.edges && !shows_delayed(choice.mode)) choice.mode = ViewMode::delayed;
      break;
    case Key::h:
      choice.overlays.holes = !choice.overlays.holes;
      break;
    case Key::w:
      choice.overlays.wireframe = !choice.overlays.wireframe;
      break;
    case Key::s:
      save_requested_ = true;
      break;
    case Key::space:
      if (at_end()) {
        time_ = options_.first;
        paused_ = false;
      } else {
        paused_ = !paused_;
      }
      break;
    case Key::escape:
    case Key::q:
      quit_ = true;
      break;
    case Key::left:
    case Key::right:
      // At the end time stands as well, and stepping back from there is what one wants to do.
      if (at_end()) paused_ = true;
      if (paused_) step(key == Key::right);
      break;
  }
}

void ReplayControl::step(bool forward) {
  const std::vector<Timestamp>& steps = options_.steps;
  if (forward) {
    const auto next = std::upper_bound(steps.begin(), steps.end(), time_);
    if (next != steps.end()) time_ = std::min(*next, options_.last);
  } else {
    const auto next = std::lower_bound(steps.begin(), steps.end(), time_);
    if (next != steps.begin()) time_ = std::max(*(next - 1), options_.first);
  }
}

Timestamp ReplayControl::latest_allowed() const {
  // A picture is used when its stamp is before time - delay. The first one not used yet may become due, the second not.
  const std::vector<Timestamp>& captures = options_.captures;
  const auto next = std::lower_bound(captures.begin(), captures.end(), time_ - options_.delay);
  if (captures.end() - next < 2) return {std::numeric_limits<std::int64_t>::max()};
  return *(next + 1) + options_.delay;
}

void ReplayControl::tick(Duration elapsed) {
  if (paused_ || at_end() || elapsed.nanoseconds <= 0) {
    pace_ = 1;
    return;
  }
  const Duration wanted = Duration::from_seconds(elapsed.seconds() * options_.speed);
  const Timestamp before = time_;
  time_ = std::min({before + wanted, latest_allowed(), std::max(before, options_.last)});
  // Reaching the end is not being late.
  const double achieved =
      time_ >= options_.last || wanted.nanoseconds <= 0
          ? 1
          : static_cast<double>((time_ - before).nanoseconds) / static_cast<double>(wanted.nanoseconds);
  const double weight = 1 - std::exp(-elapsed.seconds());
  pace_ += weight * (achieved - pace_);
  if (options_.loop && time_ >= options_.last) time_ = options_.first;
}

bool ReplayControl::take_save_request() {
  return std::exchange(save_requested_, false);
}

std::string ReplayControl::title(const std::string& recording, double frames_per_second) const {
  char text[160];
  std::snprintf(text, sizeof text, "%s | %s | %.2f s | delay %.0f ms | %.0f fps", recording.c_str(),
                to_string(options_.choice.mode), (time_ - options_.first).seconds(), options_.delay.seconds() * 1e3,
                frames_per_second);
  std::string title = std::string("foreview: ") + text;
  if (pace_ < 0.95) {
    std::snprintf(text, sizeof text, " | slower than real time (%.2f x)", pace_ * options_.speed);
    title += text;
  }
  if (at_end()) {
    title += " | end";
  } else if (paused_) {
    title += " | paused";
  }
  return title;
}

}  // namespace foreview
