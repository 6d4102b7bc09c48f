#pragma once
#include <memory>
#include <string>
#include <vector>

#include "foreview/server/clock_estimate.h"
#include "foreview/server/frame_source.h"
#include "foreview/server/live_sink.h"
#include "foreview/server/simulated_link.h"

namespace foreview {

/// The image server (spec 11) without its network: what comes in live, from several cameras, is brought together with
/// the poses at capture, decoded in a thread of low priority, and offered, newest first.
///
/// A picture is offered when the camera's model, its pose at capture and that of all parts are known: it waits for
/// them at most `state_wait`, then it is dropped and counted as stateless. World, cameras and parts are frames of tf: a
/// part is where the frame of its name is, and where the model has it as long as no such frame was heard of.
///
/// A stream that begins anew (sender restarted, clock set back) is a new generation: what moved is forgotten.
///
/// Memory is bounded, whatever comes: a few undecoded pictures per camera, one decoded, tf by TfBuffer::Options. With a
/// simulated link, pictures wait undecoded for their delay, waiting_bytes at most.
class LiveSource final : public FrameSource, public LiveSink {
 public:
  struct Camera {
    std::string name;             ///< for messages to the user
    std::string frame;            ///< its optical frame; empty: the pictures' frame_id
    bool has_pose_topic = false;  ///< its pose comes by on_pose(), not by tf
  };
  struct Options {
    std::vector<Camera> cameras;
    std::size_t operator_camera = 0;  ///< whose pose predicted_state() gives
    std::string world_frame = "world";
    std::vector<std::string> parts;           ///< the model's, in its order: world_from_part has one pose for each
    std::vector<std::string> required_parts;  ///< these are waited for even if no frame of their name was heard of
    Duration state_wait{250'000'000};
    LinkOptions link;
    std::size_t waiting_bytes = std::size_t{256} << 20;
    std::size_t most_waiting = 200;  ///< pictures per camera, undecoded
    ClockEstimate::Options clock;    ///< of the robot; synchronised, it is compared with Unix time
  };
  /// Throws InputError where there is no camera.
  explicit LiveSource(Options options);
  ~LiveSource() override;

  void on_picture(std::size_t camera, EncodedPicture picture, const Reception& reception) override;
  /// What cannot be used is logged once, and the camera's last model stays.
  void on_camera_info(std::size_t camera, const CameraInfoMessage& info) override;
  void on_transforms(const TransformMessage& message, bool is_static) override;
  void on_pose(std::size_t camera, const PoseMessage& pose) override;
  /// Not used: parts follow tf.
  void on_joints(const JointStateMessage& /*joints*/) override {}

  [[nodiscard]] std::optional<IncomingFrame> take() override;
  /// The state at t, or the newest known before: its stamp says which.
  [[nodiscard]] std::optional<PredictedState> predicted_state(Timestamp t) const override;
  [[nodiscard]] SourceStatus status() override;
  [[nodiscard]] Timestamp time_at(Timestamp steady) const override;
  [[nodiscard]] bool is_live() const override { return true; }
  [[nodiscard]] std::uint64_t generation() const override;
  [[nodiscard]] std::size_t cameras() const override;
  [[nodiscard]] std::optional<CameraModel> camera_model(std::size_t camera) const override;

  /// For pictures that come from now on. Throws InputError as check_link_options().
  void set_link(const LinkOptions& options);

  /// Of the last pictures.
  struct Latency {
    std::size_t pictures = 0;
    Duration median, p99;       ///< from the last packet's arrival to being available, simulated link left out
    Duration decoding_median;   ///< of that, decoding
    double decoding_share = 0;  ///< of all of that time
    Duration transport_median;  ///< from capture to arrival, by the clocks' estimate
    double drift = 0;           ///< ClockEstimate::State::drift
    ClockMode clock_mode = ClockMode::estimated;
    Duration clock_uncertainty;  ///< ClockEstimate::State::uncertainty
    std::size_t clock_jumps = 0;
    std::string clock_warning;  ///< ClockEstimate::State::warning
  };
  [[nodiscard]] Latency latency() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
