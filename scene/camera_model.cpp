#include "foreview/scene/camera_model.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>

namespace foreview {
namespace {

/// Distorted coordinates and their derivative by the undistorted ones (columns: d/dx, d/dy).
struct Distorted {
  glm::dvec2 point;
  glm::dmat2 derivative;
};

Distorted distort_plumb_bob(const std::array<double, 8>& c, const glm::dvec2& p) {
  const double k1 = c[0], k2 = c[1], p1 = c[2], p2 = c[3], k3 = c[4], k4 = c[5], k5 = c[6], k6 = c[7];
  const double x = p.x, y = p.y, r2 = x * x + y * y;
  const double numerator = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double denominator = 1 + r2 * (k4 + r2 * (k5 + r2 * k6));
  const double radial = numerator / denominator;
  const double numerator_slope = k1 + r2 * (2 * k2 + r2 * 3 * k3);
  const double denominator_slope = k4 + r2 * (2 * k5 + r2 * 3 * k6);
  const double slope = (numerator_slope - radial * denominator_slope) / denominator;  // d radial / d r2
  Distorted d;
  d.point = {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  d.derivative[0] = {radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x, 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y};
  d.derivative[1] = {2 * x * y * slope + 2 * p1 * x + 2 * p2 * y, radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x};
  return d;
}

double fisheye_angle(const std::array<double, 8>& c, double theta) {
  const double t2 = theta * theta;
  return theta * (1 + t2 * (c[0] + t2 * (c[1] + t2 * (c[2] + t2 * c[3]))));
}

}  // namespace

bool CameraModel::is_distorted() const {
  if (distortion_model == DistortionModel::none) return false;
  // A fisheye lens bends even with all coefficients zero.
  if (distortion_model == DistortionModel::fisheye) return true;
  for (const double k : distortion) {
    if (k != 0) return true;
  }
  return false;
}

CameraModel CameraModel::undistorted() const {
  CameraModel result = *this;
  result.distortion_model = DistortionModel::none;
  result.distortion.fill(0);
  return result;
}

glm::dvec2 CameraModel::distort(const glm::dvec2& p) const {
  switch (distortion_model) {
    case DistortionModel::none:
      return p;
    case DistortionModel::plumb_bob:
      return distort_plumb_bob(distortion, p).point;
    case DistortionModel::fisheye: {
      const double r = glm::length(p);
      if (r < 1e-12) return p;
      return p * (fisheye_angle(distortion, std::atan(r)) / r);
    }
  }
  return p;
}

glm::dvec2 CameraModel::undistort(const glm::dvec2& distorted) const {
  switch (distortion_model) {
    case DistortionModel::none:
      return distorted;
    case DistortionModel::plumb_bob: {
      glm::dvec2 p = distorted;
      for (int i = 0; i < 20; ++i) {
        const Distorted d = distort_plumb_bob(distortion, p);
        const double determinant = glm::determinant(d.derivative);
        if (!(std::abs(determinant) > 1e-12)) break;
        const glm::dvec2 step = glm::inverse(d.derivative) * (distorted - d.point);
        p += step;
        if (glm::dot(step, step) < 1e-24) break;
      }
      return p;
    }
    case DistortionModel::fisheye: {
      const double wanted = glm::length(distorted);
      if (wanted < 1e-12) return distorted;
      double theta = wanted;
      for (int i = 0; i < 20; ++i) {
        const double t2 = theta * theta;
        const double slope =
            1 + t2 * (3 * distortion[0] + t2 * (5 * distortion[1] + t2 * (7 * distortion[2] + t2 * 9 * distortion[3])));
        if (!(std::abs(slope) > 1e-12)) break;
        const double step = (wanted - fisheye_angle(distortion, theta)) / slope;
        theta += step;
        if (std::abs(step) < 1e-12) break;
      }
      // Beyond 90 degrees there is no point on the plane z = 1; just short of it stands for "far outside".
      theta = std::min(std::max(theta, 0.0), 1.5533);
      return distorted * (std::tan(theta) / wanted);
    }
  }
  return distorted;
}

glm::dvec2 CameraModel::pixel_from_camera(const glm::dvec3& point_in_camera) const {
  return distort(glm::dvec2(point_in_camera) / point_in_camera.z) * focal_length + principal_point;
}

glm::dvec3 CameraModel::ray_from_pixel(const glm::dvec2& pixel) const {
  return {undistort((pixel - principal_point) / focal_length), 1.0};
}

glm::dmat4 CameraModel::clip_from_camera(double near) const {
  const double w = width, h = height;
  glm::dmat4 m(0.0);
  m[0][0] = 2 * focal_length.x / w;
  m[1][1] = 2 * focal_length.y / h;
  m[2][0] = 2 * principal_point.x / w - 1;
  m[2][1] = 2 * principal_point.y / h - 1;
  m[2][3] = 1;
  m[3][2] = near;
  return m;
}

}  // namespace foreview
