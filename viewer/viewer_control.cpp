#include "foreview/viewer/viewer_control.h"

#include <algorithm>
#include <cmath>

namespace foreview {
namespace {

constexpr double kSplitReach = 8;      // pixels
constexpr double kSplitStep = 0.02;    // of the frame's width
constexpr double kDelayStep = 0.1;     // seconds
constexpr double kTurnRate = 0.9;      // radians per second, of held keys
constexpr double kFlySeconds = 3;      // to cross the radius of the scene
constexpr double kZoomPerStep = 0.88;  // of the wheel

}  // namespace

int view_columns(ViewMode mode) {
  return mode == ViewMode::side_by_side ? 2 : 1;
}

ViewerControl::ViewerControl(Options options, PlaybackClock* clock)
    : steps_(std::move(options.steps)), camera_model_(options.camera), camera_(options.surroundings), clock_(clock) {
  settings_.choice = options.choice;
  settings_.link = options.link;
  settings_.pipeline = options.pipeline;
  settings_.extraction = options.extraction;
}

void ViewerControl::set_mode(ViewMode mode) {
  settings_.choice.mode = mode;
}

void ViewerControl::set_camera_mode(CameraMode mode) {
  camera_.set_mode(mode);
  camera_.store(settings_.choice);
}

bool ViewerControl::needs_clock(ViewerAction action) {
  switch (action) {
    case ViewerAction::pause:
    case ViewerAction::step_back:
    case ViewerAction::step_forward:
    case ViewerAction::to_start:
    case ViewerAction::to_end:
    case ViewerAction::slower:
    case ViewerAction::faster:
    case ViewerAction::toggle_loop:
      return true;
    default:
      return false;
  }
}

void ViewerControl::act(ViewerAction action) {
  if (clock_ == nullptr && needs_clock(action)) {
    refusal_ = kLiveHasNoTime;
    return;
  }
  ViewChoice& choice = settings_.choice;
  Overlays& overlays = choice.overlays;
  switch (action) {
    case ViewerAction::next_view: {
      const auto* const now = std::find(kViewModes.begin(), kViewModes.end(), choice.mode);
      set_mode(now + 1 == kViewModes.end() ? kViewModes.front() : *(now + 1));
      break;
    }
    case ViewerAction::view_predicted:
      return set_mode(ViewMode::predicted);
    case ViewerAction::view_delayed:
      return set_mode(ViewMode::delayed);
    case ViewerAction::view_side_by_side:
      return set_mode(ViewMode::side_by_side);
    case ViewerAction::view_split:
      return set_mode(ViewMode::split);
    case ViewerAction::view_difference:
      return set_mode(ViewMode::difference);
    case ViewerAction::split_left:
    case ViewerAction::split_right:
      choice.mode = ViewMode::split;
      choice.split =
          std::clamp(choice.split + (action == ViewerAction::split_left ? -kSplitStep : kSplitStep), 0.0, 1.0);
      break;
    case ViewerAction::next_camera: {
      // In the order of how far they lead away from the recording.
      constexpr std::array kOrder{CameraMode::follow, CameraMode::look_around, CameraMode::free, CameraMode::overview};
      const auto* const now = std::find(kOrder.begin(), kOrder.end(), camera_.mode());
      set_camera_mode(now + 1 == kOrder.end() ? kOrder.front() : *(now + 1));
      break;
    }
    case ViewerAction::reset_camera:
      settings_.choice.field_of_view.reset();
      set_camera_mode(CameraMode::follow);
      break;
    case ViewerAction::toggle_holes:
      overlays.holes = !overlays.holes;
      break;
    case ViewerAction::toggle_never_seen:
      overlays.never_seen = !overlays.never_seen;
      break;
    case ViewerAction::toggle_age:
      overlays.age = !overlays.age;
      overlays.density = false;  // two heat maps at once say nothing
      break;
    case ViewerAction::toggle_density:
      overlays.density = !overlays.density;
      overlays.age = false;
      break;
    case ViewerAction::toggle_wireframe:
      overlays.wireframe = !overlays.wireframe;
      break;
    case ViewerAction::toggle_edges:
      overlays.edges = !overlays.edges;
      if (overlays.edges && !shows_delayed(choice.mode)) choice.mode = ViewMode::delayed;
      break;
    case ViewerAction::toggle_cone:
      overlays.cone = !overlays.cone;
      break;
    case ViewerAction::toggle_probe:
      settings_.probe = !settings_.probe;
      break;
    case ViewerAction::pause:
      return toggle_pause();
    case ViewerAction::step_back:
    case ViewerAction::step_forward:
      return step(action == ViewerAction::step_forward);
    case ViewerAction::to_start:
      clock_->seek(clock_->first());
      break;
    case ViewerAction::to_end:
      scrub(clock_->last());
      break;
    case ViewerAction::slower:
    case ViewerAction::faster:
      return change_speed(action == ViewerAction::faster ? 1 : -1);
    case ViewerAction::toggle_loop:
      clock_->set_loop(!clock_->loop());
      break;
    case ViewerAction::less_delay:
    case ViewerAction::more_delay:
      return change_delay(action == ViewerAction::more_delay ? kDelayStep : -kDelayStep);
    case ViewerAction::save_picture:
      save_ = true;
      break;
    case ViewerAction::copy_command:
      copy_ = true;
      break;
    case ViewerAction::toggle_panels:
      settings_.panels = !settings_.panels;
      break;
    case ViewerAction::enter_panels:
      settings_.panels = true;
      enter_ = true;
      break;
    case ViewerAction::toggle_help:
      settings_.help = !settings_.help;
      break;
    case ViewerAction::toggle_full_screen:
      settings_.full_screen = !settings_.full_screen;
      break;
    case ViewerAction::quit:
      // The key that closes everything else closes the help first.
      if (settings_.help) {
        settings_.help = false;
      } else {
        quit_ = true;
      }
      break;
  }
}

void ViewerControl::toggle_pause() {
  if (clock_->playing() && !clock_->at_end()) {
    clock_->pause();
  } else {
    clock_->play();
  }
}

void ViewerControl::scrub(Timestamp time) {
  if (clock_ == nullptr) return;
  clock_->pause();
  clock_->seek(time);
}

void ViewerControl::step(bool forward) {
  clock_->pause();
  const Timestamp now = clock_->now().time;
  if (forward) {
    const auto next = std::upper_bound(steps_.begin(), steps_.end(), now);
    if (next != steps_.end()) scrub(std::min(*next, clock_->last()));
  } else {
    const auto next = std::lower_bound(steps_.begin(), steps_.end(), now);
    if (next != steps_.begin()) scrub(std::max(*(next - 1), clock_->first()));
  }
}

void ViewerControl::change_speed(int direction) {
  const double now = clock_->speed();
  if (direction > 0) {
    const auto* const next = std::upper_bound(kSpeeds.begin(), kSpeeds.end(), now * 1.001);
    if (next != kSpeeds.end()) clock_->set_speed(*next);
  } else {
    const auto* const next = std::lower_bound(kSpeeds.begin(), kSpeeds.end(), now * 0.999);
    if (next != kSpeeds.begin()) clock_->set_speed(*(next - 1));
  }
}

void ViewerControl::change_delay(double seconds) {
  // In whole steps, whatever it was.
  const double wanted = std::round((settings_.link.delay.seconds() + seconds) / kDelayStep) * kDelayStep;
  settings_.link.delay = Duration::from_seconds(std::clamp(wanted, 0.0, kMostDelay));
}

bool ViewerControl::over_split(const FramePointer& pointer) const {
  return settings_.choice.mode == ViewMode::split && pointer.over_frame &&
         std::abs(pointer.position.x - settings_.choice.split * pointer.frame_size.x) <= kSplitReach;
}

double ViewerControl::radians_per_pixel(const FramePointer& pointer) const {
  const double angle = settings_.choice.field_of_view.value_or(field_of_view(camera_model_));
  return angle / std::max(pointer.frame_size.y, 1.0);
}

void ViewerControl::point(const FramePointer& pointer) {
  if (pointer.left_pressed || pointer.right_pressed) {
    last_position_ = pointer.position;
    const bool roams = camera_.mode() == CameraMode::free || camera_.mode() == CameraMode::overview;
    if (pointer.left_pressed && over_split(pointer)) {
      drag_ = Drag::split;
    } else if (pointer.right_pressed) {
      drag_ = roams ? Drag::move : Drag::look;
    } else {
      drag_ = roams && !pointer.shift ? Drag::turn : Drag::look;
    }
  }
  if (!pointer.left && !pointer.right) drag_ = Drag::none;
  const glm::dvec2 moved = pointer.position - last_position_;
  last_position_ = pointer.position;
  const glm::dvec2 angles = moved * radians_per_pixel(pointer);
  switch (drag_) {
    case Drag::none:
      break;
    case Drag::split:
      settings_.choice.split = std::clamp(pointer.position.x / std::max(pointer.frame_size.x, 1.0), 0.0, 1.0);
      break;
    case Drag::turn: {
      // The scene follows the mouse: across the frame's height is half a turn.
      const glm::dvec2 around = moved * (3.14159265358979 / std::max(pointer.frame_size.y, 1.0));
      camera_.orbit(-around.x, -around.y);
      break;
    }
    case Drag::look:
      if (moved != glm::dvec2(0)) camera_.look(-angles.x, -angles.y);
      break;
    case Drag::move: {
      const CameraModel model = with_field_of_view(camera_model_, settings_.choice.field_of_view);
      const double scale =
          camera_.metres_per_pixel(model) * static_cast<double>(model.height) / std::max(pointer.frame_size.y, 1.0);
      camera_.pan(moved.x * scale, moved.y * scale);
      break;
    }
  }
  if (pointer.wheel != 0 && pointer.over_frame) {
    if (camera_.mode() == CameraMode::free || camera_.mode() == CameraMode::overview) {
      camera_.dolly(std::pow(kZoomPerStep, pointer.wheel));
    } else {
      // From a given place only the field of view can come nearer.
      const double now = settings_.choice.field_of_view.value_or(field_of_view(camera_model_));
      settings_.choice.field_of_view =
          std::clamp(now * std::pow(kZoomPerStep, pointer.wheel), kLeastFieldOfView, kGreatestFieldOfView);
    }
  }
}

void ViewerControl::move_held() {
  const auto held = [&](MoveKey key) { return held_[static_cast<std::size_t>(key)] ? 1.0 : 0.0; };
  const glm::dvec2 turn{held(MoveKey::turn_right) - held(MoveKey::turn_left),
                        held(MoveKey::turn_down) - held(MoveKey::turn_up)};
  if (turn != glm::dvec2(0)) camera_.look(turn.x * kTurnRate * held_seconds_, turn.y * kTurnRate * held_seconds_);
  const glm::dvec3 direction{held(MoveKey::right) - held(MoveKey::left), held(MoveKey::down) - held(MoveKey::up),
                             held(MoveKey::forward) - held(MoveKey::backward)};
  camera_.fly(direction * (camera_.surroundings().radius / kFlySeconds));
}

void ViewerControl::advance(double seconds, const Pose& recorded) {
  held_seconds_ = seconds;
  move_held();
  camera_.advance(seconds, recorded);
  camera_.store(settings_.choice);
}

}  // namespace foreview
