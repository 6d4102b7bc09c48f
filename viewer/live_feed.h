#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "foreview/server/dds/dds_node.h"
#include "foreview/server/latency_window.h"
#include "foreview/server/live_receiver.h"
#include "foreview/server/live_source.h"
#include "foreview/viewer/feed.h"
#include "foreview/viewer/live_report.h"
#include "foreview/viewer/registered_source.h"
#include "foreview/viewer/replayer.h"

namespace foreview {

/// Live streams of a robot, heard over DDS. The model is that of a file or of a recording of the same place, which then
/// also says how fine textures are, which they are at first, which parts move, and what the camera is like until its
/// camera_info was heard.
class LiveFeed final : public Feed {
 public:
  struct Options {
    std::filesystem::path scene;  ///< a model's file, a recording's directory or a built-in recording
    double scale = 1;             ///< metres per unit of a model's file; a recording knows its own
    DdsOptions network;
    std::vector<CameraTopics> cameras;
    LiveSource::Options source;  ///< parts are filled in
  };
  /// Of `replay`, what is said of textures, extraction and the operator's camera. Needs a current GL context. Throws
  /// InputError where the scene or the network cannot be used, or there is no such camera.
  LiveFeed(const Options& options, const ReplayOptions& replay);

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] FrameSource& source() override { return *shown_; }
  [[nodiscard]] const PolygonModel& model() const override { return scene_.model; }
  [[nodiscard]] LiveScene::Options scene_options(const ExtractionOptions& extraction) const override;
  [[nodiscard]] std::size_t camera() const override { return camera_; }
  [[nodiscard]] CameraModel camera_model() const override;
  [[nodiscard]] bool camera_model_known() const override { return source_->camera_model(camera_).has_value(); }
  [[nodiscard]] CameraSurroundings surroundings() const override { return scene_.surroundings; }
  [[nodiscard]] std::optional<RegistrationStatus> registration() const override;
  void set_link(const LinkOptions& options) override { source_->set_link(options); }
  void tell(ViewerStatus& status) override;
  void displayed(const PictureRecord& picture) override;
  [[nodiscard]] std::string time_in_name(Timestamp t) const override;

  [[nodiscard]] LiveReport report() const;

  /// What is known before anything was heard.
  struct Scene {
    std::string name;
    PolygonModel model;
    ChartOptions charts;
    std::optional<std::filesystem::path> initial_textures;
    std::vector<std::string> moving_parts;
    CameraSurroundings surroundings;
    CameraModel camera;  ///< a stand-in
  };

 private:
  Scene scene_;
  ReplayOptions replay_;
  std::string name_;
  std::vector<CameraTopics> topics_;
  std::vector<std::string> camera_names_;
  std::size_t camera_ = 0;
  // In this order: the receiver ends first.
  std::unique_ptr<DdsNode> node_;
  std::unique_ptr<LiveSource> source_;
  std::optional<RegisteredSource> registered_;
  FrameSource* shown_ = nullptr;
  std::unique_ptr<LiveReceiver> receiver_;
  LatencyWindow displayed_;
  std::size_t pictures_displayed_ = 0;
  std::optional<LiveReport> told_;
  Timestamp told_at_;  ///< steady
};

}  // namespace foreview
