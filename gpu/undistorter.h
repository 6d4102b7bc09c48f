#pragma once
#include <opencv2/core/mat.hpp>

#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/camera_model.h"

namespace foreview {

/// Brings a camera's picture onto the GPU and takes its lens distortion out (rule 0 of PerPolygonExtraction): the
/// result belongs to camera.undistorted(). Needs a current context in every member. Textures grow with the largest
/// picture so far and are kept.
class Undistorter {
 public:
  Undistorter();
  /// Throws InputError naming `where` if load() would refuse the picture.
  static void check(const cv::Mat& picture, const CameraModel& camera, const std::string& where);
  /// `picture`: CV_8UC3 BGR of the camera's size. Throws InputError naming `where` if it is not, or if the driver takes
  /// no texture of this size.
  void load(const cv::Mat& picture, const CameraModel& camera, const std::string& where = "picture");
  /// The same in pieces: begin() as load(), then all rows with upload(), then all with undistort(), which does nothing
  /// for cameras without distortion. The picture is the same with every call.
  void begin(const cv::Mat& picture, const CameraModel& camera, const std::string& where);
  void upload(const cv::Mat& picture, const CameraModel& camera, int first_row, int rows);
  void undistort(const CameraModel& camera, int first_row, int rows);
  /// GL_RGBA8; its first width() x height() texels are the undistorted picture, row 0 on top, alpha 1 where a pixel is
  /// usable, else 0.
  [[nodiscard]] GLuint texture() const { return undistorted_.id(); }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// The undistorted picture, CV_8UC4 BGRA, alpha 255 or 0.
  [[nodiscard]] cv::Mat read() const;

 private:
  void make_room(int width, int height);

  GlProgram program_;
  GlTexture lens_, undistorted_;
  int width_ = 0, height_ = 0, room_width_ = 0, room_height_ = 0;
};

}  // namespace foreview
