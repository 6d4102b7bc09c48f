#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "foreview/recordings/recording.h"
#include "foreview/scene/camera_frame.h"

namespace foreview {

/// Pictures to be measured with, decoded beforehand, so that decoding is no part of any figure; a bounded number of
/// them at a time.
class BenchPictures {
 public:
  using Decode = std::function<std::optional<CameraFrame>(std::size_t)>;  ///< none: damaged
  static constexpr std::size_t kMemory = std::size_t{256} << 20;          ///< bytes of decoded pictures, at most

  /// `decode` is asked for picture i of names.size(), each of some `bytes`.
  BenchPictures(std::vector<std::string> names, Decode decode, std::size_t bytes, std::size_t memory = kMemory);

  [[nodiscard]] std::size_t size() const { return names_.size(); }
  [[nodiscard]] const std::string& name(std::size_t i) const { return names_[i]; }
  /// Picture i, or null where it is damaged; valid until the next call. Decodes, where i is not among the pictures
  /// kept, as many from there on as memory allows.
  [[nodiscard]] const CameraFrame* get(std::size_t i);
  /// What decoding it took, once get() has given it, milliseconds.
  [[nodiscard]] double decode_ms(std::size_t i) const { return decode_ms_[i]; }

 private:
  std::vector<std::string> names_;
  Decode decode_;
  std::size_t most_;
  std::size_t first_ = 0;
  std::vector<std::optional<CameraFrame>> kept_;
  std::vector<double> decode_ms_;
};

/// `count` indices spread evenly over 0..size-1, both ends included; all where there are no more.
[[nodiscard]] std::vector<std::size_t> spread_evenly(std::size_t size, std::size_t count);

/// The camera's pictures from `first` to `last`, `count` of them spread evenly. `recording` and `model` must outlive
/// the result.
[[nodiscard]] BenchPictures pictures_of(Recording& recording, const PolygonModel& model, std::size_t camera,
                                        Timestamp first, Timestamp last, std::size_t count);

}  // namespace foreview
