#pragma once
#include <string>

#include "foreview/server/recording_player.h"
#include "foreview/viewer/feed.h"
#include "foreview/viewer/registered_source.h"
#include "foreview/viewer/replay_input.h"

namespace foreview {

/// A recording, played as if it came in live over a simulated link.
class RecordingFeed final : public Feed {
 public:
  struct Options {
    ReplayOptions replay;
    LinkOptions link;
    double speed = 1;  ///< recorded seconds per second
    bool loop = false;
  };
  /// Time stands still at the start until clock()->play(). Needs a current GL context. Throws InputError as
  /// ReplayInput, find_span() and RecordingPlayer do.
  explicit RecordingFeed(const Options& options);

  [[nodiscard]] const std::string& name() const override { return input_.recording.name(); }
  [[nodiscard]] FrameSource& source() override;
  [[nodiscard]] const PolygonModel& model() const override { return input_.model; }
  [[nodiscard]] LiveScene::Options scene_options(const ExtractionOptions& extraction) const override;
  [[nodiscard]] std::size_t camera() const override { return input_.camera; }
  [[nodiscard]] CameraModel camera_model() const override;
  [[nodiscard]] CameraSurroundings surroundings() const override;
  [[nodiscard]] std::optional<RegistrationStatus> registration() const override;
  [[nodiscard]] const Recording* recording() const override { return &input_.recording; }
  [[nodiscard]] PlaybackClock* clock() override { return &clock_; }
  void set_link(const LinkOptions& options) override { player_.set_link(options); }
  void tell(ViewerStatus& status) override;
  [[nodiscard]] std::string time_in_name(Timestamp t) const override;

  [[nodiscard]] const ReplaySpan& span() const { return span_; }

 private:
  ReplayInput input_;
  ReplaySpan span_;
  PlaybackClock clock_;
  RecordingPlayer player_;
  std::optional<RegisteredSource> registered_;
};

}  // namespace foreview
