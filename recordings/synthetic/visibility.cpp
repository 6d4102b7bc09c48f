#include "foreview/recordings/synthetic/visibility.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>

namespace foreview::synthetic {
namespace {

// A rotated grid: near-vertical and near-horizontal edges see four different positions.
constexpr std::array<glm::dvec2, kSamplesPerPixel> kOffsets{
    {{0.375, 0.125}, {0.875, 0.375}, {0.125, 0.625}, {0.625, 0.875}}};

struct Plane {
  float x, y, c;
  [[nodiscard]] float at(float px, float py) const { return x * px + y * py + c; }
  [[nodiscard]] float most(const RayTable::Bounds& b) const {
    return (x > 0 ? x * b.high_x : x * b.low_x) + (y > 0 ? y * b.high_y : y * b.low_y) + c;
  }
  [[nodiscard]] float least(const RayTable::Bounds& b) const {
    return (x > 0 ? x * b.low_x : x * b.high_x) + (y > 0 ? y * b.low_y : y * b.high_y) + c;
  }
};

std::size_t at(int row, int across, int column) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(across) + static_cast<std::size_t>(column);
}

std::vector<RayTable::Bounds> bounds_of(const RayTable& rays, int block, int& across) {
  across = (rays.stride + block - 1) / block;
  const int down = (rays.height + block - 1) / block;
  std::vector<RayTable::Bounds> result;
  for (int by = 0; by < down; ++by) {
    for (int bx = 0; bx < across; ++bx) {
      constexpr float kFar = std::numeric_limits<float>::max();
      RayTable::Bounds b{kFar, -kFar, kFar, -kFar};
      for (int y = by * block; y < std::min(rays.height, (by + 1) * block); ++y) {
        for (int x = bx * block; x < std::min(rays.stride, (bx + 1) * block); ++x) {
          const std::size_t at =
              static_cast<std::size_t>(y) * static_cast<std::size_t>(rays.stride) + static_cast<std::size_t>(x);
          for (std::size_t s = 0; s < kSamplesPerPixel; ++s) {
            b.low_x = std::min(b.low_x, rays.x[s][at]);
            b.high_x = std::max(b.high_x, rays.x[s][at]);
            b.low_y = std::min(b.low_y, rays.y[s][at]);
            b.high_y = std::max(b.high_y, rays.y[s][at]);
          }
        }
      }
      result.push_back(b);
    }
  }
  return result;
}

}  // namespace

RayTable::RayTable(const CameraModel& camera)
    : width(camera.width), height(camera.height), stride((camera.width + kBlock - 1) / kBlock * kBlock) {
  const std::size_t size = static_cast<std::size_t>(stride) * static_cast<std::size_t>(height);
  for (std::size_t s = 0; s <= kSamplesPerPixel; ++s) {
    std::vector<float>& xs = s < kSamplesPerPixel ? x[s] : centre_x;
    std::vector<float>& ys = s < kSamplesPerPixel ? y[s] : centre_y;
    const glm::dvec2 offset = s < kSamplesPerPixel ? kOffsets[s] : glm::dvec2(0.5, 0.5);
    xs.reserve(size);
    ys.reserve(size);
    for (int row = 0; row < height; ++row) {
      for (int column = 0; column < stride; ++column) {
        const glm::dvec3 ray = camera.ray_from_pixel(glm::dvec2(column, row) + offset);
        xs.push_back(static_cast<float>(ray.x));
        ys.push_back(static_cast<float>(ray.y));
      }
    }
  }
  blocks = bounds_of(*this, kBlock, blocks_across);
  super_blocks = bounds_of(*this, kSuperBlock, super_across);
}

Visibility::Visibility(const RayTable& rays) {
  for (std::size_t s = 0; s < kSamplesPerPixel; ++s) {
    inverse_z[s].assign(rays.x[s].size(), 0.0F);
    face[s].assign(rays.x[s].size(), -1);
  }
}

void Visibility::draw(const RayTable& rays, const ViewFace& view) {
  constexpr std::size_t kMaxEdges = 32;
  std::array<Plane, kMaxEdges> edges;
  const std::size_t count = view.corners.size();
  if (count < 3 || count > kMaxEdges) return;
  const glm::dvec3 normal =
      glm::normalize(glm::cross(view.corners[1] - view.corners[0], view.corners[2] - view.corners[0]));
  const double offset = glm::dot(normal, view.corners[0]);
  if (offset > -1e-9) return;
  const auto plane = [](const glm::dvec3& p) {
    return Plane{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  };
  for (std::size_t i = 0; i < count; ++i) {
    edges[i] = plane(glm::cross(view.corners[(i + 1) % count], view.corners[i]));
  }
  const Plane depth = plane(normal / offset);

  const auto draw_block = [&](int bx, int by) {
    const RayTable::Bounds& bounds = rays.blocks[at(by, rays.blocks_across, bx)];
    std::array<Plane, kMaxEdges> cutting;
    std::size_t cuts = 0;
    if (depth.most(bounds) <= 0) return;
    for (std::size_t i = 0; i < count; ++i) {
      if (edges[i].most(bounds) < 0) return;
      if (edges[i].least(bounds) < 0) cutting[cuts++] = edges[i];
    }
    for (int row = by * kBlock; row < std::min(rays.height, (by + 1) * kBlock); ++row) {
      const std::size_t start =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(rays.stride) + static_cast<std::size_t>(bx) * kBlock;
      for (std::size_t s = 0; s < kSamplesPerPixel; ++s) {
        const float* const xs = &rays.x[s][start];
        const float* const ys = &rays.y[s][start];
        float* const nearest = &inverse_z[s][start];
        std::int32_t* const owner = &face[s][start];
        std::array<float, kBlock> inside;
        for (std::size_t i = 0; i < kBlock; ++i) inside[i] = 1.0F;
        for (std::size_t e = 0; e < cuts; ++e) {
          const Plane edge = cutting[e];
          for (std::size_t i = 0; i < kBlock; ++i) inside[i] = edge.at(xs[i], ys[i]) < 0 ? 0.0F : inside[i];
        }
        for (std::size_t i = 0; i < kBlock; ++i) {
          const float w = depth.at(xs[i], ys[i]) * inside[i];
          const bool closer = w > nearest[i];
          nearest[i] = closer ? w : nearest[i];
          owner[i] = closer ? static_cast<std::int32_t>(view.id) : owner[i];
        }
      }
    }
  };

  constexpr int kPerSuper = kSuperBlock / kBlock;
  const int blocks_down = (rays.height + kBlock - 1) / kBlock;
  for (int sy = 0; sy * kSuperBlock < rays.height; ++sy) {
    for (int sx = 0; sx < rays.super_across; ++sx) {
      const RayTable::Bounds& bounds = rays.super_blocks[at(sy, rays.super_across, sx)];
      const bool missed = std::any_of(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(count),
                                      [&](const Plane& edge) { return edge.most(bounds) < 0; });
      if (missed) continue;
      for (int by = sy * kPerSuper; by < std::min(blocks_down, (sy + 1) * kPerSuper); ++by) {
        for (int bx = sx * kPerSuper; bx < std::min(rays.blocks_across, (sx + 1) * kPerSuper); ++bx) {
          draw_block(bx, by);
        }
      }
    }
  }
}

}  // namespace foreview::synthetic
