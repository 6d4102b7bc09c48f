#include "foreview/viewer/replay_pacing.h"

#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <functional>

#include "foreview/gpu/offscreen_context.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/output_file.h"
#include "foreview/server/recording_player.h"
#include "foreview/viewer/frame_quality.h"
#include "foreview/viewer/gl_debug.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/live_scene.h"
#include "foreview/viewer/pacing_measurement.h"
#include "foreview/viewer/pacing_report.h"
#include "foreview/viewer/predicted_view.h"
#include "foreview/viewer/preloaded_source.h"
#include "foreview/viewer/realtime.h"
#include "foreview/viewer/registered_source.h"
#include "foreview/viewer/render_target.h"
#include "foreview/viewer/replay_input.h"

namespace foreview {
namespace {

/// Pictures kept decoded for --back-to-back: 77 MiB of the workcell's.
constexpr std::size_t kPreloaded = 60;

template <class Number>
bool read(const char* begin, const char* end, Number& number) {
  const auto [stop, error] = std::from_chars(begin, end, number);
  return error == std::errc() && stop == end;
}

/// Contexts, scene and view, and one source for each run, so that each shows the same.
class PacedReplay {
 public:
  PacedReplay(const ReplayOptions& replay, const LinkOptions& link, const ReplayPacingOptions& options, bool quiet)
      : quiet_(quiet),
        debug_(gl_debug_from_environment()),
        realtime_(options.realtime && begin_realtime()),
        display_(OffscreenContext::Options{.debug = debug_ != GlDebug::off}),
        options_(options),
        link_(link),
        input_((install(), replay)),
        scene_(input_.model, live_scene_options(input_.options, input_.charts, input_.recording.initial_textures()),
               display_.display(), display_.context(), [this] { display_.make_current(); }),
        view_(scene_.store()),
        camera_(input_.recording.cameras()[input_.camera].model.undistorted()) {
    const Recording& recording = input_.recording;
    first_ = replay.from.empty() ? recording.first_stamp(input_.camera)
                                 : recording.parse_position(replay.from, "--from", input_.camera);
    last_ = replay.to.empty() ? recording.last_stamp(input_.camera)
                              : recording.parse_position(replay.to, "--to", input_.camera);
    if (last_ <= first_) throw InputError("--to", "does not lie behind --from; expected a later position");
    report_.recording = recording.name();
    report_.renderer = display_.renderer();
    report_.width = options.width;
    report_.height = options.height;
    report_.delay_seconds = replay.delay.seconds();
    report_.realtime = realtime_;
    report_.quality = to_string(choose_quality());
  }

  /// Which of the two there are to be.
  void run(bool frames, bool pictures) {
    if (interrupted()) return;
    begin_source(pictures);
    PacingRequest request;
    request.period = Duration::from_seconds(1 / *options_.rate);
    request.duration = options_.duration;
    request.extraction = pictures;
    request.poll = [] { return !interrupted(); };
    // Of long runs, as it goes on; at the end it is in the report.
    if (frames && request.duration > PacingRun::kInterval) {
      if (!quiet_) std::fputs(pacing_interval_heading().c_str(), stderr);
      request.interval_ended = [this](const PacingRun::Interval& interval) {
        if (!quiet_) std::fputs(pacing_text(interval).c_str(), stderr);
      };
    }
    request.draw = [this](const FrameMoment& moment) { draw(moment); };
    report_.runs.push_back(frames ? measure_pacing(scene_, source(), request)
                                  : measure_extraction_alone(scene_, source(), request));
    report_.registration = registered_ ? std::optional(registered_->registration()) : std::nullopt;
    if (const std::string error = source_->status().error; !error.empty()) spdlog::warn("{}", error);
  }
  [[nodiscard]] const PacingReport& report() const { return report_; }

 private:
  static bool begin_realtime() {
    const std::optional<std::string> refusal = enter_realtime();
    if (refusal) {
      spdlog::warn("--realtime: {}; goes on without. It takes CAP_SYS_NICE, or `ulimit -r` of at least 1", *refusal);
    }
    return !refusal;
  }
  void install() const {
    if (debug_ != GlDebug::off) install_debug_callback(debug_ == GlDebug::fatal);
  }
  void set_quality(ViewQuality quality) {
    quality_ = quality;
    target_.resize(options_.width, options_.height, "--size",
                   quality == ViewQuality::fast ? 1 : AntialiasedTarget::kSamples);
  }
  ViewQuality choose_quality() {
    set_quality(options_.quality.value_or(ViewQuality::full));
    if (!options_.quality) {
      const auto state = input_.recording.predicted_state(input_.camera, first_, input_.model);
      const Duration full = measure_frame(scene_.platform(), [&] {
        if (state) draw(*state);
      });
      set_quality(quality_that_fits(full, Duration::from_seconds(1 / *options_.rate)));
    }
    return quality_;
  }
  /// What is not to be extracted is not registered either: it would only take the display's time.
  void begin_source(bool pictures) {
    const OrdinaryPriority for_decoding;
    registered_.reset();
    source_.reset();
    if (options_.back_to_back) {
      source_ =
          std::make_unique<PreloadedSource>(input_.recording, input_.model, input_.camera, first_, last_, kPreloaded);
      return;
    }
    clock_ = std::make_unique<PlaybackClock>(PlaybackClock::Options{.first = first_, .last = last_, .loop = true});
    RecordingPlayer::Options player;
    player.link = link_;
    player.link.delay = input_.options.delay;
    player.camera = input_.camera;
    source_ = std::make_unique<RecordingPlayer>(input_.recording, input_.model, *clock_, player);
    if (pictures && input_.options.registration) registered_.emplace(*source_, input_.model, input_.camera);
  }
  [[nodiscard]] FrameSource& source() {
    if (registered_) return *registered_;
    return *source_;
  }
  void draw(const FrameMoment& moment) {
    if (const auto state = source().predicted_state(source().time_at(moment.seen))) draw(*state);
  }
  void draw(const PredictedState& state) {
    ViewStyle style;
    style.near_plane = input_.options.extraction.near_plane;
    style.quality = quality_;
    const CameraModel camera = registered_ ? registered_->registered_camera().value_or(camera_).undistorted() : camera_;
    view_.draw(camera, state, style, target_.framebuffer(), {0, 0, options_.width, options_.height}, false);
    static_cast<void>(target_.resolve());
  }

  const bool quiet_;
  const GlDebug debug_;
  const bool realtime_;
  OffscreenContext display_;
  const ReplayPacingOptions& options_;
  const LinkOptions& link_;
  ReplayInput input_;
  LiveScene scene_;
  PredictedView view_;
  AntialiasedTarget target_;
  ViewQuality quality_ = ViewQuality::full;
  CameraModel camera_;
  Timestamp first_, last_;
  std::unique_ptr<PlaybackClock> clock_;
  std::unique_ptr<FrameSource> source_;
  std::optional<RegisteredSource> registered_;
  PacingReport report_;
};

}  // namespace

void add_pacing_options(CLI::App& command, ReplayPacingOptions& options) {
  const auto add = [&](const char* name, const char* type, const char* help,
                       const std::function<void(const std::string&)>& read_text) {
    command.add_option_function<std::string>(name, read_text, help)->type_name(type);
  };
  add("--rate", "HZ",
      "Headless: no pictures, but frames at this rate beside extraction; prints when they were complete",
      [&options](const std::string& text) {
        double rate = 0;
        if (!read(text.data(), text.data() + text.size(), rate) || !(rate >= 1 && rate <= 1000)) {
          throw InputError("--rate", "'" + text + "' cannot be; expected 1 to 1000 frames a second");
        }
        options.rate = rate;
      });
  add("--duration", "TIME", "With --rate: for how long (default: 20s)", [&options](const std::string& text) {
    options.duration = Duration::parse(text, "--duration");
    if (options.duration <= Duration{} || options.duration > Duration::from_seconds(1e6)) {
      throw InputError("--duration", "'" + text + "' is out of range; expected more than 0 s, as in 20s");
    }
  });
  add("--size", "WxH", "With --rate: size of a frame in pixels (default: 800x600)",
      [&options](const std::string& text) {
        const std::size_t cross = text.find('x');
        const char* const end = text.data() + text.size();
        if (cross == std::string::npos || !read(text.data(), text.data() + cross, options.width) ||
            !read(text.data() + cross + 1, end, options.height) || options.width < 1 || options.height < 1) {
          throw InputError("--size", "'" + text + "' cannot be; expected a width and a height, as in 800x600");
        }
      });
  add("--pacing", "FILE", "With --rate: write every frame's and every picture's times to this file (JSON)",
      [&options](const std::string& text) { options.file = text; });
  command.add_flag("!--no-extraction", options.extraction, "With --rate: frames only");
  command.add_flag("--reference", options.reference,
                   "With --rate: before, as long each, extraction without frames and frames without extraction, to "
                   "compare with");
  command.add_flag("--realtime", options.realtime,
                   "With --rate: draw and extract ahead of ordinary programs (SCHED_RR), where the system allows it");
  command.add_flag("--back-to-back", options.back_to_back,
                   "With --rate: extract the next picture whenever one is finished, decoded beforehand; not when it "
                   "arrives; as it was recorded, without --registration");
}

void replay_pacing(const ReplayOptions& replay, const LinkOptions& link, const ReplayPacingOptions& options,
                   bool quiet) {
  if (options.file) check_output_file(*options.file, "--pacing");
  PacedReplay paced(replay, link, options, quiet);
  if (options.reference) {
    // In this order, so that the frames shown alone wear textures.
    paced.run(false, true);
    paced.run(true, false);
  }
  paced.run(true, options.extraction);
  if (!quiet) std::fputs(pacing_text(paced.report()).c_str(), stdout);
  if (options.file) write_file_whole(*options.file, pacing_json(paced.report()));
  throw_if_interrupted();
}

}  // namespace foreview
