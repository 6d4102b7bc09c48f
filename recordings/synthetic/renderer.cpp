#include "foreview/recordings/synthetic/renderer.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <list>
#include <mutex>

#include "foreview/recordings/synthetic/baked_surface.h"
#include "foreview/recordings/synthetic/lighting.h"
#include "foreview/recordings/synthetic/visibility.h"

namespace foreview::synthetic {
namespace {

bool same_lens(const CameraModel& a, const CameraModel& b) {
  return a.width == b.width && a.height == b.height && a.focal_length == b.focal_length &&
         a.principal_point == b.principal_point && a.distortion_model == b.distortion_model &&
         a.distortion == b.distortion;
}

/// A face as this picture sees it: (u, v) = (dot(u_axis, ray), dot(v_axis, ray)) / dot(inverse_z, ray) + offset.
struct ShownFace {
  glm::vec3 u_axis{0}, v_axis{0}, inverse_z{0};
  glm::vec2 offset{0};
  const BakedSurface* surface = nullptr;
  const LightGrid* grid = nullptr;
  std::size_t first_light = 0;  ///< into the picture's lights
};

glm::vec3 light_at(const LightGrid& grid, const glm::vec3* lights, const glm::vec2& uv) {
  const glm::vec2 at = (uv - grid.low) * grid.cells_per_metre;
  const float x = std::clamp(at.x, 0.0F, static_cast<float>(grid.across - 1));
  const float y = std::clamp(at.y, 0.0F, static_cast<float>(grid.down - 1));
  const int x0 = std::min(static_cast<int>(x), grid.across - 2), y0 = std::min(static_cast<int>(y), grid.down - 2);
  const float tx = x - static_cast<float>(x0), ty = y - static_cast<float>(y0);
  const glm::vec3* const row = lights + y0 * grid.across + x0;
  const glm::vec3* const next = row + grid.across;
  return (row[0] * (1 - tx) + row[1] * tx) * (1 - ty) + (next[0] * (1 - tx) + next[1] * tx) * ty;
}

}  // namespace

struct Renderer::State {
  explicit State(const Site& s) : site(s), lighting(s), faces(s.mesh.faces.size()) {
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const FaceSurface& look = site.faces[f];
      faces[f].low = glm::dvec2(1e9);
      faces[f].high = glm::dvec2(-1e9);
      for (const std::uint32_t corner : site.mesh.faces[f]) {
        const glm::dvec3 d = site.mesh.vertices[corner] - look.origin;
        const glm::dvec2 uv{glm::dot(d, look.u_axis), glm::dot(d, look.v_axis)};
        faces[f].low = glm::min(faces[f].low, uv);
        faces[f].high = glm::max(faces[f].high, uv);
      }
    }
  }

  struct Face {
    glm::dvec2 low{0}, high{0};  // box of the corners in (u, v)
    std::once_flag once;
    BakedSurface surface;
    LightGrid grid;
  };

  const Face& prepared(std::size_t f) {
    Face& face = faces[f];
    std::call_once(face.once, [&] {
      const bool is_scenery = site.model_faces > 0 && f >= site.model_faces;
      face.surface.bake(site.surfaces[site.faces[f].surface], site.faces[f], face.low, face.high,
                        is_scenery ? 150 : 600);
      face.grid = lighting.make_grid(f, face.low, face.high, is_scenery ? 0.25 : 0.055);
    });
    return face;
  }

  const RayTable& rays_of(const CameraModel& camera) {
    const std::lock_guard lock(tables_mutex);
    for (const auto& [lens, table] : tables) {
      if (same_lens(lens, camera)) return table;
    }
    return tables.emplace_back(camera, RayTable(camera)).second;
  }

  Visibility look(const RayTable& rays, const Pose& world_from_camera, const std::vector<Pose>& world_from_part) const {
    const Pose camera_from_world = world_from_camera.inverse();
    std::vector<Pose> camera_from_part;
    camera_from_part.reserve(world_from_part.size());
    for (const Pose& pose : world_from_part) camera_from_part.push_back(camera_from_world * pose);
    Visibility visibility(rays);
    std::vector<glm::dvec3> corners;
    for (std::size_t f = 0; f < site.mesh.faces.size(); ++f) {
      const Pose& pose = camera_from_part[site.mesh.face_part[f]];
      corners.clear();
      for (const std::uint32_t corner : site.mesh.faces[f]) corners.push_back(pose * site.mesh.vertices[corner]);
      visibility.draw(rays, {static_cast<std::uint32_t>(f), corners});
    }
    return visibility;
  }

  std::vector<std::uint32_t> owners(const RayTable& rays, const Visibility& visibility) const {
    std::vector<char> seen(faces.size(), 0);
    for (std::size_t s = 0; s < kSamplesPerPixel; ++s) {
      for (int y = 0; y < rays.height; ++y) {
        const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(rays.stride);
        for (std::size_t x = 0; x < static_cast<std::size_t>(rays.width); ++x) {
          const std::int32_t owner = visibility.face[s][row + x];
          if (owner >= 0) seen[static_cast<std::size_t>(owner)] = 1;
        }
      }
    }
    std::vector<std::uint32_t> result;
    for (std::size_t f = 0; f < seen.size(); ++f) {
      if (seen[f] != 0) result.push_back(static_cast<std::uint32_t>(f));
    }
    return result;
  }

  const Site& site;
  Lighting lighting;
  std::vector<Face> faces;
  std::mutex tables_mutex;
  std::list<std::pair<CameraModel, RayTable>> tables;
};

Renderer::Renderer(const Site& site) : state_(std::make_unique<State>(site)) {}
Renderer::~Renderer() = default;

std::vector<std::uint32_t> Renderer::visible_faces(const CameraModel& camera, const Pose& world_from_camera,
                                                   double seconds) const {
  const RayTable& rays = state_->rays_of(camera);
  return state_->owners(rays, state_->look(rays, world_from_camera, state_->site.world_from_part(seconds)));
}

cv::Mat Renderer::render(const CameraModel& camera, const Pose& world_from_camera, double seconds) const {
  const Site& site = state_->site;
  const RayTable& rays = state_->rays_of(camera);
  const Lighting::Moment moment = state_->lighting.moment(seconds);
  const Visibility visibility = state_->look(rays, world_from_camera, moment.world_from_part);

  std::vector<ShownFace> shown(site.mesh.faces.size());
  std::vector<glm::vec3> lights, face_lights;
  const Pose camera_from_world = world_from_camera.inverse();
  for (const std::uint32_t f : state_->owners(rays, visibility)) {
    const State::Face& face = state_->prepared(f);
    const FaceSurface& look = site.faces[f];
    const Pose camera_from_part = camera_from_world * moment.world_from_part[site.mesh.face_part[f]];
    const glm::dvec3 origin = camera_from_part * look.origin;
    const glm::dvec3 u_axis = camera_from_part.rotate(look.u_axis), v_axis = camera_from_part.rotate(look.v_axis);
    const glm::dvec3 normal = camera_from_part.rotate(face.grid.normal);
    const glm::dvec3 corner = camera_from_part * site.mesh.vertices[site.mesh.faces[f][0]];
    ShownFace& s = shown[f];
    s.u_axis = glm::vec3(u_axis);
    s.v_axis = glm::vec3(v_axis);
    s.inverse_z = glm::vec3(normal / glm::dot(normal, corner));
    s.offset = glm::vec2(-glm::dot(u_axis, origin), -glm::dot(v_axis, origin));
    s.surface = &face.surface;
    s.grid = &face.grid;
    s.first_light = lights.size();
    face_lights.clear();
    state_->lighting.light_up(f, face.grid, moment, face_lights);
    lights.insert(lights.end(), face_lights.begin(), face_lights.end());
  }

  const auto shade = [&](const ShownFace& face, const glm::vec3& ray, const glm::vec3& across, const glm::vec3& down) {
    const float z = 1 / std::max(glm::dot(face.inverse_z, ray), 1e-6F);
    const glm::vec2 on_plane = glm::vec2(glm::dot(face.u_axis, ray), glm::dot(face.v_axis, ray)) * z;
    const auto change = [&](const glm::vec3& step) {
      return (glm::vec2(glm::dot(face.u_axis, step), glm::dot(face.v_axis, step)) -
              on_plane * glm::dot(face.inverse_z, step)) *
             z;
    };
    const glm::vec2 uv = on_plane + face.offset;
    return face.surface->colour(uv, change(across), change(down)) *
           light_at(*face.grid, lights.data() + face.first_light, uv);
  };

  cv::Mat picture(camera.height, camera.width, CV_8UC3);
  for (int y = 0; y < rays.height; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(rays.stride);
    for (int x = 0; x < rays.width; ++x) {
      const std::size_t at = row + static_cast<std::size_t>(x);
      // A sample's ray to the next one's two pixels on is a difference good enough for averaging.
      const std::size_t right = x + 1 < rays.width ? at + 1 : at, left = x > 0 ? at - 1 : at;
      const auto stride = static_cast<std::size_t>(rays.stride);
      const std::size_t below = y + 1 < rays.height ? at + stride : at, above = y > 0 ? at - stride : at;
      const float per_x = right - left == 2 ? 0.5F : 1.0F, per_y = below - above == 2 * stride ? 0.5F : 1.0F;
      const glm::vec3 across((rays.centre_x[right] - rays.centre_x[left]) * per_x,
                             (rays.centre_y[right] - rays.centre_y[left]) * per_x, 0);
      const glm::vec3 down((rays.centre_x[below] - rays.centre_x[above]) * per_y,
                           (rays.centre_y[below] - rays.centre_y[above]) * per_y, 0);
      glm::vec3 colour{0};
      std::array<std::int32_t, kSamplesPerPixel> owner;
      for (std::size_t s = 0; s < kSamplesPerPixel; ++s) owner[s] = visibility.face[s][at];
      if (owner[0] >= 0 && owner[0] == owner[1] && owner[0] == owner[2] && owner[0] == owner[3]) {
        colour =
            shade(shown[static_cast<std::size_t>(owner[0])], {rays.centre_x[at], rays.centre_y[at], 1}, across, down);
      } else {
        for (std::size_t s = 0; s < kSamplesPerPixel; ++s) {
          if (owner[s] < 0) continue;
          // All samples of one face are shaded at their centre, once.
          glm::vec3 ray{0};
          float count = 0;
          const std::int32_t id = owner[s];
          for (std::size_t k = s; k < kSamplesPerPixel; ++k) {
            if (owner[k] != id) continue;
            ray += glm::vec3(rays.x[k][at], rays.y[k][at], 1);
            count += 1;
            owner[k] = -1;
          }
          colour += shade(shown[static_cast<std::size_t>(id)], ray / count, across, down) * (count / kSamplesPerPixel);
        }
      }
      const glm::vec3 value = glm::clamp(colour, 0.0F, 1.0F) * 255.0F + 0.5F;
      picture.at<cv::Vec3b>(y, x) = {static_cast<std::uint8_t>(value.b), static_cast<std::uint8_t>(value.g),
                                     static_cast<std::uint8_t>(value.r)};
    }
  }
  return picture;
}

}  // namespace foreview::synthetic
