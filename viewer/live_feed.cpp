#include "foreview/viewer/live_feed.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "foreview/recordings/builtin.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/viewer/formatted.h"
#include "foreview/viewer/replay_input.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;

/// Counts and latencies cost some sorting.
constexpr Duration kTellAgain{200'000'000};

/// Until camera_info was heard.
CameraModel stand_in_camera() {
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.focal_length = {525, 525};
  camera.principal_point = {320, 240};
  return camera;
}

bool names_recording(const fs::path& scene) {
  const std::vector<std::string> names = builtin_recording_names();
  std::error_code error;
  return fs::is_directory(scene, error) ||
         (!fs::exists(scene, error) && std::find(names.begin(), names.end(), scene.string()) != names.end());
}

LiveFeed::Scene scene_of_recording(const LiveFeed::Options& options, const ReplayOptions& replay) {
  ReplayOptions with_recording = replay;
  with_recording.recording = options.scene;
  with_recording.scene.reset();
  with_recording.camera.clear();
  ReplayInput input(with_recording);
  LiveFeed::Scene scene;
  scene.name = input.recording.name();
  scene.charts = input.charts;
  scene.initial_textures = input.recording.initial_textures();
  for (const auto& [part, trajectory] : input.recording.part_trajectories()) scene.moving_parts.push_back(part);
  const std::vector<Recording::Camera>& cameras = input.recording.cameras();
  const auto same = std::find_if(cameras.begin(), cameras.end(), [&](const Recording::Camera& camera) {
    return camera.name == options.source.cameras[options.source.operator_camera].name;
  });
  const Recording::Camera& camera = same == cameras.end() ? cameras.front() : *same;
  scene.camera = camera.model;
  std::vector<Pose> poses;
  for (const auto& sample : camera.world_from_camera.samples()) poses.push_back(sample.pose);
  const auto state = input.recording.predicted_state(0, input.recording.first_stamp(), input.model);
  const std::vector<Pose> parts = state ? state->world_from_part : std::vector<Pose>(input.model.parts().size());
  scene.surroundings = find_surroundings(input.model, parts, poses);
  scene.model = std::move(input.model);
  return scene;
}

LiveFeed::Scene scene_of_file(const LiveFeed::Options& options, const ReplayOptions& replay) {
  std::error_code error;
  if (!fs::is_regular_file(options.scene, error)) {
    throw InputError("--scene", "no such file: " + options.scene.string() +
                                    "; expected a polygon model, a recording's directory or a built-in recording");
  }
  replay.extraction.validate();
  LiveFeed::Scene scene;
  scene.name = options.scene.stem().string();
  scene.model = import_scene(options.scene, {.scale = options.scale});
  scene.charts = chart_options_for(replay, scene.model);
  scene.camera = stand_in_camera();
  scene.surroundings = find_surroundings(scene.model, std::vector<Pose>(scene.model.parts().size()), {});
  return scene;
}

}  // namespace

LiveFeed::LiveFeed(const Options& options, const ReplayOptions& replay)
    : scene_(names_recording(options.scene) ? scene_of_recording(options, replay) : scene_of_file(options, replay)),
      replay_(replay),
      name_(scene_.name),
      topics_(options.cameras),
      camera_(options.source.operator_camera) {
  LiveSource::Options source = options.source;
  for (const Part& part : scene_.model.parts()) source.parts.push_back(part.name);
  source.required_parts = scene_.moving_parts;
  for (const LiveSource::Camera& camera : source.cameras) camera_names_.push_back(camera.name);
  node_ = std::make_unique<DdsNode>(options.network);
  source_ = std::make_unique<LiveSource>(std::move(source));
  shown_ = source_.get();
  if (replay.registration) shown_ = &registered_.emplace(*source_, scene_.model, camera_);
  receiver_ = std::make_unique<LiveReceiver>(*node_, topics_, *source_);
}

LiveScene::Options LiveFeed::scene_options(const ExtractionOptions& extraction) const {
  LiveScene::Options options = live_scene_options(replay_, scene_.charts, scene_.initial_textures);
  options.extraction = extraction;
  return options;
}

CameraModel LiveFeed::camera_model() const {
  return source_->camera_model(camera_).value_or(scene_.camera);
}

LiveReport LiveFeed::report() const {
  LiveReport report;
  const SourceStatus status = shown_->status();
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    report.cameras.push_back({camera_names_[i], topics_[i].image, status.cameras[i], receiver_->lost(i)});
  }
  report.latency = source_->latency();
  report.displayed = pictures_displayed_;
  report.display_median = displayed_.quantile(0.5);
  report.display_p99 = displayed_.quantile(0.99);
  report.missing = receiver_->missing();
  return report;
}

std::optional<RegistrationStatus> LiveFeed::registration() const {
  return registered_ ? std::optional(registered_->registration()) : std::nullopt;
}

void LiveFeed::tell(ViewerStatus& status) {
  const Timestamp now = steady_now();
  if (!told_ || now - told_at_ > kTellAgain) {
    told_ = report();
    told_at_ = now;
  }
  status.live = told_;
}

void LiveFeed::displayed(const PictureRecord& picture) {
  displayed_.add(picture.age_when_displayed);
  ++pictures_displayed_;
}

std::string LiveFeed::time_in_name(Timestamp t) const {
  return formatted("%.3f", t.seconds());
}

}  // namespace foreview
