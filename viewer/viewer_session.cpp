#include "foreview/viewer/viewer_session.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/errors.h"
#include "foreview/viewer/command_line.h"
#include "foreview/viewer/display_errors.h"
#include "foreview/viewer/frame_quality.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/live_feed.h"
#include "foreview/viewer/picture_output.h"
#include "foreview/viewer/process_age.h"
#include "foreview/viewer/recording_feed.h"
#include "foreview/viewer/viewer_stage.h"

namespace foreview {
namespace {

constexpr double kSoftwareRate = 33, kGreatestRate = 60;  // hertz
constexpr Duration kMessageTime{4'000'000'000};
constexpr Duration kTitleInterval{200'000'000};
constexpr Duration kSettled{700'000'000};          // nothing was extracted for so long: nothing more will come
constexpr Duration kPreparingPeriod{100'000'000};  // nothing moves yet: the cores are better used by what is prepared
constexpr Duration kMemoryInterval{1'000'000'000};
constexpr std::size_t kMostContextsLost = 3;
constexpr std::int64_t kFramesToWarmUp = 2;
constexpr std::ptrdiff_t kFramesToMeasure = 5;

/// For tests, FOREVIEW_LOSE_CONTEXT=N: as if the context were lost when frame N is to be drawn.
std::optional<std::int64_t> frame_to_lose_context_at() {
  const char* value = std::getenv("FOREVIEW_LOSE_CONTEXT");
  if (value == nullptr || *value == '\0') return std::nullopt;
  std::int64_t frame = 0;
  const std::string_view text(value);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), frame);
  if (error != std::errc() || end != text.data() + text.size() || frame < 0) {
    throw InputError("FOREVIEW_LOSE_CONTEXT", "'" + std::string(text) + "' cannot be; expected the number of a frame");
  }
  return frame;
}

std::string renderer_of_current_context() {
  const auto text = [](GLenum name) {
    const auto* value = reinterpret_cast<const char*>(glGetString(name));
    return std::string(value != nullptr ? value : "unknown");
  };
  return text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
}

std::unique_ptr<Feed> make_feed(const ViewerOptions& options) {
  if (options.live) return std::make_unique<LiveFeed>(*options.live, options.replay);
  return std::make_unique<RecordingFeed>(
      RecordingFeed::Options{options.replay, options.link, options.session.speed, options.session.loop});
}

class ViewerSession {
 public:
  explicit ViewerSession(const ViewerOptions& options)
      : options_(options),
        started_(steady_now()),
        feed_((window_.emplace("foreview", 960, 720), make_feed(options))),
        source_(feed_->source()),
        control_(control_options(), feed_->clock()),
        applied_link_(options.link) {
    spdlog::debug("recording and model after {:.0f} ms", (steady_now() - started_).seconds() * 1e3);
    control_.settings().panels = options.panels;
    status_.name = feed_->name();
  }

  ViewerSummary run() {
    struct Watch {
      ~Watch() { set_display_lost_action({}); }
    } const watch;
    set_display_lost_action([this] { save_what_can_be_saved(); });
    bool going = true;
    while (going) {
      try {
        run_stage();
        going = false;
      } catch (const ContextLost& error) {
        if (++summary_.contexts_lost > kMostContextsLost) throw;
        spdlog::warn("{}: beginning anew with a new one", error.what());
        if (PlaybackClock* clock = feed_->clock()) clock->seek(clock->now().time);
        say("the graphics context was lost; textures are made anew", true);
        stage_.reset();
        window_.reset();
        window_.emplace("foreview", 960, 720);
      }
    }
    stage_.reset();
    wait_for_saving();
    describe();
    return summary_;
  }

 private:
  // Beginning.

  [[nodiscard]] ViewerControl::Options control_options() const {
    ViewerControl::Options result;
    result.choice = options_.session.choice;
    result.link = options_.link;
    result.pipeline = options_.replay.pipeline;
    result.extraction = options_.replay.extraction;
    if (const PlaybackClock* clock = feed_->clock()) {
      for (const Recording::PictureEntry& picture : feed_->recording()->cameras()[feed_->camera()].pictures) {
        if (picture.stamp >= clock->first() && picture.stamp <= clock->last()) result.steps.push_back(picture.stamp);
      }
    }
    result.camera = feed_->camera_model().undistorted();
    result.surroundings = feed_->surroundings();
    return result;
  }

  [[nodiscard]] double wanted_rate() const {
    if (options_.rate) return *options_.rate;
    if (is_software_renderer(status_.renderer)) return kSoftwareRate;
    const int monitor = window_->refresh_rate();
    return monitor > 0 ? std::min(static_cast<double>(monitor), kGreatestRate) : kGreatestRate;
  }

  // Running.

  void run_stage() {
    status_.renderer = renderer_of_current_context();
    stage_.emplace(*window_, *feed_, control_);
    spdlog::debug("textures, views and panels after {:.0f} ms", (steady_now() - started_).seconds() * 1e3);
    applied_extraction_ = control_.settings().extraction;
    size_window();
    const bool waits = !is_software_renderer(status_.renderer);
    window_->set_swap_interval(waits ? 1 : 0);
    DisplayLoop::Options loop_options;
    loop_options.period = kPreparingPeriod;
    loop_options.present_waits = present_waits_ = waits;
    drawing_.clear();
    if (fast_) stage_->set_display_quality(ViewQuality::fast);
    DisplayLoop::Callbacks callbacks;
    callbacks.poll = [this] { return poll(); };
    callbacks.draw = [this](const FrameMoment& moment) { draw(moment); };
    callbacks.present = [this] { present(); };
    callbacks.restart = [this] { stage_->scene().restart(); };
    callbacks.displayed = [this](const PictureRecord& picture) { feed_->displayed(picture); };
    callbacks.frame_completed = [this](const FrameRecord& record) { note(record); };
    DisplayLoop loop(stage_->scene().platform(), loop_options, stage_->scene().store(), source_, std::move(callbacks));
    loop_ = &loop;
    extracting_ = false;
    status_.last_frames.clear();
    last_completed_.reset();
    try {
      while (loop.run_frame()) between_frames();
    } catch (const ContextLost&) {
      count(loop);
      throw;
    } catch (const WindowLost&) {
      finish(loop);
      throw;
    }
    finish(loop);
  }

  /// To the camera's pictures, once their size is known.
  void size_window() {
    if (window_sized_) return;
    const CameraModel& camera = stage_->camera_model();
    window_sized_ = feed_->camera_model_known() && is_same_camera(camera, feed_->camera_model());
    if (window_sized_for_ && is_same_camera(*window_sized_for_, camera)) return;
    window_sized_for_ = camera;
    const FrameComposer::Size size = stage_->wanted_window();
    window_->resize(size.width, size.height);
  }

  void finish(const DisplayLoop& loop) {
    count(loop);
    summary_.counters.describe(stage_->scene().store());
    if (const auto& directory = options_.replay.save_textures) {
      in_extraction_context(stage_->scene().platform(), [&] { save_textures(stage_->scene().store(), *directory); });
    }
  }

  void count(const DisplayLoop& loop) {
    const DisplayLoop::Statistics statistics = loop.statistics();
    const auto add = [](std::size_t& to, std::int64_t count) { to += static_cast<std::size_t>(count); };
    add(summary_.frames, statistics.schedule.frames);
    add(summary_.frames_late, statistics.schedule.late);
    add(summary_.frames_skipped, statistics.schedule.skipped);
    add(summary_.frames_missed, statistics.schedule.missed);
    summary_.counters.pictures_extracted += statistics.pictures_finished;
    if (begun_) summary_.objects_grown = live_gl_objects() - objects_at_first_;
    loop_ = nullptr;
  }

  /// The display server is gone: what can be kept without it.
  void save_what_can_be_saved() {
    wait_for_saving();
    const auto& directory = options_.replay.save_textures;
    if (!directory || !stage_) return;
    stage_->scene().platform().in_extraction([&] { save_textures(stage_->scene().store(), *directory); });
    spdlog::info("textures saved in {}", directory->string());
  }

  bool poll() {
    window_->poll_events();
    for (const Window::Key& key : window_->take_keys()) {
      // Function keys work wherever the keyboard is.
      if (stage_->interface().wants_keys() && key.chord.key < KeyChord::f1) {
        if (key.chord.key == KeyChord::escape) stage_->interface().leave();
        continue;
      }
      if (const auto action = action_of(key.chord, key.repeated)) control_.act(*action);
    }
    window_->set_full_screen(control_.settings().full_screen);
    return !control_.quit() && !window_->close_requested() && !interrupted();
  }

  void draw(const FrameMoment& moment) {
    if (lose_context_at_ && moment.number == *lose_context_at_) {
      lose_context_at_.reset();
      throw ContextLost("the graphics context was lost (asked for)");
    }
    if (window_->minimised()) return;
    const Timestamp t = source_.time_at(moment.seen);
    if (const std::uint64_t generation = source_.generation(); generation != generation_) {
      generation_ = generation;
      since_ = t;
      since_steady_ = moment.seen;
    }
    update_status(moment, t);
    // Live, the stamps' time is only estimated, and may leap.
    stage_->draw(moment, t, source_.is_live() ? source_.time_at(since_steady_) : since_, status_);
    drawn_ = true;
    if (control_.take_save_request()) save(t);
  }

  void present() {
    if (!std::exchange(drawn_, false)) return;
    window_->swap();
    if (std::exchange(first_, false)) {
      summary_.first_frame_after = process_age();
      spdlog::debug("first frame after {:.0f} ms, {:.0f} ms after the process began",
                    (steady_now() - started_).seconds() * 1e3, summary_.first_frame_after.seconds() * 1e3);
    }
  }

  /// Once all is there that was prepared while the first frames were shown. Only then time begins to pass, so that no
  /// picture is missed.
  void begin_extraction() {
    if (extracting_ || !stage_->scene().is_ready()) return;
    extracting_ = true;
    loop_->set_period(Duration::from_seconds(1 / wanted_rate()));
    loop_->set_extraction(&stage_->scene().extraction());
    if (std::exchange(begun_, true)) return;
    spdlog::debug("extraction after {:.0f} ms", (steady_now() - started_).seconds() * 1e3);
    objects_at_first_ = live_gl_objects();
    if (PlaybackClock* clock = feed_->clock()) clock->play();
  }

  /// What must not happen while a frame is being drawn.
  void between_frames() {
    begin_extraction();
    const ViewerControl::Settings& settings = control_.settings();
    if (settings.link != applied_link_) feed_->set_link(applied_link_ = settings.link);
    apply_extraction();
    if (control_.take_copy_request()) copy_command();
    if (const std::string refusal = control_.take_refusal(); !refusal.empty()) say(refusal);
    if (saving_.valid() && saving_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) wait_for_saving();
    size_window();
    set_title();
  }

  void apply_extraction() {
    const ExtractionOptions& wanted = control_.settings().extraction;
    if (!extracting_ || wanted == applied_extraction_ || stage_->interface().is_editing() || loop_->is_extracting())
      return;
    const Timestamp begun = steady_now();
    try {
      loop_->set_extraction(nullptr);
      stage_->set_extraction(wanted);
      char text[80];
      std::snprintf(text, sizeof text, "extraction changed (%.0f ms)", (steady_now() - begun).seconds() * 1e3);
      say(text);
    } catch (const InputError& error) {
      say(error.what(), true);
      control_.settings().extraction = applied_extraction_;
    }
    loop_->set_extraction(&stage_->scene().extraction());
    applied_extraction_ = control_.settings().extraction;
  }

  // Telling.

  void say(const std::string& text, bool is_error = false) {
    status_.message = text;
    status_.message_is_error = is_error;
    said_ = steady_now();
  }

  void note(const FrameRecord& record) {
    if (last_completed_) {
      const double passed = (record.completed - *last_completed_).seconds();
      status_.last_frames.push_back({static_cast<float>(passed * 1e3), record.completed > record.due});
      if (status_.last_frames.size() > ViewerStatus::kFrames) status_.last_frames.pop_front();
    }
    last_completed_ = record.completed;
    if (!present_waits_) fit_quality(record);
  }

  /// Full frames for as long as they leave extraction its time; the first ones, for which shaders are made, do not
  /// count. Once fast, always fast: a view that changes its looks again and again would be worse.
  void fit_quality(const FrameRecord& record) {
    if (fast_ || !extracting_) return;
    if (++frames_beside_extraction_ <= kFramesToWarmUp) return;
    drawing_.push_back(record.completed - record.started);
    if (std::ssize(drawing_) < kFramesToMeasure) return;
    std::ranges::nth_element(drawing_, drawing_.begin() + kFramesToMeasure / 2);
    const Duration drawing = *(drawing_.begin() + kFramesToMeasure / 2);
    drawing_.clear();
    fast_ = quality_that_fits(drawing, loop_->statistics().period) == ViewQuality::fast;
    if (!fast_) return;
    stage_->set_display_quality(ViewQuality::fast);
    spdlog::info("the view is drawn in fast quality: a frame takes {:.0f} ms in full", drawing.seconds() * 1e3);
  }

  void update_status(const FrameMoment& moment, Timestamp t) {
    const DisplayLoop::Statistics statistics = loop_->statistics();
    status_.now = t;
    status_.newest_picture.reset();
    if (moment.newest != nullptr) status_.newest_picture = moment.newest->record.captured;
    status_.extracting = loop_->is_extracting();
    status_.rate_wanted = 1 / statistics.period.seconds();
    status_.rate_reached = statistics.frames_per_second;
    status_.frames = static_cast<std::size_t>(statistics.schedule.frames);
    status_.frames_late = static_cast<std::size_t>(statistics.schedule.late);
    status_.frames_skipped = static_cast<std::size_t>(statistics.schedule.skipped);
    status_.frames_missed = static_cast<std::size_t>(statistics.schedule.missed);
    status_.pictures_per_second = statistics.pictures_per_second;
    status_.last_pictures.clear();
    const auto& pictures = statistics.last_pictures;
    const std::size_t skipped = pictures.size() - std::min(pictures.size(), ViewerStatus::kPictures);
    for (std::size_t i = skipped; i < pictures.size(); ++i) {
      ViewerStatus::Picture picture;
      for (std::size_t step = 0; step < kExtractionSteps; ++step) {
        picture.step_ms[step] = static_cast<float>(pictures[i].step_ms[step]);
      }
      picture.total_ms = static_cast<float>((pictures[i].finished - pictures[i].begun).seconds() * 1e3);
      status_.last_pictures.push_back(picture);
    }
    status_.source = source_.status();
    status_.registration = feed_->registration();
    feed_->tell(status_);
    status_.texture_bytes = stage_->scene().store().memory_bytes();
    status_.truth_known = stage_->truth_known();
    stage_->tell_probe(status_);
    if (!memory_asked_ || moment.now - *memory_asked_ > kMemoryInterval) {
      memory_asked_ = moment.now;
      status_.process_bytes = resident_bytes();
    }
    if (!status_.message.empty() && moment.now - said_ > kMessageTime) status_.message.clear();
  }

  void set_title() {
    const Timestamp now = steady_now();
    if (titled_ && now - *titled_ < kTitleInterval) return;
    titled_ = now;
    TitleInput title;
    title.name = status_.name;
    title.mode = control_.settings().choice.mode;
    title.delay = control_.settings().link.delay;
    title.rate = loop_->statistics().frames_per_second;
    if (const PlaybackClock* clock = feed_->clock()) {
      title.since_first = clock->now().time - clock->first();
      title.paused = !clock->playing();
      title.at_end = clock->at_end();
    } else {
      title.live = true;
      if (status_.newest_picture) title.age = status_.now - *status_.newest_picture;
    }
    // Between two pictures it is idle for a moment.
    if (const std::uint64_t generation = source_.generation();
        !extracting_ || loop_->is_extracting() || generation != settled_generation_) {
      extracted_ = now;
      settled_generation_ = generation;
    }
    title.extracting = now - extracted_ < kSettled;
    window_->set_title(viewer_title(title));
  }

  void copy_command() {
    const Recording* recording = feed_->recording();
    if (recording == nullptr) {
      say("a live stream cannot be shown again without a window; foreview record keeps it to be replayed", true);
      return;
    }
    // Headless replay writes the times of pictures: the one shown, or the one before.
    const auto index = recording->newest_before(feed_->camera(), feed_->clock()->now().time + Duration{1});
    ReplayOptions replay = options_.replay;
    replay.extraction = control_.settings().extraction;
    replay.delay = control_.settings().link.delay;
    const std::string command = headless_command(replay, control_.settings().choice, index.value_or(0));
    window_->copy_to_clipboard(command);
    spdlog::info("{}", command);
    say("copied: " + command);
  }

  // Saving.

  void save(Timestamp t) {
    wait_for_saving();
    const cv::Mat picture = stage_->take_picture();
    if (picture.empty()) return;
    const std::string stem =
        "foreview-" + status_.name + "-" + to_string(control_.settings().choice.mode) + "-" + feed_->time_in_name(t);
    std::filesystem::path file = options_.session.out / (stem + ".png");
    for (int i = 2; std::filesystem::exists(file); ++i) {
      file = options_.session.out / (stem + "-" + std::to_string(i) + ".png");
    }
    // Compressing takes longer than a frame.
    saving_ = std::async(std::launch::async, [file, picture] {
      write_png(file, picture);
      return file.string();
    });
  }

  void wait_for_saving() {
    if (!saving_.valid()) return;
    try {
      const std::string file = saving_.get();
      ++summary_.pictures_written;
      spdlog::info("saved {}", file);
      say("saved " + file);
    } catch (const InputError& error) {
      spdlog::error("{}", error.what());  // no reason to lose the window and its textures
      say(error.what(), true);
    }
  }

  void describe() {
    summary_.recording = feed_->name();
    summary_.camera = feed_->camera_model().name;
    if (const Recording* recording = feed_->recording()) {
      const Timestamp start = recording->first_stamp(feed_->camera());
      summary_.from_seconds = (feed_->clock()->first() - start).seconds();
      summary_.to_seconds = (feed_->clock()->last() - start).seconds();
    }
    summary_.source = source_.status();
    summary_.registration = feed_->registration();
    feed_->tell(status_);
    summary_.live = status_.live;
    summary_.counters.pictures_overwritten = summary_.source.overwritten;
    summary_.counters.pictures_damaged = summary_.source.damaged;
  }

  const ViewerOptions& options_;
  const Timestamp started_;
  std::optional<Window> window_;
  const std::unique_ptr<Feed> feed_;
  FrameSource& source_;
  ViewerControl control_;
  LinkOptions applied_link_;
  ViewerStatus status_;
  std::optional<ViewerStage> stage_;
  DisplayLoop* loop_ = nullptr;
  ExtractionOptions applied_extraction_;
  ViewerSummary summary_;

  std::optional<std::int64_t> lose_context_at_ = frame_to_lose_context_at();
  std::optional<CameraModel> window_sized_for_;
  bool window_sized_ = false, first_ = true, drawn_ = false;
  bool extracting_ = false, begun_ = false;  ///< with the present contexts; ever
  bool present_waits_ = false, fast_ = false;
  std::int64_t frames_beside_extraction_ = 0;
  std::vector<Duration> drawing_;  ///< of the last frames, in full quality
  long objects_at_first_ = 0;
  std::uint64_t generation_ = ~std::uint64_t{0};
  Timestamp since_, since_steady_;  ///< since when pictures have been waited for: the source's time, and real time
  Timestamp said_, extracted_;
  std::uint64_t settled_generation_ = 0;
  std::optional<Timestamp> last_completed_, memory_asked_, titled_;
  std::future<std::string> saving_;
};

}  // namespace

ViewerSummary view_feed(const ViewerOptions& options) {
  const long objects = live_gl_objects();
  ViewerSummary summary = ViewerSession(options).run();
  summary.objects_left = live_gl_objects() - objects;
  return summary;
}

}  // namespace foreview
