#pragma once
#include <memory>

#include "foreview/calib/registration.h"
#include "foreview/scene/polygon_model.h"
#include "foreview/server/frame_source.h"

namespace foreview {

/// Another source's pictures, each camera's poses and lens corrected by what its pictures show (Registration), in a
/// thread of low priority. Every picture is corrected as soon as it has come, whether it is taken or not: the
/// correction learns from it, and what is offered is never older than it must be. Of a camera's corrected pictures the
/// newest is offered; one that it displaces is overwritten, as anywhere. History waits until it is taken, and keeps no
/// new picture waiting.
///
/// A picture is offered before it is learnt from, which takes longer. At a new generation what waits is void; of what
/// was learnt, what all pictures have in common stays.
class RegisteredSource final : public FrameSource {
 public:
  /// `camera`: the operator's. Source and model must outlive it, and nobody else takes pictures from the source.
  RegisteredSource(FrameSource& source, const PolygonModel& model, std::size_t camera);
  ~RegisteredSource() override;

  [[nodiscard]] std::optional<IncomingFrame> take() override;
  [[nodiscard]] std::optional<IncomingFrame> take_new() override;
  /// The source's, but the operator's camera is where the picture of it that was captured last, of those taken in this
  /// generation, makes it out to be: so it fits what that picture leaves in the textures.
  [[nodiscard]] std::optional<PredictedState> predicted_state(Timestamp t) const override;
  /// Of that picture.
  [[nodiscard]] std::optional<CameraModel> registered_camera() const override;
  [[nodiscard]] SourceStatus status() override;
  [[nodiscard]] Timestamp time_at(Timestamp steady) const override;
  [[nodiscard]] bool is_live() const override;
  [[nodiscard]] std::uint64_t generation() const override;
  [[nodiscard]] std::size_t cameras() const override;
  [[nodiscard]] std::optional<CameraModel> camera_model(std::size_t camera) const override;

  /// Of the operator's camera, when the picture of it that was taken last had been corrected.
  [[nodiscard]] RegistrationStatus registration() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
