#include "foreview/server/camera_info.h"

#include <cmath>

#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"

namespace foreview {
namespace {

constexpr std::uint32_t kLargestSide = 16384;  // pixels, as in camera.yaml
constexpr double kLargestPixel = 1e7;
constexpr double kShortestFocalLength = 1e-3;  // pixels; smaller ones vanish when they are divided by the binning
constexpr double kLargestCoefficient = 1e9;
constexpr double kPixelCentre = 0.5;  // ROS counts from the centre of the upper left pixel, we from its corner

void set_distortion(CameraModel& camera, const CameraInfoMessage& info, const std::string& where) {
  std::size_t used = info.d.size();
  while (used > 0 && info.d[used - 1] == 0) --used;
  for (const double k : info.d) {
    if (!(std::abs(k) <= kLargestCoefficient))
      throw InputError(where, "d holds " + number_text(k) + ", which no lens has");
  }
  const std::string& model = info.distortion_model;
  const std::size_t n = info.d.size();
  const bool is_fisheye = model == "equidistant" || model == "fisheye";  // distorts with coefficients of zero, too
  if (used == 0 && !is_fisheye && (n == 0 || model.empty() || model == "none")) return;
  bool is_right = false;
  if (model.empty() || model == "plumb_bob" || model == "rational_polynomial") {
    camera.distortion_model = DistortionModel::plumb_bob;
    is_right = n == 4 || n == 5 || n == 8 || ((n == 12 || n == 14) && used <= 8);
  } else if (is_fisheye) {
    camera.distortion_model = DistortionModel::fisheye;
    is_right = n == 4;
  } else {
    throw InputError(
        where, "distortion_model is " + in_quotes(model) + "; expected plumb_bob, rational_polynomial or equidistant");
  }
  if (used == 0 && !is_fisheye) camera.distortion_model = DistortionModel::none;
  if (!is_right) {
    throw InputError(where, std::to_string(n) + " coefficients do not fit " + in_quotes(model) +
                                "; expected 4, 5 or 8 (equidistant: 4)");
  }
  for (std::size_t i = 0; i < used; ++i) camera.distortion[i] = info.d[i];
}

}  // namespace

CameraModel camera_from_info(const CameraInfoMessage& info, const std::string& where) {
  const auto side = [&](std::uint32_t pixels, const char* name) {
    if (pixels < 1 || pixels > kLargestSide) {
      throw InputError(where, std::string(name) + " is " + std::to_string(pixels) + " pixels; expected 1 to 16384");
    }
    return static_cast<int>(pixels);
  };
  CameraModel camera;
  camera.width = side(info.width, "width");
  camera.height = side(info.height, "height");
  const auto& k = info.k;
  if (k[0] == 0) throw InputError(where, "the camera is not calibrated (k[0] is 0); expected its intrinsics");
  if (!(k[0] >= kShortestFocalLength && k[0] <= kLargestPixel && k[4] >= kShortestFocalLength &&
        k[4] <= kLargestPixel)) {
    throw InputError(where, "focal lengths are " + number_text(k[0]) + " and " + number_text(k[4]) +
                                "; expected pixels, greater than 0");
  }
  if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    throw InputError(where, "k is not [fx, 0, cx, 0, fy, cy, 0, 0, 1]");
  }
  if (!(std::abs(k[2]) <= kLargestPixel && std::abs(k[5]) <= kLargestPixel)) {
    throw InputError(where, "the principal point is " + number_text(k[2]) + ", " + number_text(k[5]));
  }
  camera.focal_length = {k[0], k[4]};
  camera.principal_point = {k[2] + kPixelCentre, k[5] + kPixelCentre};
  set_distortion(camera, info, where);

  const auto& roi = info.roi;
  if (roi.width != 0 || roi.height != 0) {
    if (roi.x_offset > info.width || roi.width > info.width - roi.x_offset || roi.y_offset > info.height ||
        roi.height > info.height - roi.y_offset) {
      throw InputError(where, "the region of interest leaves the picture");
    }
    camera.width = side(roi.width, "roi.width");
    camera.height = side(roi.height, "roi.height");
    camera.principal_point -= glm::dvec2(roi.x_offset, roi.y_offset);
  }
  const auto bin = [&](std::uint32_t binning, int& pixels, double& focal, double& principal) {
    if (binning <= 1) return;
    if (binning > static_cast<std::uint32_t>(pixels)) throw InputError(where, "binning leaves no picture");
    pixels /= static_cast<int>(binning);
    focal /= binning;
    principal /= binning;
  };
  bin(info.binning_x, camera.width, camera.focal_length.x, camera.principal_point.x);
  bin(info.binning_y, camera.height, camera.focal_length.y, camera.principal_point.y);
  return camera;
}

CameraInfoMessage info_from_camera(const CameraModel& camera) {
  CameraInfoMessage info;
  info.width = static_cast<std::uint32_t>(camera.width);
  info.height = static_cast<std::uint32_t>(camera.height);
  info.k = {camera.focal_length.x,
            0,
            camera.principal_point.x - kPixelCentre,
            0,
            camera.focal_length.y,
            camera.principal_point.y - kPixelCentre,
            0,
            0,
            1};
  const auto& d = camera.distortion;
  if (camera.distortion_model == DistortionModel::fisheye) {
    info.distortion_model = "equidistant";
    info.d.assign(d.begin(), d.begin() + 4);
  } else if (d[5] != 0 || d[6] != 0 || d[7] != 0) {
    info.distortion_model = "rational_polynomial";
    info.d.assign(d.begin(), d.end());
  } else {
    info.distortion_model = "plumb_bob";
    info.d.assign(d.begin(), d.begin() + 5);
  }
  return info;
}

}  // namespace foreview
