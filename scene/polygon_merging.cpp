#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <tuple>

#include "foreview/scene/polygon_face.h"

namespace foreview {
namespace {

constexpr double kLeastCosine = 0.99939;       // 2 degrees
constexpr std::size_t kMaxMergedCorners = 64;  // keeps every later step on a polygon cheap
constexpr int kMaxPasses = 10;

struct Candidate {
  std::uint32_t from = 0, to = 0;  // the edge as face `left` has it
  std::uint32_t left = 0, right = 0;
  double length = 0;
  std::uint32_t tried_at = 0;
};

class Merger {
 public:
  Merger(std::span<const glm::dvec3> vertices, std::vector<Face>& faces, const MergeLimits& limits)
      : vertices_(vertices), faces_(faces), limits_(limits), owner_(faces.size()), changed_at_(faces.size(), 1) {
    std::iota(owner_.begin(), owner_.end(), 0U);
    uses_.assign(vertices.size(), 0);
    for (const Face& face : faces)
      for (const std::uint32_t corner : face.corners) ++uses_[corner];
    find_candidates();
  }

  std::vector<std::uint32_t> run() {
    for (int pass = 0; pass < kMaxPasses; ++pass) {
      const std::uint32_t before = now_;
      for (Candidate& candidate : candidates_) {
        const std::uint32_t a = find(candidate.left);
        const std::uint32_t b = find(candidate.right);
        // Nothing new since it was refused last time.
        if (a == b || std::max(changed_at_[a], changed_at_[b]) <= candidate.tried_at) continue;
        candidate.tried_at = now_;
        if (try_merge(a, b, candidate.from, candidate.to)) ++now_;
      }
      if (now_ == before) break;
    }
    return compact();
  }

 private:
  void find_candidates() {
    struct HalfEdge {
      std::uint32_t low, high, face;
      bool forward;
    };
    std::vector<HalfEdge> edges;
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      const auto& corners = faces_[f].corners;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const std::uint32_t u = corners[i];
        const std::uint32_t v = corners[(i + 1) % corners.size()];
        edges.push_back({std::min(u, v), std::max(u, v), f, u < v});
      }
    }
    std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
      return std::tie(a.low, a.high, a.face) < std::tie(b.low, b.high, b.face);
    });
    for (std::size_t i = 0; i < edges.size();) {
      std::size_t end = i + 1;
      while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
      const HalfEdge& first = edges[i];
      if (end - i == 2 && first.forward != edges[i + 1].forward && first.face != edges[i + 1].face &&
          faces_[first.face].part == faces_[edges[i + 1].face].part) {
        Candidate candidate;
        candidate.from = first.forward ? first.low : first.high;
        candidate.to = first.forward ? first.high : first.low;
        candidate.left = first.face;
        candidate.right = edges[i + 1].face;
        candidate.length = glm::distance(vertices_[first.low], vertices_[first.high]);
        if (glm::dot(faces_[candidate.left].plane.normal, faces_[candidate.right].plane.normal) >= kLeastCosine)
          candidates_.push_back(candidate);
      }
      i = end;
    }
    std::stable_sort(candidates_.begin(), candidates_.end(),
                     [](const Candidate& a, const Candidate& b) { return a.length > b.length; });
  }

  std::uint32_t find(std::uint32_t face) {
    while (owner_[face] != face) face = owner_[face] = owner_[owner_[face]];
    return face;
  }

  bool try_merge(std::uint32_t a, std::uint32_t b, std::uint32_t u, std::uint32_t v) {
    const Face& left = faces_[a];
    const Face& right = faces_[b];
    if (glm::dot(left.plane.normal, right.plane.normal) < kLeastCosine) return false;
    if (!join_outlines(left.corners, right.corners, u, v)) return false;

    gather_corners(vertices_, joined_, points_);
    const glm::dvec3 area = vector_area(points_);
    const double size = glm::length(area);
    if (!(size > 0)) return false;
    const glm::dvec3 normal = area / size;
    if (glm::dot(normal, left.plane.normal) < kLeastCosine || glm::dot(normal, right.plane.normal) < kLeastCosine)
      return false;
    if (turns_right(joined_.size() - seam_, normal) || turns_right(0, normal)) return false;
    // Corners that vanish inside must lie in the plane too.
    gather_corners(vertices_, left.corners, all_points_);
    for (const std::uint32_t corner : right.corners) all_points_.push_back(vertices_[corner]);
    const Plane plane = plane_midway(all_points_, normal);
    if (deviation(all_points_, plane) > limits_.planarity) return false;
    project(points_, normal, outline_);
    if (!is_convex(outline_, limits_.convexity)) return false;
    const EdgeBox box = smallest_box(outline_);
    if (std::max(box.extent.x, box.extent.y) > limits_.max_extent * (1 + 1e-9)) return false;

    for (const std::uint32_t corner : left.corners) --uses_[corner];
    for (const std::uint32_t corner : right.corners) --uses_[corner];
    if (limits_.drop_corners) drop_straight_corners();
    for (const std::uint32_t corner : joined_) ++uses_[corner];
    faces_[a].corners = joined_;
    faces_[a].plane = plane;
    faces_[b].corners.clear();
    owner_[b] = a;
    changed_at_[a] = now_ + 1;
    return true;
  }

  /// Walks from the end of the common run of edges around `left` to its beginning, then around `right`.
  bool join_outlines(const std::vector<std::uint32_t>& left, const std::vector<std::uint32_t>& right, std::uint32_t u,
                     std::uint32_t v) {
    const std::size_t n = left.size();
    const std::size_t m = right.size();
    const auto position = [](const std::vector<std::uint32_t>& corners, std::uint32_t corner) {
      return static_cast<std::size_t>(std::find(corners.begin(), corners.end(), corner) - corners.begin());
    };
    std::size_t begin = position(left, u);
    std::size_t right_begin = position(right, u);
    std::size_t end = position(left, v);
    std::size_t right_end = position(right, v);
    // A corner that an earlier merge dropped takes its edges with it.
    if (begin == n || end != (begin + 1) % n || right_end == m || right_begin != (right_end + 1) % m) return false;
    std::size_t run = 1;
    const std::size_t longest = std::min(n, m);
    while (run < longest && left[(end + 1) % n] == right[(right_end + m - 1) % m]) {
      end = (end + 1) % n;
      right_end = (right_end + m - 1) % m;
      ++run;
    }
    while (run < longest && left[(begin + n - 1) % n] == right[(right_begin + 1) % m]) {
      begin = (begin + n - 1) % n;
      right_begin = (right_begin + 1) % m;
      ++run;
    }
    if (n + m < 2 * run + 3 || run + 1 > longest || n + m - 2 * run > kMaxMergedCorners) return false;
    joined_.clear();
    for (std::size_t i = end;; i = (i + 1) % n) {
      joined_.push_back(left[i]);
      if (i == begin) break;
    }
    seam_ = 1;
    for (std::size_t i = (right_begin + 1) % m; i != right_end; i = (i + 1) % m) {
      joined_.push_back(right[i]);
      ++seam_;
    }
    // Faces that meet in a second place, too, would enclose a hole.
    sorted_ = joined_;
    std::sort(sorted_.begin(), sorted_.end());
    return std::adjacent_find(sorted_.begin(), sorted_.end()) == sorted_.end();
  }

  /// Both outlines are convex: only where they meet can the result be concave. A clear case costs no more than this.
  bool turns_right(std::size_t i, const glm::dvec3& normal) const {
    const std::size_t n = points_.size();
    const glm::dvec3 in = points_[i] - points_[(i + n - 1) % n];
    const glm::dvec3 out = points_[(i + 1) % n] - points_[i];
    return glm::dot(glm::cross(in, out), normal) < -1e-2 * glm::length(in) * glm::length(out) &&
           glm::dot(glm::cross(in, out), normal) < -limits_.convexity * glm::length(in + out);
  }

  void drop_straight_corners() {
    for (std::size_t i = 0; i < joined_.size() && joined_.size() > 3;) {
      const std::size_t n = joined_.size();
      const glm::dvec3 before = vertices_[joined_[(i + n - 1) % n]];
      const glm::dvec3 here = vertices_[joined_[i]];
      const glm::dvec3 after = vertices_[joined_[(i + 1) % n]];
      const double base = glm::distance(before, after);
      const double height = glm::length(glm::cross(here - before, after - before)) / base;
      // Tighter than convexity: many small steps must not add up to a visible one.
      if (uses_[joined_[i]] == 0 && base > 0 && height < 1e-2 * limits_.convexity)
        joined_.erase(joined_.begin() + static_cast<std::ptrdiff_t>(i));
      else
        ++i;
    }
  }

  std::vector<std::uint32_t> compact() {
    std::vector<std::uint32_t> result(faces_.size());
    std::vector<std::uint32_t> place(faces_.size());
    std::uint32_t count = 0;
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      if (owner_[f] != f) continue;
      place[f] = count;
      if (count != f) faces_[count] = std::move(faces_[f]);
      ++count;
    }
    for (std::uint32_t f = 0; f < result.size(); ++f) result[f] = place[find(f)];
    faces_.resize(count);
    return result;
  }

  std::span<const glm::dvec3> vertices_;
  std::vector<Face>& faces_;
  MergeLimits limits_;
  std::vector<std::uint32_t> owner_, changed_at_, uses_;
  std::vector<Candidate> candidates_;
  std::uint32_t now_ = 1;
  // Scratch of try_merge, kept for its memory.
  std::vector<std::uint32_t> joined_, sorted_;
  std::size_t seam_ = 0;  // joined_[size - seam_] is where left's outline ends
  std::vector<glm::dvec3> points_, all_points_;
  std::vector<glm::dvec2> outline_;
};

}  // namespace

std::vector<std::uint32_t> merge_faces(std::span<const glm::dvec3> vertices, std::vector<Face>& faces,
                                       const MergeLimits& limits) {
  return Merger(vertices, faces, limits).run();
}

}  // namespace foreview
