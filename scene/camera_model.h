#pragma once
#include <array>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace foreview {

enum class DistortionModel {
  none,
  plumb_bob,  ///< k1 k2 p1 p2 k3, or with k4 k5 k6 ("rational_polynomial"): OpenCV's and ROS's standard model
  fisheye,    ///< k1 k2 k3 k4 on the angle to the axis: OpenCV's fisheye, ROS's "equidistant"
};

/// A pinhole camera with lens distortion. Optical frame: x right, y down, z forward. Pixels: (0.5, 0.5) is the centre
/// of the upper left pixel, so `principal_point` is OpenCV's plus (0.5, 0.5); the conversion happens where files are
/// read and OpenCV is called, nowhere else.
struct CameraModel {
  int width = 0;                     ///< pixels
  int height = 0;                    ///< pixels
  glm::dvec2 focal_length{0, 0};     ///< pixels
  glm::dvec2 principal_point{0, 0};  ///< pixels, (0.5, 0.5) = centre of the upper left pixel
  DistortionModel distortion_model = DistortionModel::none;
  std::array<double, 8> distortion{};  ///< in the order that DistortionModel gives; the rest zero
  std::string name;

  [[nodiscard]] bool is_distorted() const;
  /// The same camera without its lens distortion: the one that undistorted pictures belong to.
  [[nodiscard]] CameraModel undistorted() const;

  /// Normalised image coordinates (x/z, y/z) to the same with lens distortion. plumb_bob and fisheye as in OpenCV 4.
  [[nodiscard]] glm::dvec2 distort(const glm::dvec2& normalised) const;
  /// The inverse of distort by Newton steps; accurate to 1e-9 within the picture of a sane lens.
  [[nodiscard]] glm::dvec2 undistort(const glm::dvec2& distorted) const;

  /// Pixel of a point in the camera's optical frame, with distortion. z must be positive.
  [[nodiscard]] glm::dvec2 pixel_from_camera(const glm::dvec3& point_in_camera) const;
  /// Direction (z = 1) through a pixel, distortion taken out.
  [[nodiscard]] glm::dvec3 ray_from_pixel(const glm::dvec2& pixel) const;

  /// Spec 3 (eq. 4.1-4.8), the only place that knows OpenGL's y-up, -z-forward camera: clip coordinates from the
  /// *optical* frame, without distortion. Depth is reversed and has no far plane, for glClipControl(GL_LOWER_LEFT,
  /// GL_ZERO_TO_ONE) and GL_GREATER: w = z, depth = near / z, 1 at `near` (metres) and 0 at infinity; cleared to 0.
  /// Pictures lie in textures and framebuffers with their *upper* row first (row 0 of memory = top), so the matrix
  /// maps the picture's top to y = -1: pixel (u, v) lands on framebuffer coordinates (u, v).
  [[nodiscard]] glm::dmat4 clip_from_camera(double near) const;
};

/// Reads a ROS camera_info YAML: image_width, image_height, camera_name, camera_matrix.data (9), distortion_model
/// ("plumb_bob", "rational_polynomial", "equidistant" or "fisheye", "none"; absent: none, or plumb_bob where there are
/// coefficients) and distortion_coefficients.data; other keys are ignored. OpenCV's own calibration files and the
/// output of `rostopic echo` on a camera_info topic (width, height, K, D) are read too. Throws InputError naming the
/// file, line and key on anything missing, of a wrong type, not finite, or impossible; sides are 1 to 16384 pixels.
[[nodiscard]] CameraModel read_camera_yaml(const std::filesystem::path& file);
/// Same from text; `where` names the source in errors.
[[nodiscard]] CameraModel parse_camera_yaml(const std::string& text, const std::string& where);
[[nodiscard]] std::string to_camera_yaml(const CameraModel& camera);

}  // namespace foreview
