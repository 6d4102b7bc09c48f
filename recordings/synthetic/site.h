#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "foreview/scene/camera_model.h"
#include "foreview/scene/polygon_model.h"
#include "foreview/scene/pose.h"

namespace foreview::synthetic {

/// What a surface looks like; evaluated by surface_colour().
enum class Material {
  paint,       ///< plain colour, a little mottled, scuffed
  wood,        ///< grain along u
  brick,       ///< courses of bricks, mortar in the second colour
  floor,       ///< checkered stone tiles with speckle and joints
  ceiling,     ///< perforated panels
  metal,       ///< brushed along u, with a screw in every corner
  carton,      ///< corrugated board with tape, print and a handling mark
  label,       ///< plain body with a printed label: lettering and a bar code
  hazard,      ///< diagonal stripes
  poster,      ///< large shapes, a title and lines of text
  spine,       ///< a book's or binder's back: title along v
  marker,      ///< black and white squares, as for calibration
  breadboard,  ///< dark plate with a grid of holes
  screen,      ///< a monitor's picture: curves, bars and text
  cloth,       ///< woven check of two colours
  lamp,        ///< gives light itself
};

struct Surface {
  Material material = Material::paint;
  glm::vec3 colour{0.7F};  ///< display values 0..1, RGB
  glm::vec3 second_colour{0.2F};
  std::uint32_t seed = 0;
  std::string text;
};

/// How one face of the mesh wears its surface: u = dot(p - origin, u_axis), v = dot(p - origin, v_axis), metres, in
/// the part's frame; u runs to the right and v upwards for someone who looks at the front.
struct FaceSurface {
  std::uint32_t surface = 0;
  glm::dvec3 origin{0}, u_axis{1, 0, 0}, v_axis{0, 1, 0};
  glm::dvec2 size{1, 1};  ///< metres, of the whole side that the face belongs to (tiles of a wall share it)
  int free_object = -1;   ///< faces with the same number >= 0 are one free-standing or movable thing
};

/// A rectangular lamp.
struct AreaLight {
  glm::dvec3 centre{0}, half_u{0}, half_v{0};  ///< world, metres
  glm::dvec3 direction{0, 0, -1};              ///< unit, the way it shines
  glm::vec3 colour{1};                         ///< linear
  double intensity = 1;                        ///< linear irradiance at 1 m, facing it
  std::function<double(double)> over_time;     ///< factor at t seconds
};

/// A stand-in for a moving part, for its soft shadow.
struct Capsule {
  std::uint32_t part = 0;
  glm::dvec3 a{0}, b{0};  ///< part frame
  double radius = 0.05;   ///< metres
};

/// All that a synthetic site is: shape, looks, lights, and how everything moves. World: z up, metres; time: seconds
/// since the first instant.
struct Site {
  std::string name;
  RawMesh mesh;
  std::vector<Surface> surfaces;
  std::vector<FaceSurface> faces;  ///< one per face of the mesh
  std::vector<AreaLight> lights;   ///< at most kMaxLights
  glm::vec3 ambient{0.4F};         ///< linear
  std::function<double(double)> ambient_over_time;
  std::vector<Capsule> moving_occluders;
  std::vector<CameraModel> cameras;
  std::size_t instants = 0;
  std::int64_t period_nanoseconds = 40'000'000;
  std::vector<char> part_moves;  ///< one per part
  std::function<Pose(std::size_t camera, double t)> world_from_camera;
  std::function<std::vector<Pose>(double t)> world_from_part;
  std::vector<std::string> joint_names;
  std::function<std::vector<double>(double t)> joints;
  bool closed_room = true;  ///< the model hides everything behind it: it needs no backdrop
  /// Faces and vertices from these on are scenery: in the pictures, but not in the model (what the backdrop is for).
  std::size_t model_faces = 0, model_vertices = 0;
};

inline constexpr std::size_t kMaxLights = 3;

/// The built-in sites; each is a pure function of nothing.
[[nodiscard]] Site make_workcell_site();
[[nodiscard]] Site make_object_site();
[[nodiscard]] Site make_cube_site();

}  // namespace foreview::synthetic
