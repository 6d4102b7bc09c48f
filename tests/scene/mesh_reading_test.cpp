#include "foreview/scene/mesh_reading.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <glm/geometric.hpp>

#include "foreview/scene/errors.h"
#include "support/temporary_directory.h"

namespace foreview {
namespace {

template <typename T>
void append(std::string& bytes, T value, bool big_endian = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(std::begin(raw), std::end(raw));
  bytes.append(raw, sizeof(T));
}

/// A tetrahedron as binary PLY with extra properties to step over.
std::string binary_ply(bool big_endian = false) {
  std::string bytes = "ply\nformat " + std::string(big_endian ? "binary_big_endian" : "binary_little_endian") +
                      " 1.0\ncomment by hand\nelement vertex 4\nproperty double x\nproperty double y\n"
                      "property double z\nproperty uchar red\nelement face 4\nproperty list uchar int vertex_indices\n"
                      "property list uchar float texcoord\nend_header\n";
  const double corners[4][3] = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}};
  for (const auto& corner : corners) {
    for (const double x : corner) append(bytes, x, big_endian);
    append(bytes, std::uint8_t{7});
  }
  const std::int32_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  for (const auto& face : faces) {
    append(bytes, std::uint8_t{3});
    for (const std::int32_t i : face) append(bytes, i, big_endian);
    append(bytes, std::uint8_t{1});
    append(bytes, 0.5F, big_endian);
  }
  return bytes;
}

std::string binary_stl() {
  std::string bytes(80, ' ');
  bytes.replace(0, 5, "solid");  // many exporters do that even in binary files
  append(bytes, std::uint32_t{4});
  const float corners[4][3] = {{0, 0, 0}, {0.1F, 0, 0}, {0, 0.1F, 0}, {0, 0, 0.1F}};
  const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  for (const auto& face : faces) {
    for (int i = 0; i < 3; ++i) append(bytes, 0.0F);
    for (const int corner : face)
      for (const float x : corners[corner]) append(bytes, x);
    append(bytes, std::uint16_t{0});
  }
  return bytes;
}

/// A glTF of one triangle under two nodes: one moved, one mirrored.
std::string glb() {
  std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],)"
      R"("nodes":[{"name":"moved","mesh":0,"translation":[1,2,3]},{"name":"mirrored","mesh":0,"scale":[-1,1,1]}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)"
      R"({"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}],)"
      R"("bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],)"
      R"("buffers":[{"byteLength":44}]})";
  while (json.size() % 4 != 0) json += ' ';
  std::string data;
  for (const float x : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F}) append(data, x);
  for (const std::uint16_t i : {std::uint16_t{0}, std::uint16_t{1}, std::uint16_t{2}, std::uint16_t{0}})
    append(data, i);
  std::string bytes = "glTF";
  append(bytes, std::uint32_t{2});
  append(bytes, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + data.size()));
  append(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  append(bytes, static_cast<std::uint32_t>(data.size()));
  bytes += std::string("BIN\0", 4) + data;
  return bytes;
}

const char* const kObj =
    "# a comment\nmtllib none.mtl\no base\nv 0 0 0\nv 1 0 0 # inline\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n"
    "usemtl wood\ng left\nf 1/1/1 2/1/1 3/1/1 4//1\r\no lid with blanks \nv 0 0 +1e0\nv 1 0 1\nv 1 1 1\n"
    "f -3 -2 \\\n-1\no base\nf 1 3 4\n";

const char* const kOff = "OFF\n# a comment\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n3 0 1 2\n";

const char* const kTextStl =
    "solid a thing\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 1 0\n"
    "  endloop\n endfacet\nendsolid a thing\n";

const char* const kDae =
    R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">)"
    R"(<asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset><library_geometries>)"
    R"(<geometry id="g" name="g"><mesh><source id="p"><float_array id="pa" count="12">)"
    R"(0 0 0 100 0 0 100 100 0 0 100 0</float_array><technique_common><accessor source="#pa" count="4" stride="3">)"
    R"(<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>)"
    R"(</technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>)"
    R"(<polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4</vcount><p>0 1 2 3</p>)"
    R"(</polylist></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s">)"
    R"(<node id="plate" name="plate"><translate>0 0 50</translate><instance_geometry url="#g"/></node>)"
    R"(</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";

TEST(ReadMesh, ObjKeepsPolygonsAndObjects) {
  const RawMesh mesh = parse_obj(kObj, "x.obj");
  EXPECT_EQ(mesh.vertices.size(), 7U);
  ASSERT_EQ(mesh.faces.size(), 3U);
  EXPECT_EQ(mesh.faces[0], (std::vector<std::uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(mesh.faces[1], (std::vector<std::uint32_t>{4, 5, 6})) << "counted from the end, over a continued line";
  EXPECT_EQ(mesh.part_names, (std::vector<std::string>{"base", "lid with blanks"})) << "objects, not groups";
  EXPECT_EQ(mesh.face_part, (std::vector<std::uint32_t>{0, 1, 0})) << "the same name is the same part";
  const RawMesh groups = parse_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\ng a\nf 1 2 3\ng b\nf 3 2 1\n", "x.obj");
  EXPECT_EQ(groups.part_names, (std::vector<std::string>{"a", "b"}));
}

TEST(ReadMesh, OffInItsSpellings) {
  const RawMesh mesh = parse_off(kOff, "x.off");
  EXPECT_EQ(mesh.vertices.size(), 4U);
  ASSERT_EQ(mesh.faces.size(), 2U);
  EXPECT_EQ(mesh.faces[0], (std::vector<std::uint32_t>{0, 1, 2, 3})) << "colours behind it are no corners";
  EXPECT_EQ(parse_off("COFF 3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 0 0 0\n0 1 0 0 0 0 0\n3 0 1 2\n", "x").faces.size(), 1U);
}

TEST(ReadMesh, PlyInItsEncodings) {
  for (const bool big_endian : {false, true}) {
    const RawMesh mesh = parse_ply(binary_ply(big_endian), "x.ply");
    ASSERT_EQ(mesh.vertices.size(), 4U);
    EXPECT_EQ(mesh.vertices[1], glm::dvec3(0.1, 0, 0)) << "doubles stay doubles";
    ASSERT_EQ(mesh.faces.size(), 4U);
    EXPECT_EQ(mesh.faces[3], (std::vector<std::uint32_t>{0, 3, 2}));
  }
  const RawMesh text = parse_ply(
      "ply\r\nformat ascii 1.0\r\nelement vertex 4\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\n"
      "element face 1\r\nproperty list uchar uint vertex_index\r\nend_header\r\n0 0 0\r\n1 0 0\r\n1 1 0\r\n0 1 0\r\n"
      "4 0 1 2 3\r\n",
      "x.ply");
  ASSERT_EQ(text.faces.size(), 1U);
  EXPECT_EQ(text.faces[0].size(), 4U);
}

TEST(ReadMesh, KitchenPlyWithDoubles) {
  const std::filesystem::path file = std::filesystem::path(FOREVIEW_SHARED_DIR) / "recordings/kitchen/scene_5k.ply";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "shared data is not here: " << file;
  const RawMesh mesh = read_mesh(file);
  EXPECT_EQ(mesh.vertices.size(), 3412U);
  EXPECT_EQ(mesh.faces.size(), 4891U);
  for (const glm::dvec3& vertex : mesh.vertices) ASSERT_LT(glm::length(vertex), 20);
}

TEST(ReadMesh, StlBinaryAndText) {
  ImportReport report;
  ImportOptions options;
  options.backdrop = false;
  const PolygonModel model = build_polygon_model(parse_stl(binary_stl(), "x.stl"), options, &report);
  EXPECT_EQ(model.polygons().size(), 4U);
  EXPECT_EQ(model.vertices().size(), 4U) << "welded";
  EXPECT_EQ(model.neighbours_of(0).size(), 3U);
  EXPECT_EQ(report.vertices_welded, 8U);
  const RawMesh text = parse_stl(kTextStl, "x.stl");
  EXPECT_EQ(text.faces.size(), 1U);
  EXPECT_EQ(text.part_names, std::vector<std::string>{"a thing"});
}

TEST(ReadMesh, GltfNodesBecomePartsWithTheirTransformsBaked) {
  const test::TemporaryDirectory directory;
  const RawMesh mesh = read_mesh(directory.write("x.glb", glb()));
  ASSERT_EQ(mesh.faces.size(), 2U);
  EXPECT_EQ(mesh.part_names, (std::vector<std::string>{"moved", "mirrored"}));
  EXPECT_EQ(mesh.vertices[mesh.faces[0][0]], glm::dvec3(1, 2, 3));
  ImportOptions options;
  options.backdrop = false;
  const PolygonModel model = build_polygon_model(mesh, options);
  EXPECT_EQ(model.polygons()[0].normal, glm::dvec3(0, 0, 1));
  EXPECT_EQ(model.polygons()[1].normal, glm::dvec3(0, 0, 1)) << "a mirrored front stays a front";
}

TEST(ReadMesh, DaeComesInMetresAndItsOwnAxes) {
  const test::TemporaryDirectory directory;
  const RawMesh mesh = read_mesh(directory.write("x.dae", kDae));
  ASSERT_EQ(mesh.faces.size(), 1U);
  EXPECT_EQ(mesh.faces[0].size(), 4U);
  EXPECT_EQ(mesh.part_names, std::vector<std::string>{"plate"});
  EXPECT_NEAR(glm::distance(mesh.vertices[mesh.faces[0][2]], glm::dvec3(1, 1, 0.5)), 0, 1e-6);
}

TEST(WriteObj, ReadsBackTheSameMesh) {
  RawMesh mesh;
  for (int i = 0; i < 40; ++i)
    mesh.vertices.emplace_back(std::sin(i) / 3, std::exp(i / 3.0), std::nextafter(1.0 / (1 + i), 2.0));
  mesh.part_names = {"base", "never used", "link 1", "tail"};
  mesh.faces = {{0, 1, 2, 3}, {4, 5, 6}, {7, 8, 9, 10, 11}, {1, 2, 3}};
  mesh.face_part = {2, 0, 2, 0};
  const test::TemporaryDirectory directory;
  write_obj(mesh, directory / "x.obj");
  const RawMesh back = read_mesh(directory / "x.obj");
  EXPECT_EQ(back.vertices, mesh.vertices);
  EXPECT_EQ(back.faces, mesh.faces);
  EXPECT_EQ(back.face_part, mesh.face_part);
  EXPECT_EQ(back.part_names, mesh.part_names);
  EXPECT_THROW(write_obj(mesh, directory / "no" / "such" / "x.obj"), InputError);
}

/// An InputError with the file's name first, in one line: nothing else, whatever the bytes.
void expect_input_error_or_mesh(const std::filesystem::path& file) {
  try {
    (void)import_model(file, {});
  } catch (const InputError& error) {
    const std::string what = error.what();
    EXPECT_EQ(what.rfind(file.string(), 0), 0U) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
  }
}

TEST(ReadMesh, RefusesEmptyMissingAndGarbageOfEveryFormat) {
  const test::TemporaryDirectory directory;
  std::string garbage;
  std::uint32_t state = 7;
  for (int i = 0; i < 3000; ++i) {
    state = state * 1664525U + 1013904223U;
    garbage += static_cast<char>(state >> 24);
  }
  for (const char* extension : {".obj", ".ply", ".stl", ".off", ".gltf", ".glb", ".dae", ".xyz", ""}) {
    const std::string name = std::string("file") + extension;
    EXPECT_THROW((void)read_mesh(directory / ("missing" + name)), InputError);
    EXPECT_THROW((void)read_mesh(directory.write(name, "")), InputError);
    EXPECT_THROW((void)read_mesh(directory.write(name, garbage)), InputError) << extension;
    EXPECT_THROW((void)read_mesh(directory.write(name, std::string(100, '\0'))), InputError) << extension;
    EXPECT_THROW((void)read_mesh(directory.write(name, "solid\nply\nOFF\n")), InputError) << extension;
    expect_input_error_or_mesh(directory / name);
  }
  EXPECT_THROW((void)read_mesh(directory.path()), InputError);
}

TEST(ReadMesh, RefusesEveryCutOffBinaryFile) {
  for (const std::string& whole : {binary_ply(), binary_ply(true)})
    for (std::size_t size = 0; size < whole.size(); ++size)
      EXPECT_THROW((void)parse_mesh("x.ply", whole.substr(0, size)), InputError) << size;
  const std::string stl = binary_stl();
  for (std::size_t size = 0; size < stl.size(); ++size)
    EXPECT_THROW((void)parse_mesh("x.stl", stl.substr(0, size)), InputError) << size;
  const test::TemporaryDirectory directory;
  const std::string whole = glb();
  for (std::size_t size = 1; size + 1 < whole.size(); size += 61)
    EXPECT_THROW((void)read_mesh(directory.write("x.glb", whole.substr(0, size))), InputError) << size;
}

TEST(ReadMesh, DoesNotBelieveAnnouncedCounts) {
  EXPECT_THROW((void)parse_off("OFF\n4000000000 4000000000 0\n", "x"), InputError);
  EXPECT_THROW((void)parse_off("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4294967295 0 1 2\n", "x"), InputError);
  std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 7999999\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uint uint vertex_indices\nend_header\n";
  EXPECT_THROW((void)parse_ply(ply, "x"), InputError);
  EXPECT_THROW((void)parse_ply("ply\nformat ascii 1.0\nelement nothing 99999999999999\nend_header\n", "x"), InputError);
  std::string stl(80, ' ');
  append(stl, ~std::uint32_t{0});
  EXPECT_THROW((void)parse_stl(stl, "x"), InputError);
}

TEST(ReadMesh, NamesTheLineThatIsWrong) {
  const auto message = [](const char* text) {
    try {
      (void)parse_obj(text, "scene.obj");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_EQ(message("v 0 0 0\nv 1 zero 0\n"), "scene.obj:2: 'zero' stands where a vertex's coordinate was expected");
  EXPECT_EQ(message("v 0 0\n"), "scene.obj:1: ends where a vertex's coordinate was expected");
  EXPECT_EQ(message("v 0 0 0\nf 1 0 2\n").rfind("scene.obj:2: a face has the corner '0'", 0), 0U);
}

TEST(ReadMesh, ACrashingImporterIsAnInputError) {
  // Nodes that are their own children, a mesh of an accessor beyond its buffer: what breaks importers.
  const test::TemporaryDirectory directory;
  std::string cycle = glb();
  const std::string before = R"("name":"moved","mesh":0,"translation":[1,2,3])";
  const std::string after = R"("name":"moved","mesh":0,"children":[0]       )";
  cycle.replace(cycle.find(before), before.size(), after.substr(0, before.size()));
  expect_input_error_or_mesh(directory.write("cycle.glb", cycle));
  for (const char* damage :
       {"\"count\":3", "\"bufferView\":1", "\"byteOffset\":36", "\"byteLength\":44", "\"mesh\":0"}) {
    std::string bytes = glb();
    const std::size_t at = bytes.find(damage) + std::strlen(damage) - 1;
    bytes[at] = '9';
    expect_input_error_or_mesh(directory.write("damaged.glb", bytes));
  }
}

}  // namespace
}  // namespace foreview
