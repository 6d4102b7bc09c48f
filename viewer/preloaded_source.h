#pragma once
#include <cstddef>
#include <vector>

#include "foreview/recordings/recording.h"
#include "foreview/server/frame_source.h"

namespace foreview {

/// A recording's pictures, decoded beforehand and given whenever one is asked for, one after the other and from the
/// first again: what saturates extraction, for measuring. Its time is the recording's: it passes as steady_clock does
/// and begins anew at the end; pictures count as taken at the moment at which they are given out, so that each is newer
/// than the one before.
class PreloadedSource final : public FrameSource {
 public:
  /// `count` pictures of the camera from first to last, spread evenly. Damaged ones are left out. InputError where none
  /// is left.
  PreloadedSource(Recording& recording, const PolygonModel& model, std::size_t camera, Timestamp first, Timestamp last,
                  std::size_t count);

  [[nodiscard]] std::optional<IncomingFrame> take() override;
  [[nodiscard]] std::optional<PredictedState> predicted_state(Timestamp t) const override;
  [[nodiscard]] SourceStatus status() override;
  [[nodiscard]] Timestamp time_at(Timestamp steady) const override { return steady; }
  [[nodiscard]] std::uint64_t generation() const override { return 0; }
  [[nodiscard]] std::size_t cameras() const override { return recording_.cameras().size(); }
  [[nodiscard]] std::optional<CameraModel> camera_model(std::size_t camera) const override {
    return recording_.cameras().at(camera).model;
  }

 private:
  const Recording& recording_;
  const PolygonModel& model_;
  std::size_t camera_;
  Timestamp first_, last_, begun_;
  struct Picture {
    CameraFrame frame;
    std::size_t index = 0;
  };
  std::vector<Picture> pictures_;
  std::size_t next_ = 0;
};

}  // namespace foreview
