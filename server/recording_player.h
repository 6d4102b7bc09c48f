#pragma once
#include <memory>

#include "foreview/recordings/recording.h"
#include "foreview/server/frame_source.h"
#include "foreview/server/playback_clock.h"
#include "foreview/server/simulated_link.h"

namespace foreview {

/// Plays a recording as if it came in live over a simulated link: a picture *arrives* when the clock's display time
/// passes its capture stamp plus what the link takes (strictly: as in a replay, a picture is known after its delay, not
/// at it). Pictures are read and decoded in a thread of low priority, ahead of their arrival, in bounded memory. A
/// newer picture of the same camera displaces one that was not taken; so it is with pictures that arrive faster than
/// they can be decoded. A late picture that arrives after a newer one was taken is offered, as long as nothing newer is
/// unread: extraction goes by capture stamps, it only fills.
///
/// After a seek (and at a loop's leap back) what arrived before is void: generation() counts up, the newest picture
/// that an operator would have at that time comes first, then older ones as history, newest first. New arrivals go
/// before history.
///
/// A picture that cannot be read is dropped and counted. Where its file is gone although it was there (recording
/// deleted, disk removed), status().error says so; it is cleared when a picture can be read again.
class RecordingPlayer final : public FrameSource {
 public:
  struct Options {
    LinkOptions link;
    std::size_t camera = 0;         ///< whose recorded pose is the operator's
    std::size_t history = 0;        ///< pictures of each camera sent after a seek beside the newest one
    std::size_t decoded_ahead = 8;  ///< pictures, of all cameras
    std::size_t decoded_bytes = std::size_t{256} << 20;  ///< at most, but one picture in any case
  };
  /// Recording, model and clock must outlive the player. Throws InputError as check_link_options(), and where there is
  /// no such camera.
  RecordingPlayer(const Recording& recording, const PolygonModel& model, PlaybackClock& clock, const Options& options);
  ~RecordingPlayer() override;

  [[nodiscard]] std::optional<IncomingFrame> take() override;
  [[nodiscard]] std::optional<IncomingFrame> take_new() override;
  [[nodiscard]] std::optional<PredictedState> predicted_state(Timestamp t) const override;
  [[nodiscard]] SourceStatus status() override;
  [[nodiscard]] Timestamp time_at(Timestamp steady) const override;
  [[nodiscard]] std::uint64_t generation() const override;
  [[nodiscard]] std::size_t cameras() const override;
  [[nodiscard]] std::optional<CameraModel> camera_model(std::size_t camera) const override;

  /// For all pictures not arrived yet, those under way too. Throws InputError as check_link_options().
  void set_link(const LinkOptions& options);
  [[nodiscard]] LinkOptions link() const;
  void set_history(std::size_t pictures);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
