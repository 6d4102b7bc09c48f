#include "foreview/gpu/per_polygon/picture_data.h"

#include <algorithm>
#include <iterator>

namespace foreview::per_polygon {

namespace {

template <typename T>
void upload(const GlBuffer& buffer, const std::vector<T>& data) {
  // Never empty: an empty buffer cannot be bound.
  const T nothing{};
  const T* first = data.empty() ? &nothing : data.data();
  glNamedBufferData(buffer.id(), static_cast<GLsizeiptr>(sizeof(T) * std::max<std::size_t>(data.size(), 1)), first,
                    GL_STREAM_DRAW);
}

void set(float (&target)[4], double a, double b, double c = 0, double d = 0) {
  target[0] = static_cast<float>(a);
  target[1] = static_cast<float>(b);
  target[2] = static_cast<float>(c);
  target[3] = static_cast<float>(d);
}

}  // namespace

PictureData::PictureData(const PolygonModel& model, const ChartLayout& layout, const PolygonTextures& textures)
    : model_(model),
      layout_(layout),
      textures_(textures),
      corner_buffer_(GlBuffer::create()),
      plane_buffer_(GlBuffer::create()),
      edge_buffer_(GlBuffer::create()),
      polygon_buffer_(GlBuffer::create()),
      neighbour_buffer_(GlBuffer::create()) {
  std::vector<std::uint32_t> neighbours;
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    first_neighbour_.push_back(static_cast<std::uint32_t>(neighbours.size()));
    std::ranges::copy(model.neighbours_of(i), std::back_inserter(neighbours));
  }
  upload(neighbour_buffer_, neighbours);
}

void PictureData::prepare(const CameraModel& camera, const CaptureState& state, double near_plane) {
  visible_.clear();
  std::ranges::fill(fates_, 0);
  corners_.clear();
  planes_.clear();
  edges_.clear();
  polygons_.clear();
  const Pose camera_from_world = state.world_from_camera.inverse();
  std::vector<Pose> camera_from_part;
  for (const Pose& world_from_part : state.world_from_part) {
    camera_from_part.push_back(camera_from_world * world_from_part);
  }

  Projector projector(camera, near_plane);
  ProjectedPolygon projected;
  std::vector<glm::dvec3> corners;
  for (std::uint32_t i = 0; i < model_.polygons().size(); ++i) {
    const Polygon& polygon = model_.polygons()[i];
    const Pose& pose = camera_from_part[polygon.part];
    corners.clear();
    for (std::size_t k = 0; k < polygon.corner_count; ++k) {
      const glm::dvec3& p = corners.emplace_back(pose * model_.corner(i, k));
      for (int axis = 0; axis < 3; ++axis) corners_.push_back(static_cast<float>(p[axis]));
    }
    const glm::dvec3 normal = pose.rotate(polygon.normal);
    projector.project(corners, normal, polygon.offset + glm::dot(normal, pose.translation), projected);
    PlaneOnGpu& plane = planes_.emplace_back();
    set(plane.inverse_z, projected.inverse_z_slope.x, projected.inverse_z_slope.y, projected.inverse_z_at_reference);
    set(plane.reference, projected.reference.x, projected.reference.y, projected.least_inverse_z,
        projected.greatest_inverse_z);
    ++fates_[static_cast<std::size_t>(projected.fate)];
    if (projected.fate == Fate::visible) add_visible(i, projected, camera, pose);
  }
  upload(corner_buffer_, corners_);
  upload(plane_buffer_, planes_);
  upload(edge_buffer_, edges_);
  upload(polygon_buffer_, polygons_);
}

void PictureData::add_visible(std::uint32_t polygon, const ProjectedPolygon& projected, const CameraModel& camera,
                              const Pose& camera_from_part) {
  visible_.push_back({polygon, projected.box, projected.shorter_side, !projected.outline.empty()});
  const PolygonTextures::Item& texture = textures_[polygon];
  const Chart& chart = layout_.charts[polygon];
  PolygonOnGpu& on_gpu = polygons_.emplace_back();
  const PixelBox& box = projected.box;
  on_gpu.box[0] = box.x;
  on_gpu.box[1] = box.y;
  on_gpu.box[2] = box.width;
  on_gpu.box[3] = box.height;
  on_gpu.texture_size[0] = texture.width;
  on_gpu.texture_size[1] = texture.height;
  on_gpu.texture_size[2] = static_cast<std::int32_t>(polygon);
  on_gpu.texture_size[3] = 0;
  on_gpu.lists[0] = static_cast<std::uint32_t>(edges_.size());
  on_gpu.lists[1] = static_cast<std::uint32_t>(projected.outline.size());
  on_gpu.lists[2] = first_neighbour_[polygon];
  on_gpu.lists[3] = static_cast<std::uint32_t>(model_.neighbours_of(polygon).size());
  for (const ProjectedPolygon::Edge& edge : projected.outline) {
    EdgeOnGpu& edge_on_gpu = edges_.emplace_back();
    set(edge_on_gpu.line, edge.from.x, edge.from.y, edge.direction.x, edge.direction.y);
    set(edge_on_gpu.extent, edge.length, 0);
  }

  // From the texture, s and t in 0..1, to the camera and on to the pixel relative to the reference (spec 3 and 6).
  const PolygonFrame& frame = texture.frame;
  const glm::dvec3 along_s = camera_from_part.rotate(frame.x_axis) * frame.extent.x;
  const glm::dvec3 along_t = camera_from_part.rotate(frame.y_axis) * frame.extent.y;
  const glm::dvec3 origin = camera_from_part * frame.origin;
  const glm::dvec2 centre = camera.principal_point - projected.reference;
  const auto u = [&](const glm::dvec3& p) { return camera.focal_length.x * p.x + centre.x * p.z; };
  const auto v = [&](const glm::dvec3& p) { return camera.focal_length.y * p.y + centre.y * p.z; };
  set(on_gpu.u_row, u(along_s), u(along_t), u(origin));
  set(on_gpu.v_row, v(along_s), v(along_t), v(origin));
  set(on_gpu.z_row, along_s.z, along_t.z, origin.z);
  set(on_gpu.reference, projected.reference.x, projected.reference.y);

  on_gpu.chart_block[0] = chart.origin.x;
  on_gpu.chart_block[1] = chart.origin.y;
  on_gpu.chart_block[2] = chart.size.x;
  on_gpu.chart_block[3] = chart.size.y;
  // The map is affine: three of its points tell it.
  const auto texel = [&](const glm::dvec2& in_block) {
    const glm::dvec3 p = chart.part_from_texel(glm::dvec2(chart.origin) + in_block);
    return frame.plane_from_part(p) / frame.extent * glm::dvec2(texture.width, texture.height);
  };
  const glm::dvec2 at_origin = texel({0, 0}), column = texel({1, 0}) - at_origin, row = texel({0, 1}) - at_origin;
  set(on_gpu.texel_columns, column.x, column.y, row.x, row.y);
  set(on_gpu.texel_offset, at_origin.x, at_origin.y);
}

void PictureData::bind() const {
  const GLuint buffers[] = {polygon_buffer_.id(), plane_buffer_.id(), edge_buffer_.id(), neighbour_buffer_.id()};
  glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, 0, 4, buffers);
}

}  // namespace foreview::per_polygon
