// The first byte chooses: a file of one of our own readers' formats, or a RawMesh made of the bytes. Either way the
// outcome is a model that keeps its promises, or an InputError.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <glm/geometric.hpp>
#include <string_view>

#include "foreview/scene/chart_layout.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/mesh_reading.h"
#include "foreview/scene/polygon_model.h"

namespace {

using namespace foreview;

void require(bool promise) {
  if (!promise) std::abort();
}

class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  std::uint8_t next() {
    if (size_ == 0) return 0;
    --size_;
    return *data_++;
  }
  [[nodiscard]] std::size_t left() const { return size_; }
  /// Mostly small lattice coordinates, so that points coincide and line up; sometimes any double.
  double coordinate() {
    const std::uint8_t kind = next();
    if (kind < 250) return (kind % 16) * 0.05 + (kind / 16) * 1e-4;
    std::uint64_t bits = 0;
    for (int i = 0; i < 8; ++i) bits = bits << 8 | next();
    double value = 0;
    std::memcpy(&value, &bits, sizeof(value));
    return value;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

RawMesh raw_mesh(Bytes& bytes) {
  RawMesh mesh;
  const std::size_t vertices = bytes.next() % 64;
  for (std::size_t i = 0; i < vertices; ++i) {
    const double x = bytes.coordinate();
    const double y = bytes.coordinate();
    mesh.vertices.emplace_back(x, y, bytes.next() % 4 == 0 ? bytes.coordinate() : 0);
  }
  const bool parts = bytes.next() % 2 == 0;
  if (parts) mesh.part_names = {"a", "b"};
  while (bytes.left() > 0 && mesh.faces.size() < 200) {
    std::vector<std::uint32_t>& face = mesh.faces.emplace_back();
    const std::size_t corners = bytes.next() % 24;
    for (std::size_t i = 0; i < corners; ++i) face.push_back(bytes.next() % 66U);
    if (parts) mesh.face_part.push_back(bytes.next() % 8 == 0 ? bytes.next() : bytes.next() % 2);
  }
  return mesh;
}

void check(const PolygonModel& model) {
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    const Polygon& polygon = model.polygons()[i];
    require(polygon.corner_count >= 3 && polygon.part < model.parts().size());
    require(std::abs(glm::dot(polygon.normal, polygon.normal) - 1) < 1e-9);
    for (const std::uint32_t corner : model.corners_of(i)) require(corner < model.vertices().size());
    for (const std::uint32_t n : model.neighbours_of(i)) require(n < model.polygons().size() && n != i);
    const PolygonFrame frame = polygon_frame(model, i);
    require(frame.extent.x > 0 && frame.extent.y > 0 && std::isfinite(frame.extent.x * frame.extent.y));
  }
  (void)model.fingerprint();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  const std::uint8_t choice = bytes.next();
  const std::string_view text(reinterpret_cast<const char*>(data) + (size > 0 ? 1 : 0), bytes.left());
  try {
    ImportOptions options;
    options.backdrop = (choice & 64) != 0;
    options.merge_coplanar = (choice & 32) == 0;
    options.weld_distance = (choice & 16) != 0 ? 1e-3 : 0;
    constexpr const char* kNames[] = {"x.obj", "x.off", "x.ply", "x.stl"};
    const RawMesh mesh = choice % 8 < 4 ? parse_mesh(kNames[choice % 8], text) : raw_mesh(bytes);
    const PolygonModel model = build_polygon_model(mesh, options);
    check(model);
    ChartOptions charts;
    charts.texels_per_metre = 50;
    charts.memory_budget = std::size_t{256} << 20;
    (void)lay_out_charts(model, charts);
  } catch (const foreview::InputError&) {
  }
  return 0;
}
