#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <utility>
#include <vector>

#include "foreview/scene/errors.h"
#include "foreview/viewer/frame_composer.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/picture_output.h"
#include "foreview/viewer/replay_frames.h"
#include "foreview/viewer/replay_session.h"
#include "foreview/viewer/window.h"

namespace foreview {
namespace {

constexpr int kSmallestWidth = 640;  // small pictures are enlarged to about this
constexpr double kIdleWait = 0.05;   // seconds; while nothing moves, look again this often

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<ReplayControl::Key> take_keys(Window& window) {
  using Key = ReplayControl::Key;
  std::vector<Key> keys;
  for (const Window::Key& pressed : window.take_keys()) {
    switch (action_of(pressed.chord, pressed.repeated).value_or(ViewerAction::toggle_help)) {
      case ViewerAction::next_view:
        keys.push_back(Key::tab);
        break;
      case ViewerAction::toggle_edges:
        keys.push_back(Key::m);
        break;
      case ViewerAction::toggle_holes:
        keys.push_back(Key::h);
        break;
      case ViewerAction::toggle_wireframe:
        keys.push_back(Key::w);
        break;
      case ViewerAction::save_picture:
        keys.push_back(Key::s);
        break;
      case ViewerAction::pause:
        keys.push_back(Key::space);
        break;
      case ViewerAction::quit:
        keys.push_back(Key::q);
        break;
      case ViewerAction::step_back:
        keys.push_back(Key::left);
        break;
      case ViewerAction::step_forward:
        keys.push_back(Key::right);
        break;
      default:
        break;
    }
  }
  return keys;
}

/// The user left while pictures were being extracted.
struct Left {};

class WindowReplay {
 public:
  WindowReplay(Replayer& replayer, Window& window, const ReplaySessionOptions& options)
      : replayer_(replayer),
        window_(window),
        options_(options),
        control_(control_options(replayer, options)),
        composer_(replayer.view(), replayer.recording().cameras()[replayer.camera()].model, options.near_plane),
        replay_frames_(replayer, options.delay),
        name_(replayer.recording().name()) {}

  ReplaySummary run() {
    const FrameComposer::Size native = composer_.native_size(control_.choice().mode);
    const int enlarged = std::max(1, kSmallestWidth / std::max(native.width, 1));
    window_.resize(native.width * enlarged, native.height * enlarged);
    double last_tick = now();
    while (!finished()) {
      const double time = now();
      control_.tick(Duration::from_seconds(time - last_tick));
      last_tick = time;
      try {
        advance();
      } catch (const Left&) {
        break;
      }
      const bool drawn = draw_if_changed();
      if (control_.take_save_request()) save();
      count_frame(drawn);
      window_.set_title(control_.title(name_, frames_per_second_));
      window_.poll_events(drawn || !waiting_keys_.empty() ? 0 : kIdleWait);
      press_keys();
    }
    return summary_;
  }

 private:
  static ReplayControl::Options control_options(Replayer& replayer, const ReplaySessionOptions& options) {
    ReplayControl::Options result;
    result.first = replayer.first();
    result.last = replayer.last();
    result.delay = options.delay;
    result.speed = options.speed;
    result.loop = options.loop;
    result.choice = options.choice;
    for (const ReplayInstant& instant : replay_instants(replayer)) result.steps.push_back(instant.stamp);
    for (const Recording::Camera& camera : replayer.recording().cameras()) {
      for (const Recording::PictureEntry& picture : camera.pictures) result.captures.push_back(picture.stamp);
    }
    std::sort(result.captures.begin(), result.captures.end());
    result.captures.erase(std::unique(result.captures.begin(), result.captures.end()), result.captures.end());
    return result;
  }

  void press_keys() {
    std::vector<ReplayControl::Key> keys = std::exchange(waiting_keys_, {});
    for (const ReplayControl::Key key : take_keys(window_)) keys.push_back(key);
    for (std::size_t i = 0; i < keys.size(); ++i) {
      control_.press(keys[i]);
      if (keys[i] != ReplayControl::Key::s) continue;
      // What was asked for is saved before the next keys change it.
      waiting_keys_.assign(keys.begin() + static_cast<std::ptrdiff_t>(i) + 1, keys.end());
      break;
    }
  }

  [[nodiscard]] bool finished() const { return control_.quit() || window_.close_requested() || interrupted(); }

  /// Brings the textures up to display time. Where that takes many pictures (at the start, or after a step back), the
  /// window stays responsive between them: it keeps its last frame, says how far it is, and can be left.
  void advance() {
    replayer_.advance_to(control_.time(), [this](std::size_t done, std::size_t todo) {
      const double time = now();
      if (time - last_progress_ < kIdleWait) return;
      last_progress_ = time;
      if (todo > 2) {
        window_.set_title("foreview: " + name_ + " | extracting picture " + std::to_string(done) + " of " +
                          std::to_string(todo));
        if (shown_) present();
      }
      window_.poll_events();
      // Keys that change what is shown wait for the textures that are being made.
      for (const ReplayControl::Key key : take_keys(window_)) {
        if (key == ReplayControl::Key::q || key == ReplayControl::Key::escape) throw Left();
        waiting_keys_.push_back(key);
      }
      if (finished()) throw Left();
    });
  }

  bool draw_if_changed() {
    if (window_.width() < 1 || window_.height() < 1) return false;  // minimised
    const ViewChoice& choice = control_.choice();
    const Drawn wanted{control_.time(), choice, window_.width(), window_.height()};
    const bool changed = !shown_ || wanted != *shown_;
    if (changed) {
      shown_size_ = composer_.fitting_size(choice.mode, window_.width(), window_.height());
      composer_.compose(replay_frames_.at(control_.time(), choice), choice, shown_size_);
      shown_ = wanted;
    }
    // Shown again even if nothing changed: the window's system may have lost what was there.
    present();
    return changed;
  }

  void present() {
    window_.draw(composer_.framebuffer(), shown_size_.width, shown_size_.height,
                 {0, 0, window_.width(), window_.height()});
    window_.swap();
  }

  void save() {
    const ViewChoice& choice = control_.choice();
    composer_.compose(replay_frames_.at(control_.time(), choice), choice, composer_.native_size(choice.mode));
    shown_.reset();  // the composer holds another frame now
    char time[32];
    std::snprintf(time, sizeof time, "%.3fs",
                  (control_.time() - replayer_.recording().first_stamp(replayer_.camera())).seconds());
    const std::string stem = "foreview-" + name_ + "-" + to_string(choice.mode) + "-" + time;
    std::filesystem::path file = options_.out / (stem + ".png");
    for (int i = 2; std::filesystem::exists(file); ++i) file = options_.out / (stem + "-" + std::to_string(i) + ".png");
    try {
      write_png(file, composer_.read());
      ++summary_.pictures_written;
      spdlog::info("saved {}", file.string());
    } catch (const InputError& error) {
      spdlog::error("{}", error.what());  // no reason to lose the window and its textures
    }
  }

  void count_frame(bool drawn) {
    const double time = now();
    if (drawn) ++frames_;
    if (time - counted_since_ < 1) return;
    frames_per_second_ = frames_ / (time - counted_since_);
    frames_ = 0;
    counted_since_ = time;
  }

  struct Drawn {
    Timestamp time;
    ViewChoice choice;
    int width = 0, height = 0;
    bool operator==(const Drawn&) const = default;
  };

  Replayer& replayer_;
  Window& window_;
  const ReplaySessionOptions& options_;
  ReplayControl control_;
  FrameComposer composer_;
  ReplayFrames replay_frames_;
  std::string name_;
  ReplaySummary summary_;
  std::vector<ReplayControl::Key> waiting_keys_;
  std::optional<Drawn> shown_;
  FrameComposer::Size shown_size_;
  int frames_ = 0;
  double counted_since_ = now(), frames_per_second_ = 0, last_progress_ = 0;
};

}  // namespace

ReplaySummary replay_in_window(Replayer& replayer, Window& window, const ReplaySessionOptions& options) {
  return WindowReplay(replayer, window, options).run();
}

}  // namespace foreview
