#include "foreview/gpu/batched/picture_setup.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "foreview/gpu/batched/batched_extraction.h"

namespace foreview::batched {
namespace {

/// Of a projected polygon's corners, pixels: rule 5.
bool is_thin(const std::vector<glm::dvec2>& corners) {
  double twice_area = 0, perimeter = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec2& a = corners[i];
    const glm::dvec2& b = corners[i + 1 < corners.size() ? i + 1 : 0];
    twice_area += (a.x - corners[0].x) * (b.y - corners[0].y) - (b.x - corners[0].x) * (a.y - corners[0].y);
    perimeter += glm::distance(a, b);
  }
  return 2 * std::abs(twice_area) < perimeter && perimeter <= BatchedExtraction::kThinPerimeter;
}

}  // namespace

PictureSetup::PictureSetup(const PolygonModel& model, const ChartLayout& layout, const ChartGeometry& geometry)
    : model_(model),
      layout_(layout),
      geometry_(geometry),
      part_buffer_(GlBuffer::create()),
      plane_buffer_(GlBuffer::create()) {
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    Bound& bound = bounds_.emplace_back();
    const std::size_t corners = model.polygons()[i].corner_count;
    for (std::size_t k = 0; k < corners; ++k) bound.centre += model.corner(i, k) / static_cast<double>(corners);
    for (std::size_t k = 0; k < corners; ++k) {
      bound.radius = std::max(bound.radius, glm::distance(bound.centre, model.corner(i, k)));
    }
  }
  chart_listed_.resize(layout.groups.size());
  slacks_.resize(layout.groups.size());
  planes_.resize(model.polygons().size());
  rows_.resize(model.polygons().size());
  parts_.resize(model.parts().size());
  glNamedBufferStorage(part_buffer_.id(), static_cast<GLsizeiptr>(parts_.size() * sizeof(glm::mat4)), nullptr,
                       GL_DYNAMIC_STORAGE_BIT);
  glNamedBufferStorage(plane_buffer_.id(), static_cast<GLsizeiptr>(planes_.size() * sizeof(PlaneOnGpu)), nullptr,
                       GL_DYNAMIC_STORAGE_BIT);
}

void PictureSetup::prepare(const CameraModel& camera, const CaptureState& state, double near_plane) {
  begin(camera, state, near_plane);
  cull(0, polygons());
  finish();
}

void PictureSetup::begin(const CameraModel& camera, const CaptureState& state, double near_plane) {
  camera_ = camera;
  near_plane_ = near_plane;
  views_.resize(parts_.size());
  const Pose camera_from_world = state.world_from_camera.inverse();
  const double left = -camera.principal_point.x / camera.focal_length.x;
  const double right = (camera.width - camera.principal_point.x) / camera.focal_length.x;
  const double top = -camera.principal_point.y / camera.focal_length.y;
  const double bottom = (camera.height - camera.principal_point.y) / camera.focal_length.y;
  const glm::dvec3 normals[4] = {{1, 0, -left}, {-1, 0, right}, {0, 1, -top}, {0, -1, bottom}};
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Pose camera_from_part = camera_from_world * state.world_from_part[i];
    PartView& view = views_[i];
    view.rotation = glm::mat3_cast(camera_from_part.rotation);
    view.translation = camera_from_part.translation;
    const glm::dmat3 back = glm::transpose(view.rotation);
    for (int side = 0; side < 4; ++side) {
      const glm::dvec3 normal = glm::normalize(normals[side]);
      view.sides[side] = glm::dvec4(back * normal, glm::dot(normal, view.translation));
    }
    view.front = glm::dvec4(back * glm::dvec3(0, 0, 1), view.translation.z - near_plane);
    glm::dmat4 matrix(view.rotation);
    matrix[3] = glm::dvec4(camera_from_part * geometry_.part_centre(i), 1);
    parts_[i] = glm::mat4(matrix);
  }

  visible_.clear();
  by_distance_.clear();
  for (const std::uint32_t chart : charts_) chart_listed_[chart] = false;
  charts_.clear();
  back_faces_ = outside_ = 0;
}

void PictureSetup::cull(std::size_t first, std::size_t count) {
  const CameraModel& camera = camera_;
  const double near_plane = near_plane_;
  for (auto i = static_cast<std::uint32_t>(first); i < first + count; ++i) {
    const Polygon& polygon = model_.polygons()[i];
    const PartView& view = views_[polygon.part];
    const Bound& bound = bounds_[i];
    const auto distance = [&](const glm::dvec4& plane) { return glm::dot(glm::dvec3(plane), bound.centre) + plane.w; };
    bool out = distance(view.front) < -bound.radius;
    for (const glm::dvec4& side : view.sides) out = out || distance(side) < -bound.radius;
    if (out) {
      // What lies outside the picture is not drawn, so nobody asks for its plane.
      ++outside_;
      continue;
    }
    const glm::dvec3 normal = view.rotation * polygon.normal;
    double offset = polygon.offset + glm::dot(normal, view.translation);  // dot(normal, point in camera)
    if (std::abs(offset) < 1e-9) offset = offset < 0 ? -1e-9 : 1e-9;
    double least = 1e300, greatest = 0, top = 1e9, bottom = -1e9;
    corners_.clear();
    bool in_front = true;
    for (const std::uint32_t vertex : model_.corners_of(i)) {
      const glm::dvec3& p = model_.vertices()[vertex];
      const double z =
          view.rotation[0].z * p.x + view.rotation[1].z * p.y + view.rotation[2].z * p.z + view.translation.z;
      const double w = 1 / std::max(z, near_plane);
      const double y =
          view.rotation[0].y * p.x + view.rotation[1].y * p.y + view.rotation[2].y * p.z + view.translation.y;
      const double v = y * w * camera.focal_length.y + camera.principal_point.y;
      const double x =
          view.rotation[0].x * p.x + view.rotation[1].x * p.y + view.rotation[2].x * p.z + view.translation.x;
      corners_.emplace_back(x * w * camera.focal_length.x, v);
      in_front = in_front && z > near_plane;
      // What is cut at the near plane may be anywhere.
      top = std::min(top, z > near_plane ? v : -1e9);
      bottom = std::max(bottom, z > near_plane ? v : 1e9);
      least = std::min(least, w);
      greatest = std::max(greatest, w);
    }
    const glm::dvec2 slope = glm::dvec2(normal) / (offset * camera.focal_length);
    const double slack = std::abs(slope.x) + std::abs(slope.y);
    by_distance_.emplace_back(static_cast<float>(-greatest), i);
    rows_[i] = {static_cast<float>(top - 1), static_cast<float>(bottom + 1)};
    PlaneOnGpu& plane = planes_[i];
    plane = {{static_cast<float>(slope.x), static_cast<float>(slope.y), static_cast<float>(normal.z / offset),
              in_front && is_thin(corners_) ? 1.0F : 0.0F},
             {static_cast<float>(least), static_cast<float>(greatest),
              static_cast<float>(std::min(slack, greatest - least)), offset < 0 ? 1.0F : 0.0F}};
    if (offset >= 0) {
      ++back_faces_;
    } else {
      const glm::dvec2& density = layout_.charts[i].texels_per_metre;
      const double texel_in_pixels =
          std::max(camera.focal_length.x, camera.focal_length.y) * greatest / std::min(density.x, density.y);
      visible_.push_back({i, texel_in_pixels > BatchedExtraction::kFootprint});
      const std::uint32_t chart = layout_.charts[i].group;
      if (!chart_listed_[chart]) {
        charts_.push_back(chart);
        slacks_[chart] = 0;
      }
      chart_listed_[chart] = true;
      slacks_[chart] = std::max(slacks_[chart], plane.range[2]);
    }
  }
}

void PictureSetup::finish() {
  std::sort(by_distance_.begin(), by_distance_.end());
  front_to_back_.clear();
  for (const auto& [distance, polygon] : by_distance_) front_to_back_.push_back(polygon);
  glNamedBufferSubData(part_buffer_.id(), 0, static_cast<GLsizeiptr>(parts_.size() * sizeof(glm::mat4)), parts_.data());
  glNamedBufferSubData(plane_buffer_.id(), 0, static_cast<GLsizeiptr>(planes_.size() * sizeof(PlaneOnGpu)),
                       planes_.data());
}

void PictureSetup::bind() const {
  const GLuint buffers[] = {part_buffer_.id(), plane_buffer_.id()};
  glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, 0, 2, buffers);
}

}  // namespace foreview::batched
