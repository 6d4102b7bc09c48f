#include "foreview/viewer/bench_pictures.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace foreview {

BenchPictures::BenchPictures(std::vector<std::string> names, Decode decode, std::size_t bytes, std::size_t memory)
    : names_(std::move(names)),
      decode_(std::move(decode)),
      most_(std::max<std::size_t>(1, memory / std::max<std::size_t>(1, bytes))),
      decode_ms_(names_.size()) {}

const CameraFrame* BenchPictures::get(std::size_t i) {
  if (i < first_ || i >= first_ + kept_.size()) {
    kept_.clear();  // before decoding: never more than memory allows
    first_ = i;
    const std::size_t end = std::min(names_.size(), i + most_);
    for (std::size_t k = i; k < end; ++k) {
      const auto start = std::chrono::steady_clock::now();
      kept_.push_back(decode_(k));
      decode_ms_[k] = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    }
  }
  const std::optional<CameraFrame>& frame = kept_[i - first_];
  return frame ? &*frame : nullptr;
}

std::vector<std::size_t> spread_evenly(std::size_t size, std::size_t count) {
  count = std::min(size, count);
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < count; ++i) {
    indices.push_back(count == 1 ? size / 2 : (i * (size - 1) + (count - 1) / 2) / (count - 1));
  }
  return indices;
}

BenchPictures pictures_of(Recording& recording, const PolygonModel& model, std::size_t camera, Timestamp first,
                          Timestamp last, std::size_t count) {
  const Recording::Camera& from = recording.cameras()[camera];
  std::vector<std::size_t> all, chosen;
  for (std::size_t i = 0; i < from.pictures.size(); ++i) {
    if (from.pictures[i].stamp >= first && from.pictures[i].stamp <= last) all.push_back(i);
  }
  std::vector<std::string> names;
  for (const std::size_t i : spread_evenly(all.size(), count)) {
    chosen.push_back(all[i]);
    names.push_back(from.pictures[all[i]].stem);
  }
  const std::size_t bytes = std::size_t{3} * static_cast<std::size_t>(from.model.width * from.model.height);
  return {
      std::move(names),
      [&recording, &model, camera, chosen](std::size_t i) { return recording.read_frame(camera, chosen[i], model); },
      bytes};
}

}  // namespace foreview
