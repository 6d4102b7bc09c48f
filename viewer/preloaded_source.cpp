#include "foreview/viewer/preloaded_source.h"

#include "foreview/scene/errors.h"
#include "foreview/viewer/bench_pictures.h"

namespace foreview {

PreloadedSource::PreloadedSource(Recording& recording, const PolygonModel& model, std::size_t camera, Timestamp first,
                                 Timestamp last, std::size_t count)
    : recording_(recording), model_(model), camera_(camera), first_(first), last_(last), begun_(steady_now()) {
  const auto& entries = recording.cameras()[camera].pictures;
  std::vector<std::size_t> within;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].stamp >= first && entries[i].stamp <= last) within.push_back(i);
  }
  for (const std::size_t i : spread_evenly(within.size(), count)) {
    if (auto frame = recording.read_frame(camera, within[i], model))
      pictures_.push_back({std::move(*frame), within[i]});
  }
  if (pictures_.empty()) {
    throw InputError(recording.directory().string(), "none of its pictures can be read; expected at least one");
  }
}

std::optional<IncomingFrame> PreloadedSource::take() {
  const Picture& picture = pictures_[next_++ % pictures_.size()];
  IncomingFrame incoming;
  incoming.frame = picture.frame;
  incoming.frame.state.stamp = steady_now();
  incoming.camera = camera_;
  incoming.index = picture.index;
  incoming.received = incoming.frame.state.stamp;
  return incoming;
}

std::optional<PredictedState> PreloadedSource::predicted_state(Timestamp t) const {
  const std::int64_t length = (last_ - first_).nanoseconds + 1;
  const std::int64_t since = std::max<std::int64_t>(0, (t - begun_).nanoseconds) % length;
  auto state = recording_.predicted_state(camera_, first_ + Duration{since}, model_);
  if (state) state->stamp = t;
  return state;
}

SourceStatus PreloadedSource::status() {
  SourceStatus status;
  status.pictures_in = status.used = next_;
  status.now = steady_now();
  return status;
}

}  // namespace foreview
