#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <glm/geometric.hpp>
#include <limits>

#include "foreview/scene/polygon_face.h"

namespace foreview {

void gather_corners(std::span<const glm::dvec3> vertices, std::span<const std::uint32_t> corners,
                    std::vector<glm::dvec3>& points) {
  points.clear();
  for (const std::uint32_t corner : corners) points.push_back(vertices[corner]);
}

namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// Ear clipping (corner numbers of the outline, counter-clockwise). Every corner is looked at again only when one of
/// its neighbours is cut off, which bounds the work by the square of the corners. Returns false where the outline
/// crosses itself: then what cannot be cut off properly is cut off anyway.
class EarClipper {
 public:
  explicit EarClipper(std::span<const glm::dvec2> outline) : points_(outline) {
    const auto count = static_cast<std::uint32_t>(outline.size());
    next_.resize(count);
    previous_.resize(count);
    alive_.assign(count, true);
    queued_.assign(count, true);
    for (std::uint32_t i = 0; i < count; ++i) {
      next_[i] = (i + 1) % count;
      previous_[i] = (i + count - 1) % count;
      queue_.push_back(i);
      if (turn(i) <= 0) reflex_.push_back(i);
    }
    remaining_ = count;
  }

  bool run(std::vector<Triangle>& triangles) {
    bool clean = true;
    while (remaining_ > 3) {
      if (queue_.empty()) {
        // No proper ear is left. Cut off whatever takes the least area the wrong way, and say so.
        clean = false;
        clip(sharpest(), triangles);
        continue;
      }
      const std::uint32_t i = queue_.front();
      queue_.pop_front();
      queued_[i] = false;
      if (alive_[i] && is_ear(i)) clip(i, triangles);
    }
    for (std::uint32_t i = 0; i < alive_.size(); ++i) {
      if (!alive_[i]) continue;
      triangles.push_back({previous_[i], i, next_[i]});
      break;
    }
    return clean;
  }

 private:
  double turn(std::uint32_t i) const { return cross(points_[previous_[i]], points_[i], points_[next_[i]]); }

  bool is_ear(std::uint32_t i) {
    const glm::dvec2 a = points_[previous_[i]];
    const glm::dvec2 b = points_[i];
    const glm::dvec2 c = points_[next_[i]];
    const double area = cross(a, b, c);
    if (area < 0) return false;
    if (area == 0) return glm::dot(a - b, c - b) <= 0;  // straight on: cutting it off loses nothing
    std::size_t kept = 0;
    bool blocked = false;
    for (std::size_t k = 0; k < reflex_.size(); ++k) {
      const std::uint32_t r = reflex_[k];
      // Corners only ever become less reflex; those cut off or turned convex leave the list for good.
      if (!alive_[r] || turn(r) > 0) continue;
      reflex_[kept++] = r;
      if (blocked || r == i || r == previous_[i] || r == next_[i]) continue;
      const glm::dvec2 p = points_[r];
      if (p == a || p == b || p == c) continue;  // the seam of an outline with a hole touches itself
      blocked = cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0;
    }
    reflex_.resize(kept);
    return !blocked;
  }

  std::uint32_t sharpest() const {
    std::uint32_t best = 0;
    double best_turn = -std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < alive_.size(); ++i) {
      if (!alive_[i]) continue;
      const double t = turn(i);
      // The smallest of the convex ones, else the least reflex one.
      const double score = t >= 0 ? 1 / (1 + t) : t;
      if (score > best_turn) {
        best_turn = score;
        best = i;
      }
    }
    return best;
  }

  void clip(std::uint32_t i, std::vector<Triangle>& triangles) {
    triangles.push_back({previous_[i], i, next_[i]});
    alive_[i] = false;
    next_[previous_[i]] = next_[i];
    previous_[next_[i]] = previous_[i];
    --remaining_;
    for (const std::uint32_t k : {previous_[i], next_[i]}) {
      // Behind a forced cut a convex corner may have become reflex.
      if (turn(k) <= 0 && std::find(reflex_.begin(), reflex_.end(), k) == reflex_.end()) reflex_.push_back(k);
      if (!queued_[k]) {
        queued_[k] = true;
        queue_.push_back(k);
      }
    }
  }

  std::span<const glm::dvec2> points_;
  std::vector<std::uint32_t> next_, previous_, reflex_;
  std::vector<bool> alive_, queued_;
  std::deque<std::uint32_t> queue_;
  std::uint32_t remaining_ = 0;
};

bool is_thin(std::span<const glm::dvec3> corners, double area) {
  double longest = 0;
  for (std::size_t i = 0; i < corners.size(); ++i)
    longest = std::max(longest, glm::distance(corners[i], corners[(i + 1) % corners.size()]));
  return !(area > 0.5 * kLeastHeight * longest) || !(longest > kLeastHeight);
}

}  // namespace

SplitOutcome split_into_convex(std::span<const glm::dvec3> vertices, std::span<const std::uint32_t> corners,
                               std::uint32_t part, double planarity, double convexity, std::vector<Face>& pieces) {
  SplitOutcome outcome;
  std::vector<glm::dvec3> points;
  gather_corners(vertices, corners, points);
  const glm::dvec3 area = vector_area(points);
  const double size = glm::length(area);
  if (is_thin(points, size)) {
    outcome.degenerate = true;
    return outcome;
  }
  const Plane plane = plane_midway(points, area / size);
  outcome.not_planar = points.size() > 3 && deviation(points, plane) > planarity;
  std::vector<glm::dvec2> outline;
  project(points, plane.normal, outline);
  const bool convex = is_convex(outline, convexity);
  if (!outcome.not_planar && convex) {
    pieces.push_back({{corners.begin(), corners.end()}, part, plane});
    return outcome;
  }
  outcome.concave = !convex;

  std::vector<Triangle> triangles;
  if (points.size() == 4 && convex) {
    // The shorter diagonal makes the better triangles.
    if (glm::distance(points[0], points[2]) <= glm::distance(points[1], points[3]))
      triangles = {{0, 1, 2}, {0, 2, 3}};
    else
      triangles = {{0, 1, 3}, {1, 2, 3}};
  } else {
    outcome.self_crossing = !EarClipper(outline).run(triangles);
  }

  std::vector<Face> found;
  std::vector<glm::dvec3> three(3);
  for (const Triangle& triangle : triangles) {
    for (std::size_t i = 0; i < 3; ++i) three[i] = points[triangle[i]];
    const glm::dvec3 own_area = vector_area(three);
    const double own_size = glm::length(own_area);
    // What a forced cut turned over, and slivers along straight edges, are no surface of this face.
    const double turn = cross(outline[triangle[0]], outline[triangle[1]], outline[triangle[2]]);
    const bool thin = is_thin(three, own_size);
    if (turn < 0 && !thin) outcome.self_crossing = true;
    if (turn <= 0 || thin) continue;
    // A sliver's own normal says nothing where the whole face's is known.
    const Plane own = outcome.not_planar ? plane_midway(three, own_area / own_size) : plane;
    found.push_back({{triangle.begin(), triangle.end()}, part, own});
  }
  if (found.size() > 1 && points.size() > 4 - (outcome.not_planar ? 0 : 1)) {
    // Corners stay where they are: the neighbours of this face need them.
    const MergeLimits limits{planarity, convexity, std::numeric_limits<double>::infinity(), false};
    merge_faces(points, found, limits);
  }
  for (Face& piece : found) {
    for (std::uint32_t& corner : piece.corners) corner = corners[corner];
    pieces.push_back(std::move(piece));
  }
  outcome.degenerate = found.empty();
  return outcome;
}

}  // namespace foreview
