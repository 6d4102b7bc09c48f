#include "foreview/viewer/live_headless.h"

#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <deque>
#include <future>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "foreview/gpu/offscreen_context.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/output_file.h"
#include "foreview/viewer/formatted.h"
#include "foreview/viewer/frame_composer.h"
#include "foreview/viewer/frame_quality.h"
#include "foreview/viewer/gl_debug.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/live_frames.h"
#include "foreview/viewer/live_scene.h"
#include "foreview/viewer/operator_camera.h"
#include "foreview/viewer/pacing_measurement.h"
#include "foreview/viewer/pacing_report.h"
#include "foreview/viewer/picture_output.h"
#include "foreview/viewer/predicted_view.h"
#include "foreview/viewer/registration_report.h"
#include "foreview/viewer/replay_options_cli.h"
#include "foreview/viewer/undistortion.h"

namespace foreview {
namespace {

constexpr double kSoftwareRate = 33, kGreatestRate = 60;  // hertz
constexpr Duration kForever{static_cast<std::int64_t>(1e15)};
constexpr Duration kTellAgain{2'000'000'000};
constexpr std::size_t kFramesToWarmUp = 2, kFramesMeasured = 7;  // for the first ones shaders are made
constexpr std::size_t kMostBeingSaved = 16;                      // frames that wait for being compressed

using Json = nlohmann::ordered_json;

/// Contexts, feed, scene and view, in the order in which they need each other.
class LiveHeadless {
 public:
  explicit LiveHeadless(const LiveHeadlessOptions& options)
      : debug_(gl_debug_from_environment()),
        display_(OffscreenContext::Options{.debug = debug_ != GlDebug::off}),
        options_(options),
        feed_((install(), options.live), options.replay),
        scene_(feed_.model(), feed_.scene_options(options.replay.extraction), display_.display(), display_.context(),
               [this] { display_.make_current(); }),
        view_(scene_.store()),
        frames_(feed_.source(), feed_.camera(), nullptr) {
    operator_camera_.set_surroundings(feed_.surroundings());
    take_camera(feed_.camera_model());
    period_ = Duration::from_seconds(1 / options.rate.value_or(is_software() ? kSoftwareRate : kGreatestRate));
    quality_ = options.quality.value_or(options.choice.quality);
  }

  void run() {
    PacingRequest request;
    request.period = period_;
    request.warm_up = {};
    request.duration = options_.duration.value_or(kForever);
    request.poll = [this] { return poll(); };
    request.draw = [this](const FrameMoment& moment) { draw(moment); };
    request.displayed = [this](const PictureRecord& picture) { feed_.displayed(picture); };
    request.at_end = [this] {
      if (!options_.replay.save_textures) return;
      in_extraction_context(scene_.platform(),
                            [this] { save_textures(scene_.store(), *options_.replay.save_textures); });
    };
    begun_ = steady_now();
    run_ = measure_pacing(scene_, feed_.source(), request);
    while (!saving_.empty()) finish_saving();
  }

  void tell(bool quiet) {
    PacingReport pacing;
    pacing.recording = feed_.name();
    pacing.renderer = display_.renderer();
    pacing.width = size_.width;
    pacing.height = size_.height;
    pacing.quality = to_string(quality_);
    pacing.delay_seconds = options_.live.source.link.delay.seconds();
    pacing.registration = feed_.registration();
    pacing.runs.push_back(run_);
    if (!quiet) {
      std::fputs(pacing_text(pacing).c_str(), stdout);
      std::printf("%s\n", to_text(feed_.report()).c_str());
      if (!options_.out.empty()) std::printf("%zu frames saved in %s\n", frames_saved_, directory().string().c_str());
      std::fflush(stdout);
    }
    if (options_.pacing) write_file_whole(*options_.pacing, pacing_json(pacing));
    if (options_.json) write_file_whole(*options_.json, summary().dump(2) + "\n");
  }

 private:
  struct Saved {
    std::string file;
    Timestamp shown;                 ///< the robot's time that the frame is for
    std::optional<Timestamp> state;  ///< of the poses it shows
    Staleness staleness;
    std::vector<std::pair<std::size_t, Timestamp>> pictures;  ///< by camera, the newest
  };
  struct Phase {
    double seconds = 0;  ///< since the start
    Staleness staleness;
  };

  void install() const {
    if (debug_ != GlDebug::off) install_debug_callback(debug_ == GlDebug::fatal);
  }
  [[nodiscard]] bool is_software() const { return is_software_renderer(display_.renderer()); }
  [[nodiscard]] std::filesystem::path directory() const { return options_.out / to_string(options_.choice.mode); }

  /// Live, it becomes known, and may change.
  void take_camera(const CameraModel& camera) {
    camera_ = camera;
    composer_.emplace(view_, camera_, options_.replay.extraction.near_plane);
    size_ = composer_->native_size(options_.choice.mode);
    if (options_.width) size_ = {*options_.width, *options_.height};
  }

  bool poll() {
    if (interrupted()) return false;
    const Timestamp now = steady_now();
    const SourceStatus status = feed_.source().status();
    if (status.pictures_in != pictures_in_) {
      pictures_in_ = status.pictures_in;
      last_came_ = now;
    }
    if (now - told_at_ > kTellAgain) {
      told_at_ = now;
      // Silence once, not every two seconds.
      if (std::string text = to_text(feed_.report()); text != told_) {
        spdlog::info("{}", text);
        told_ = std::move(text);
      }
    }
    const bool all_used = pictures_in_ == status.used + status.overwritten + status.damaged + status.stateless;
    return !(options_.until_silent && pictures_in_ > 0 && now - last_came_ > *options_.until_silent && all_used &&
             !scene_.extraction().is_busy());
  }

  void draw(const FrameMoment& moment) {
    FrameSource& source = feed_.source();
    if (const CameraModel camera = feed_.camera_model(); !is_same_camera(camera, camera_)) take_camera(camera);
    if (source.generation() != generation_) {
      generation_ = source.generation();
      since_ = moment.seen;
      shown_.reset();
    }
    const Timestamp t = source.time_at(moment.seen);
    const FrameInput& input = frames_.at(t, source.time_at(since_), moment, options_.choice, [&](const Pose& recorded) {
      operator_camera_.apply(options_.choice, camera_.undistorted(), recorded);
      return operator_camera_.pose();
    });
    ViewChoice choice = options_.choice;
    choice.quality = quality_;
    const Timestamp begun = steady_now();
    composer_->compose(input, choice, size_);
    if (!options_.quality && quality_ == ViewQuality::full && is_software()) fit_quality(begun);
    if (phases_.empty() || phases_.back().staleness.level != input.staleness.level) {
      phases_.push_back({(moment.now - begun_).seconds(), input.staleness});
      if (phases_.size() > PacingRun::kKept) phases_.pop_front();
    }
    if (!options_.out.empty() && is_to_be_saved(moment)) save(t, moment, input);
  }

  /// As in a window: full frames for as long as they leave extraction its time.
  void fit_quality(Timestamp begun) {
    if (frames_measured_ > kFramesMeasured || ++frames_measured_ <= kFramesToWarmUp) return;
    scene_.platform().finish("a frame");
    drawing_.add(steady_now() - begun);
    if (frames_measured_ == kFramesMeasured) quality_ = quality_that_fits(drawing_.quantile(0.5), period_);
  }

  [[nodiscard]] bool is_to_be_saved(const FrameMoment& moment) {
    if (options_.every_time) {
      if (saved_at_ && moment.now - *saved_at_ < *options_.every_time) return false;
      saved_at_ = moment.now;
      return true;
    }
    for (const ShownPicture& picture : moment.pictures) {
      if (picture.record.camera != feed_.camera()) continue;
      if (shown_ == picture.record.captured) return false;
      shown_ = picture.record.captured;
      return pictures_shown_++ % options_.every == 0;
    }
    return false;
  }

  void save(Timestamp t, const FrameMoment& moment, const FrameInput& input) {
    composer_->compose(input, options_.choice, composer_->native_size(options_.choice.mode));
    Saved saved;
    saved.shown = t;
    saved.staleness = input.staleness;
    if (input.predicted) saved.state = input.predicted->stamp;
    for (const ShownPicture& picture : moment.pictures) {
      saved.pictures.emplace_back(picture.record.camera, picture.record.captured);
    }
    const std::filesystem::path file = directory() / (feed_.time_in_name(t) + ".png");
    saved.file = file.string();
    saved_.push_back(std::move(saved));
    if (saved_.size() > PacingRun::kKept) saved_.pop_front();
    while (saving_.size() >= kMostBeingSaved) finish_saving();
    // Compressing takes longer than a frame.
    saving_.push_back(
        std::async(std::launch::async, [file, picture = composer_->read()] { write_png(file, picture); }));
  }
  void finish_saving() {
    std::future<void> first = std::move(saving_.front());
    saving_.pop_front();
    try {
      first.get();
      ++frames_saved_;
    } catch (const InputError& error) {  // a full disk is no reason to stop
      spdlog::log(frames_unsaved_++ == 0 ? spdlog::level::err : spdlog::level::debug, "{}", error.what());
    }
  }

  [[nodiscard]] Json summary() const {
    Json phases = Json::array(), saved = Json::array();
    for (const Phase& phase : phases_) {
      phases.push_back(
          {{"seconds", phase.seconds}, {"level", to_string(phase.staleness.level)}, {"text", phase.staleness.text}});
    }
    const LiveReport report = feed_.report();
    for (const Saved& one : saved_) {
      Json pictures = Json::array();
      for (const auto& [camera, stamp] : one.pictures) {
        pictures.push_back({{"camera", report.cameras[camera].name}, {"captured", stamp.to_string()}});
      }
      saved.push_back({{"file", one.file},
                       {"shown", one.shown.to_string()},
                       {"state", one.state ? Json(one.state->to_string()) : Json(nullptr)},
                       {"level", to_string(one.staleness.level)},
                       {"severity", one.staleness.severity},
                       {"text", one.staleness.text},
                       {"pictures", std::move(pictures)}});
    }
    const PacingSummary pacing = summary_of(run_);
    Json json{{"format", "foreview-live"},
              {"version", 1},
              {"scene", feed_.name()},
              {"seconds", (run_.ended - run_.started).seconds()},
              {"frames", run_.schedule.frames},
              {"frames_late", run_.schedule.late},
              {"frames_skipped", run_.schedule.skipped},
              {"frames_missed", run_.schedule.missed},
              {"frame_interval_ms",
               {{"median", pacing.interval.median}, {"p99", pacing.interval.p99}, {"worst", pacing.interval.worst}}},
              {"pictures_displayed", report.displayed},
              {"frames_saved", frames_saved_},
              {"frames_not_saved", frames_unsaved_},
              {"streams_begun_anew", run_.restarts}};
    json.update(to_json(report));
    json["registration"] = to_json(feed_.registration());
    json["staleness"] = std::move(phases);
    json["saved"] = std::move(saved);
    return json;
  }

  const GlDebug debug_;
  OffscreenContext display_;
  const LiveHeadlessOptions& options_;
  LiveFeed feed_;
  LiveScene scene_;
  PredictedView view_;
  LiveFrames frames_;
  OperatorCamera operator_camera_;
  CameraModel camera_;
  std::optional<FrameComposer> composer_;
  FrameComposer::Size size_;
  Duration period_;
  ViewQuality quality_ = ViewQuality::full;
  std::size_t frames_measured_ = 0;
  LatencyWindow drawing_;

  PacingRun run_;
  Timestamp begun_, since_, last_came_, told_at_ = steady_now();
  std::uint64_t generation_ = ~std::uint64_t{0};
  std::string told_;
  std::size_t pictures_in_ = 0, pictures_shown_ = 0;
  std::optional<Timestamp> shown_;     ///< the picture of the operator's camera shown last
  std::optional<Timestamp> saved_at_;  ///< steady
  std::deque<Phase> phases_;
  std::deque<Saved> saved_;
  std::size_t frames_saved_ = 0, frames_unsaved_ = 0;
  std::deque<std::future<void>> saving_;
};

template <class Number>
bool read(const char* begin, const char* end, Number& number) {
  const auto [stop, error] = std::from_chars(begin, end, number);
  return error == std::errc() && stop == end;
}

Duration parse_positive(const std::string& text, const std::string& option) {
  const Duration duration = Duration::parse(text, option);
  if (duration <= Duration{} || duration > Duration::from_seconds(1e6)) {
    throw InputError(option, "'" + text + "' is out of range; expected more than 0 s, as in 20s");
  }
  return duration;
}

}  // namespace

void add_live_headless_options(CLI::App& command, bool& headless, LiveHeadlessOptions& options) {
  command.add_flag("--headless", headless,
                   "Live: no window; frames are drawn all the same, and saved in DIR/VIEW if --out DIR is given");
  const auto add = [&](const char* name, const char* type, const char* help, auto read_text) {
    command.add_option_function<std::string>(name, read_text, help)->type_name(type);
  };
  add("--every", "N|TIME",
      "Live, headless: save when every Nth picture is first shown, or a frame as often as this, as in 500ms (default: "
      "1)",
      [&options](const std::string& text) {
        const bool is_number = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
        if (is_number) {
          options.every = parse_count(text, "--every");
        } else {
          options.every_time = parse_positive(text, "--every");
        }
      });
  add("--duration", "TIME", "Live, headless: end after this time (default: with Ctrl-C)",
      [&options](const std::string& text) { options.duration = parse_positive(text, "--duration"); });
  add("--until-silent", "TIME", "Live, headless: end when no picture has come for this long, after the first",
      [&options](const std::string& text) { options.until_silent = parse_positive(text, "--until-silent"); });
  add("--size", "WxH", "Live, headless: size of the frames that are not saved (default: the camera's)",
      [&options](const std::string& text) {
        int width = 0, height = 0;
        const std::size_t cross = text.find('x');
        const char* const end = text.data() + text.size();
        if (cross == std::string::npos || !read(text.data(), text.data() + cross, width) ||
            !read(text.data() + cross + 1, end, height) || width < 1 || height < 1) {
          throw InputError("--size", "'" + text + "' cannot be; expected a width and a height, as in 800x600");
        }
        options.width = width;
        options.height = height;
      });
  add("--pacing", "FILE", "Live, headless: write every frame's and every picture's times to this file (JSON)",
      [&options](const std::string& text) { options.pacing = text; });
}

void view_live_headless(const LiveHeadlessOptions& options, bool quiet) {
  if (options.pacing) check_output_file(*options.pacing, "--pacing");
  if (options.json) check_output_file(*options.json, "--json");
  LiveHeadless live(options);
  live.run();
  live.tell(quiet);
  throw_if_interrupted();
}

}  // namespace foreview
