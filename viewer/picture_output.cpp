#include "foreview/viewer/picture_output.h"

#include <opencv2/imgcodecs.hpp>
#include <system_error>
#include <vector>

#include "foreview/scene/errors.h"
#include "foreview/scene/output_file.h"

namespace foreview {

void write_png(const std::filesystem::path& file, const cv::Mat& picture) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", picture, bytes)) {
    throw InputError(file.string(), "cannot be written: the picture cannot be encoded as PNG");
  }
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  if (error) throw InputError(file.string(), "cannot be written: " + error.message());
  write_file_whole(file, bytes);
}

}  // namespace foreview
