#include "foreview/gpu/undistorter.h"

#include <algorithm>
#include <array>
#include <string>

#include "foreview/gpu/dispatch.h"
#include "foreview/scene/errors.h"

namespace foreview {

namespace {

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace

Undistorter::Undistorter() : program_(make_compute_program("undistort.comp.glsl")) {}

void Undistorter::make_room(int width, int height) {
  if (width <= room_width_ && height <= room_height_) return;
  room_width_ = std::max(width, room_width_);
  room_height_ = std::max(height, room_height_);
  lens_ = make_texture_2d(GL_RGBA8, room_width_, room_height_);
  undistorted_ = make_texture_2d(GL_RGBA8, room_width_, room_height_);
}

void Undistorter::check(const cv::Mat& picture, const CameraModel& camera, const std::string& where) {
  if (picture.empty() || picture.type() != CV_8UC3) throw InputError(where, "is no picture of 8-bit BGR");
  if (picture.cols != camera.width || picture.rows != camera.height) {
    throw InputError(where, "is " + size_text(picture.cols, picture.rows) + " pixels, expected its camera's " +
                                size_text(camera.width, camera.height));
  }
  GLint limit = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
  if (std::max(picture.cols, picture.rows) > limit) {
    throw InputError(where, "is " + size_text(picture.cols, picture.rows) +
                                " pixels, the graphics driver takes at most " + std::to_string(limit) + " on a side");
  }
}

void Undistorter::load(const cv::Mat& picture, const CameraModel& camera, const std::string& where) {
  begin(picture, camera, where);
  upload(picture, camera, 0, height_);
  undistort(camera, 0, height_);
}

void Undistorter::begin(const cv::Mat& picture, const CameraModel& camera, const std::string& where) {
  check(picture, camera, where);
  make_room(picture.cols, picture.rows);
  width_ = picture.cols;
  height_ = picture.rows;
}

void Undistorter::upload(const cv::Mat& picture, const CameraModel& camera, int first_row, int rows) {
  // OpenGL counts a row's length in whole pixels; OpenCV's may be anything.
  const cv::Mat part = picture.rowRange(first_row, first_row + rows);
  const cv::Mat band = part.step[0] % 3 == 0 ? part : part.clone();
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, static_cast<GLint>(band.step[0] / 3));
  // Three channels: alpha becomes 1.
  glTextureSubImage2D(camera.is_distorted() ? lens_.id() : undistorted_.id(), 0, 0, first_row, band.cols, band.rows,
                      GL_BGR, GL_UNSIGNED_BYTE, band.data);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
}

void Undistorter::undistort(const CameraModel& camera, int first_row, int rows) {
  if (!camera.is_distorted()) return;
  std::array<float, 8> k{};
  std::transform(camera.distortion.begin(), camera.distortion.end(), k.begin(),
                 [](double d) { return static_cast<float>(d); });
  glUseProgram(program_.id());
  glUniform2i(0, width_, height_);
  glUniform2f(1, static_cast<float>(camera.focal_length.x), static_cast<float>(camera.focal_length.y));
  glUniform2f(2, static_cast<float>(camera.principal_point.x), static_cast<float>(camera.principal_point.y));
  glUniform1i(3, camera.distortion_model == DistortionModel::fisheye ? 1 : 0);
  glUniform1fv(4, static_cast<GLsizei>(k.size()), k.data());
  glUniform2i(12, first_row, first_row + rows);
  glBindTextureUnit(0, lens_.id());
  glBindImageTexture(0, undistorted_.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
  dispatch_over(width_, rows);
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

cv::Mat Undistorter::read() const {
  cv::Mat result(height_, width_, CV_8UC4);
  if (result.empty()) return result;
  glGetTextureSubImage(undistorted_.id(), 0, 0, 0, 0, width_, height_, 1, GL_BGRA, GL_UNSIGNED_BYTE,
                       static_cast<GLsizei>(result.total() * result.elemSize()), result.data);
  return result;
}

}  // namespace foreview
