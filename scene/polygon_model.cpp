#include "foreview/scene/polygon_model.h"

#include <bit>
#include <cassert>
#include <glm/geometric.hpp>

#include "foreview/scene/polygon_geometry.h"

namespace foreview {
namespace {

/// FNV-1a over 64-bit words, byte by byte from the lowest: the same on every machine.
class Fingerprint {
 public:
  void add(std::uint64_t word) {
    for (int i = 0; i < 8; ++i, word >>= 8) value_ = (value_ ^ (word & 0xff)) * 0x100000001b3ULL;
  }
  void add(double number) { add(std::bit_cast<std::uint64_t>(number + 0.0)); }  // -0 becomes 0
  void add(const std::string& text) {
    add(static_cast<std::uint64_t>(text.size()));
    for (const char c : text) value_ = (value_ ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

}  // namespace

std::span<const std::uint32_t> PolygonModel::corners_of(std::size_t polygon) const {
  assert(polygon < polygons_.size());
  return std::span(corners_).subspan(polygons_[polygon].first_corner, polygons_[polygon].corner_count);
}

const glm::dvec3& PolygonModel::corner(std::size_t polygon, std::size_t i) const {
  return vertices_[corners_of(polygon)[i]];
}

std::span<const std::uint32_t> PolygonModel::neighbours_of(std::size_t polygon) const {
  assert(polygon + 1 < first_neighbour_.size());
  return std::span(neighbours_)
      .subspan(first_neighbour_[polygon], first_neighbour_[polygon + 1] - first_neighbour_[polygon]);
}

int PolygonModel::part_index(const std::string& name) const {
  for (std::size_t i = 0; i < parts_.size(); ++i)
    if (parts_[i].name == name) return static_cast<int>(i);
  return -1;
}

std::uint64_t PolygonModel::fingerprint() const {
  Fingerprint result;
  result.add(static_cast<std::uint64_t>(parts_.size()));
  for (const Part& part : parts_) result.add(part.name);
  result.add(static_cast<std::uint64_t>(vertices_.size()));
  for (const glm::dvec3& vertex : vertices_)
    for (int axis = 0; axis < 3; ++axis) result.add(vertex[axis]);
  result.add(static_cast<std::uint64_t>(polygons_.size()));
  for (const Polygon& polygon : polygons_) {
    result.add(std::uint64_t{polygon.part} * 2 + (polygon.is_backdrop ? 1 : 0));
    result.add(polygon.texels_per_metre);
    result.add(std::uint64_t{polygon.corner_count});
  }
  for (const std::uint32_t corner : corners_) result.add(std::uint64_t{corner});
  return result.value();
}

glm::dvec2 PolygonFrame::plane_from_part(const glm::dvec3& p) const {
  const glm::dvec3 d = p - origin;
  return {glm::dot(x_axis, d), glm::dot(y_axis, d)};
}

glm::dvec3 PolygonFrame::part_from_plane(const glm::dvec2& q) const {
  return origin + q.x * x_axis + q.y * y_axis;
}

std::vector<glm::dvec3> centres_of_parts(const PolygonModel& model) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<glm::dvec3> lower(model.parts().size(), glm::dvec3(kInfinity));
  std::vector<glm::dvec3> upper(model.parts().size(), glm::dvec3(-kInfinity));
  for (std::size_t p = 0; p < model.polygons().size(); ++p) {
    const std::uint32_t part = model.polygons()[p].part;
    for (const std::uint32_t v : model.corners_of(p)) {
      lower[part] = glm::min(lower[part], model.vertices()[v]);
      upper[part] = glm::max(upper[part], model.vertices()[v]);
    }
  }
  std::vector<glm::dvec3> centres(model.parts().size(), glm::dvec3(0));
  for (std::size_t i = 0; i < centres.size(); ++i) {
    if (lower[i].x <= upper[i].x) centres[i] = 0.5 * (lower[i] + upper[i]);
  }
  return centres;
}

PolygonFrame polygon_frame(const PolygonModel& model, std::size_t polygon) {
  const Polygon& p = model.polygons()[polygon];
  std::vector<glm::dvec3> points;
  for (const std::uint32_t corner : model.corners_of(polygon)) points.push_back(model.vertices()[corner]);
  std::vector<glm::dvec2> outline;
  project(points, p.normal, outline);
  const EdgeBox box = smallest_box(outline);

  const glm::dvec3 along = points[(box.edge + 1) % points.size()] - points[box.edge];
  PolygonFrame frame;
  frame.y_axis = glm::normalize(along - glm::dot(along, p.normal) * p.normal);
  frame.x_axis = glm::cross(frame.y_axis, p.normal);
  frame.extent = box.extent;
  // The box is measured from the first corner; the origin is its lower corner, on the plane.
  const glm::dvec3 base = points[0] + (p.offset - glm::dot(p.normal, points[0])) * p.normal;
  frame.origin = base + box.lowest.x * frame.x_axis + box.lowest.y * frame.y_axis;
  return frame;
}

}  // namespace foreview
