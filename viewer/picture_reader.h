#pragma once
#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace foreview {

class Recording;

/// Reads pictures of a recording in a thread of its own, of low priority, so that whoever needs one for display never
/// waits for the disk or for decoding. The newest wish counts; others are forgotten.
class PictureReader {
 public:
  /// The recording must outlive the reader.
  PictureReader(const Recording& recording, std::size_t camera);
  ~PictureReader();
  PictureReader(const PictureReader&) = delete;
  PictureReader& operator=(const PictureReader&) = delete;

  struct Read {
    std::size_t index = 0;
    cv::Mat picture;  ///< empty where it cannot be read
  };
  /// Wishes for this picture, and gives the one read last, which may be another or none yet. Never waits.
  [[nodiscard]] std::optional<Read> wish(std::size_t index);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
