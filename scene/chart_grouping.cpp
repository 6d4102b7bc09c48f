#include "foreview/scene/chart_grouping.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>

#include "foreview/scene/polygon_geometry.h"

namespace foreview {

const double kLeastGroupCosine = 0.71;
const double kLeastTinyCosine = 0.3;

namespace {

constexpr double kOverlapTolerance = 1e-3;  // texels; the corners of neighbours are the same up to rounding
constexpr double kLeastFill = 0.3;          // share of a group's box that members cover; a triangle has 0.5 of its own
constexpr double kMostLoss = 0.25;          // share of its gutter that a polygon may lose in texels by its inclination
constexpr double kTinyTexels = 4;           // area of polygons that any colour serves, but a block of their own wastes
constexpr std::size_t kMostNear = 400;      // members near a polygon: more would make the effort grow with their square
constexpr double kMostCells = 256;  // from the seed to the furthest that a group can reach; there are least an 8th
constexpr std::size_t kRingPolygons = 32;  // round the seed, for the first guess of the group's normal

/// Directed edges of all polygons, found by their ends.
class EdgeTable {
 public:
  EdgeTable(const PolygonModel& model, const std::vector<std::uint32_t>& places) {
    edges_.reserve(model.corners().size());
    for (std::uint32_t p = 0; p < model.polygons().size(); ++p) {
      const Polygon& polygon = model.polygons()[p];
      for (std::uint32_t i = 0; i < polygon.corner_count; ++i)
        edges_.push_back({places[polygon.first_corner + i],
                          places[polygon.first_corner + (i + 1) % polygon.corner_count], polygon.first_corner + i, p});
    }
    std::sort(edges_.begin(), edges_.end(), [](const Edge& a, const Edge& b) {
      return std::tie(a.from, a.to, a.corner) < std::tie(b.from, b.to, b.corner);
    });
  }

  /// Calls use(corner, polygon, corner across, polygon across) for every pair of opposite edges, both ways round.
  template <typename Use>
  void for_each_pair(const Use& use) const {
    for (const Edge& edge : edges_) {
      auto across = std::lower_bound(edges_.begin(), edges_.end(), edge, [](const Edge& other, const Edge& wanted) {
        return std::tie(other.from, other.to) < std::tie(wanted.to, wanted.from);
      });
      for (; across != edges_.end() && across->from == edge.to && across->to == edge.from; ++across)
        if (across->polygon != edge.polygon) use(edge.corner, edge.polygon, across->corner, across->polygon);
    }
  }

 private:
  struct Edge {
    std::uint32_t from, to;  // places
    std::uint32_t corner, polygon;
  };
  std::vector<Edge> edges_;
};

/// A convex polygon in a group's plane, texels.
struct Outline {
  std::span<const glm::dvec2> corners;
  glm::dvec2 low, high;
};

/// How far apart along the normals of a's edges; below 0 they overlap along all of them.
double gap_along_edges(const Outline& a, const Outline& b) {
  double gap = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < a.corners.size(); ++i) {
    const glm::dvec2 from = a.corners[i];
    const glm::dvec2 edge = a.corners[(i + 1) % a.corners.size()] - from;
    const double length = glm::length(edge);
    if (!(length > 0)) continue;
    const glm::dvec2 outwards(edge.y / length, -edge.x / length);
    double nearest = std::numeric_limits<double>::infinity();
    for (const glm::dvec2& corner : b.corners) nearest = std::min(nearest, glm::dot(outwards, corner - from));
    gap = std::max(gap, nearest);
  }
  return gap;
}

bool overlap(const Outline& a, const Outline& b) {
  return gap_along_edges(a, b) < -kOverlapTolerance && gap_along_edges(b, a) < -kOverlapTolerance;
}

double corner_distance_squared(const Outline& a, const Outline& b) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < a.corners.size(); ++i) {
    const glm::dvec2 from = a.corners[i];
    const glm::dvec2 edge = a.corners[(i + 1) % a.corners.size()] - from;
    const double squared = glm::dot(edge, edge);
    for (const glm::dvec2& corner : b.corners) {
      const glm::dvec2 p = corner - from;
      const double t = squared > 0 ? std::clamp(glm::dot(p, edge) / squared, 0.0, 1.0) : 0.0;
      const glm::dvec2 off = p - t * edge;
      nearest = std::min(nearest, glm::dot(off, off));
    }
  }
  return nearest;
}

/// Of polygons that do not overlap.
bool nearer_than(const Outline& a, const Outline& b, double distance) {
  return std::min(corner_distance_squared(a, b), corner_distance_squared(b, a)) < distance * distance;
}

std::vector<glm::dvec2> convex_hull(std::vector<glm::dvec2> points) {
  std::sort(points.begin(), points.end(),
            [](const glm::dvec2& a, const glm::dvec2& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  std::vector<glm::dvec2> hull;
  for (const bool upper : {false, true}) {
    const std::size_t begin = hull.size();
    for (const glm::dvec2& p : points) {
      while (hull.size() >= begin + 2 && cross(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    if (!upper) std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// Right-handed: x cross y is the normal.
struct Axes {
  glm::dvec3 normal, x, y;
};

Axes turned(const Axes& axes, const glm::dvec2& y) {
  const glm::dvec3 along = y.x * axes.x + y.y * axes.y;
  return {axes.normal, glm::cross(along, axes.normal), along};
}

class Grouper {
 public:
  Grouper(const PolygonModel& model, const std::vector<bool>& may_group, const GroupingLimits& limits)
      : model_(model),
        limits_(limits),
        free_(may_group),
        places_(places_of_corners(model)),
        state_(model.polygons().size(), State::unknown),
        slot_(model.polygons().size(), 0),
        ring_stamp_(model.polygons().size(), 0) {
    link();
    const double area = std::accumulate(areas_.begin(), areas_.end(), 0.0) / static_cast<double>(areas_.size());
    const double finest = std::max(1.0, limits.max_texels / kMostCells);
    cell_ = std::clamp(std::sqrt(area) * limits.texels_per_metre, finest, 8 * finest);
    row_cells_ = 2 * static_cast<int>(std::ceil(limits.max_texels / cell_)) + 6;
    cells_.resize(static_cast<std::size_t>(row_cells_) * static_cast<std::size_t>(row_cells_));
  }

  std::vector<PolygonGroup> run();

 private:
  enum class State : std::uint8_t { unknown, waiting, member };

  /// A group while it grows.
  struct Growth {
    Axes axes;
    glm::dvec3 origin;  ///< the seed's first corner
    std::vector<std::uint32_t> members;
    std::vector<glm::dvec2> corners;      ///< texels, of all members
    std::vector<std::uint32_t> first{0};  ///< into corners, members + 1 entries
    std::vector<glm::dvec2> lows, highs;  ///< boxes of the members
    glm::dvec2 low, high;                 ///< box of all
    double area = 0;                      ///< texels
    [[nodiscard]] Outline outline(std::size_t slot) const {
      return {std::span(corners).subspan(first[slot], first[slot + 1] - first[slot]), lows[slot], highs[slot]};
    }
  };

  void link();
  [[nodiscard]] glm::dvec3 normal_around(std::uint32_t seed);
  [[nodiscard]] Growth grow(std::uint32_t seed, const Axes& axes);
  bool try_add(Growth& growth, std::uint32_t polygon);
  bool keeps_apart(const Growth& growth, std::uint32_t polygon, const Outline& outline);
  /// So small that the distance of their boxes is as good as theirs.
  [[nodiscard]] bool are_tiny(const Outline& a, const Outline& b) const {
    const glm::dvec2 size = glm::max(a.high - a.low, b.high - b.low);
    return std::max(size.x, size.y) < 0.25 * limits_.separation;
  }
  [[nodiscard]] bool share_place(std::uint32_t a, std::uint32_t b) const;
  [[nodiscard]] PolygonFrame frame_of(const Growth& growth) const;
  template <typename Use>
  void for_cells(const glm::dvec2& low, const glm::dvec2& high, const Use& use);

  const PolygonModel& model_;
  GroupingLimits limits_;
  double cell_ = 1;    // texels: about the size of a polygon
  int row_cells_ = 1;  // cells of the grid along an axis; what lies further counts as on its rim
  std::vector<bool> free_;
  std::vector<std::uint32_t> places_;         // by corner
  std::vector<std::uint32_t> sorted_places_;  // by corner, sorted inside each polygon
  std::vector<double> areas_;                 // square metres
  std::vector<double> least_cosine_;          // to a group's normal, by polygon
  std::vector<std::uint32_t> linked_, first_linked_;
  // While a group grows:
  std::vector<std::vector<std::uint32_t>> cells_;  // slots of the members whose boxes touch a cell
  std::vector<std::size_t> used_cells_;
  std::vector<State> state_;
  std::vector<std::uint32_t> slot_;
  std::vector<std::uint32_t> ring_stamp_;
  std::uint32_t ring_ = 0;
  struct Look {
    std::uint32_t seen = 0, near = 0;  // the last look that came by the slot, and found it near
  };
  std::vector<Look> looks_;                          // by slot
  std::vector<std::uint32_t> near_, open_, passed_;  // slots
  std::uint32_t look_ = 0;
  std::vector<std::uint32_t> touched_;
  std::vector<glm::dvec2> candidate_;
};

void Grouper::link() {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  const EdgeTable edges(model_, places_);
  edges.for_each_pair([&](std::uint32_t, std::uint32_t a, std::uint32_t, std::uint32_t b) {
    if (free_[a] && free_[b]) pairs.emplace_back(a, b);
  });
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  first_linked_.assign(model_.polygons().size() + 1, 0);
  for (const auto& [a, b] : pairs) {
    ++first_linked_[a + 1];
    linked_.push_back(b);
  }
  std::partial_sum(first_linked_.begin(), first_linked_.end(), first_linked_.begin());

  sorted_places_ = places_;
  std::vector<glm::dvec3> corners;
  for (std::size_t p = 0; p < model_.polygons().size(); ++p) {
    const Polygon& polygon = model_.polygons()[p];
    const auto first = sorted_places_.begin() + static_cast<std::ptrdiff_t>(polygon.first_corner);
    std::sort(first, first + static_cast<std::ptrdiff_t>(polygon.corner_count));
    corners.clear();
    for (const std::uint32_t vertex : model_.corners_of(p)) corners.push_back(model_.vertices()[vertex]);
    const double area = areas_.emplace_back(glm::length(vector_area(corners)));
    double perimeter = 0;
    for (std::size_t i = 0; i < corners.size(); ++i)
      perimeter += glm::distance(corners[i], corners[(i + 1) % corners.size()]);
    const double gutter = limits_.gutter * perimeter / limits_.texels_per_metre;
    const double texels = area * limits_.texels_per_metre * limits_.texels_per_metre;
    const double least = texels < kTinyTexels ? kLeastTinyCosine : kLeastGroupCosine;
    least_cosine_.push_back(area > 0 ? std::max(least, 1 - kMostLoss * gutter / area) : least);
  }
}

bool Grouper::share_place(std::uint32_t a, std::uint32_t b) const {
  const Polygon& p = model_.polygons()[a];
  const Polygon& q = model_.polygons()[b];
  std::uint32_t i = p.first_corner;
  std::uint32_t k = q.first_corner;
  while (i < p.first_corner + p.corner_count && k < q.first_corner + q.corner_count) {
    if (sorted_places_[i] == sorted_places_[k]) return true;
    ++(sorted_places_[i] < sorted_places_[k] ? i : k);
  }
  return false;
}

/// Mean normal of the seed and the free polygons nearest to it through the mesh, as far as they face its way.
glm::dvec3 Grouper::normal_around(std::uint32_t seed) {
  ++ring_;
  const glm::dvec3 own = model_.polygons()[seed].normal;
  std::vector<std::uint32_t> ring{seed};
  ring_stamp_[seed] = ring_;
  glm::dvec3 sum(0);
  for (std::size_t i = 0; i < ring.size() && i < kRingPolygons; ++i) {
    const std::uint32_t p = ring[i];
    sum += areas_[p] * model_.polygons()[p].normal;
    for (std::uint32_t k = first_linked_[p]; k < first_linked_[p + 1]; ++k) {
      const std::uint32_t q = linked_[k];
      if (!free_[q] || ring_stamp_[q] == ring_ || glm::dot(model_.polygons()[q].normal, own) < kLeastGroupCosine)
        continue;
      ring_stamp_[q] = ring_;
      ring.push_back(q);
    }
  }
  return glm::normalize(sum);
}

template <typename Use>
void Grouper::for_cells(const glm::dvec2& low, const glm::dvec2& high, const Use& use) {
  const auto column = [&](double value) {
    return std::clamp(static_cast<int>(std::floor(value / cell_)) + row_cells_ / 2, 0, row_cells_ - 1);
  };
  for (int y = column(low.y); y <= column(high.y); ++y)
    for (int x = column(low.x); x <= column(high.x); ++x)
      use(static_cast<std::size_t>(y) * static_cast<std::size_t>(row_cells_) + static_cast<std::size_t>(x));
}

/// Whether the polygon overlaps no member, and hangs together with all that are near.
bool Grouper::keeps_apart(const Growth& growth, std::uint32_t polygon, const Outline& outline) {
  ++look_;
  near_.clear();
  open_.clear();
  const double reach = limits_.separation;
  bool free = true;
  for_cells(outline.low - reach, outline.high + reach, [&](std::size_t cell) {
    if (!free) return;
    for (const std::uint32_t slot : cells_[cell]) {
      if (looks_[slot].seen == look_) continue;
      looks_[slot].seen = look_;
      const Outline other = growth.outline(slot);
      const glm::dvec2 between = glm::max(other.low - outline.high, outline.low - other.high);
      const double apart = std::max(between.x, between.y);
      if (apart > reach) continue;
      if (apart < 0 && overlap(outline, other)) {
        free = false;
        return;
      }
      if (apart <= 0 && share_place(polygon, growth.members[slot])) {
        open_.push_back(slot);
      } else if (are_tiny(outline, other) || nearer_than(outline, other, reach)) {
        looks_[slot].near = look_;
        near_.push_back(slot);
      }
      if (near_.size() + open_.size() > kMostNear) {
        free = false;
        return;
      }
    }
  });
  if (!free) return false;
  if (near_.empty()) return true;
  // From the members that share a corner with it to all that are near: through shared edges, which is quick, then
  // through shared corners.
  const auto reached = [&](std::uint32_t slot) { return looks_[slot].near != look_; };
  while (!open_.empty()) {
    const std::uint32_t from = growth.members[open_.back()];
    passed_.push_back(open_.back());
    open_.pop_back();
    for (std::uint32_t k = first_linked_[from]; k < first_linked_[from + 1]; ++k) {
      if (state_[linked_[k]] != State::member || reached(slot_[linked_[k]])) continue;
      looks_[slot_[linked_[k]]].near = 0;
      open_.push_back(slot_[linked_[k]]);
    }
    if (!open_.empty()) continue;
    std::erase_if(near_, reached);
    for (const std::uint32_t slot : near_) {
      if (std::none_of(passed_.begin(), passed_.end(),
                       [&](std::uint32_t other) { return share_place(growth.members[slot], growth.members[other]); }))
        continue;
      looks_[slot].near = 0;
      open_.push_back(slot);
    }
  }
  passed_.clear();
  return std::all_of(near_.begin(), near_.end(), reached);
}

bool Grouper::try_add(Growth& growth, std::uint32_t polygon) {
  if (glm::dot(model_.polygons()[polygon].normal, growth.axes.normal) < least_cosine_[polygon]) return false;
  candidate_.clear();
  glm::dvec2 low(std::numeric_limits<double>::infinity());
  glm::dvec2 high(-std::numeric_limits<double>::infinity());
  for (const std::uint32_t vertex : model_.corners_of(polygon)) {
    const glm::dvec3 p = (model_.vertices()[vertex] - growth.origin) * limits_.texels_per_metre;
    const glm::dvec2& q = candidate_.emplace_back(glm::dot(p, growth.axes.x), glm::dot(p, growth.axes.y));
    low = glm::min(low, q);
    high = glm::max(high, q);
  }
  const double area = signed_area(candidate_);
  if (!growth.members.empty()) {
    const glm::dvec2 box_low = glm::min(low, growth.low);
    const glm::dvec2 box_high = glm::max(high, growth.high);
    const glm::dvec2 size = box_high - box_low;
    if (!(area > 0) || size.x > limits_.max_texels || size.y > limits_.max_texels) return false;
    const bool grows = box_low != growth.low || box_high != growth.high;
    if (grows && growth.area + area < kLeastFill * size.x * size.y) return false;
    if (!keeps_apart(growth, polygon, {candidate_, low, high})) return false;
    growth.low = box_low;
    growth.high = box_high;
  } else {
    growth.low = low;
    growth.high = high;
  }
  const auto slot = static_cast<std::uint32_t>(growth.members.size());
  growth.members.push_back(polygon);
  growth.corners.insert(growth.corners.end(), candidate_.begin(), candidate_.end());
  growth.first.push_back(static_cast<std::uint32_t>(growth.corners.size()));
  growth.lows.push_back(low);
  growth.highs.push_back(high);
  growth.area += area;
  slot_[polygon] = slot;
  if (looks_.size() <= slot) looks_.resize(slot + 1);
  for_cells(low, high, [&](std::size_t cell) {
    if (cells_[cell].empty()) used_cells_.push_back(cell);
    cells_[cell].push_back(slot);
  });
  return true;
}

/// From the seed outwards, in squares, so that the group fills its box.
Grouper::Growth Grouper::grow(std::uint32_t seed, const Axes& axes) {
  struct Candidate {
    double reach;
    std::uint32_t polygon;
    bool operator<(const Candidate& other) const {
      return reach != other.reach ? reach > other.reach : polygon > other.polygon;
    }
  };
  Growth growth;
  growth.axes = axes;
  growth.origin = model_.corner(seed, 0);
  std::priority_queue<Candidate> queue;
  const auto add = [&](std::uint32_t polygon) {
    if (!try_add(growth, polygon)) {
      state_[polygon] = State::unknown;  // another neighbour may change that
      return;
    }
    state_[polygon] = State::member;
    for (std::uint32_t k = first_linked_[polygon]; k < first_linked_[polygon + 1]; ++k) {
      const std::uint32_t next = linked_[k];
      if (!free_[next] || state_[next] != State::unknown) continue;
      double reach = 0;
      for (const std::uint32_t vertex : model_.corners_of(next)) {
        const glm::dvec3 p = model_.vertices()[vertex] - growth.origin;
        reach = std::max({reach, std::abs(glm::dot(p, axes.x)), std::abs(glm::dot(p, axes.y))});
      }
      queue.push({reach, next});
      state_[next] = State::waiting;
      touched_.push_back(next);
    }
  };
  touched_.push_back(seed);
  add(seed);
  while (!queue.empty()) {
    const std::uint32_t next = queue.top().polygon;
    queue.pop();
    add(next);
  }
  for (const std::uint32_t p : touched_) state_[p] = State::unknown;
  touched_.clear();
  for (const std::size_t cell : used_cells_) cells_[cell].clear();
  used_cells_.clear();
  return growth;
}

PolygonFrame Grouper::frame_of(const Growth& growth) const {
  const EdgeBox box = smallest_box(convex_hull(growth.corners));
  Axes axes = growth.axes;
  if (std::max(box.extent.x, box.extent.y) <= limits_.max_texels) axes = turned(growth.axes, box.y_axis);
  PolygonFrame frame;
  frame.x_axis = axes.x;
  frame.y_axis = axes.y;
  glm::dvec2 low(std::numeric_limits<double>::infinity());
  glm::dvec2 high(-std::numeric_limits<double>::infinity());
  // The plane lies midway between the lowest and the highest corner.
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -std::numeric_limits<double>::infinity();
  for (const std::uint32_t member : growth.members) {
    for (const std::uint32_t vertex : model_.corners_of(member)) {
      const glm::dvec3 p = model_.vertices()[vertex] - growth.origin;
      const glm::dvec2 q(glm::dot(p, axes.x), glm::dot(p, axes.y));
      low = glm::min(low, q);
      high = glm::max(high, q);
      lowest = std::min(lowest, glm::dot(p, axes.normal));
      highest = std::max(highest, glm::dot(p, axes.normal));
    }
  }
  frame.origin = growth.origin + low.x * axes.x + low.y * axes.y + 0.5 * (lowest + highest) * axes.normal;
  frame.extent = high - low;
  return frame;
}

std::vector<PolygonGroup> Grouper::run() {
  std::vector<PolygonGroup> groups;
  std::vector<std::uint32_t> order(model_.polygons().size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return areas_[a] > areas_[b]; });
  for (const std::uint32_t seed : order) {
    if (!free_[seed]) continue;
    const PolygonFrame own = polygon_frame(model_, seed);
    glm::dvec3 normal = normal_around(seed);
    if (!(glm::dot(normal, model_.polygons()[seed].normal) >= least_cosine_[seed]))
      normal = model_.polygons()[seed].normal;
    const auto axes_along = [](const glm::dvec3& n, const glm::dvec3& along) {
      const glm::dvec3 y = glm::normalize(along - glm::dot(along, n) * n);
      return Axes{n, glm::cross(y, n), y};
    };
    Growth growth = grow(seed, axes_along(normal, own.y_axis));
    if (growth.members.size() > 1) {
      // Once more with what the first attempt tells about the normal and the box.
      glm::dvec3 sum(0);
      for (const std::uint32_t member : growth.members) sum += areas_[member] * model_.polygons()[member].normal;
      const glm::dvec3 mean = glm::normalize(sum);
      // (Far from the first normal, the box's axes could lie along the second.)
      if (glm::dot(mean, model_.polygons()[seed].normal) >= least_cosine_[seed] && glm::dot(mean, normal) > 0.5) {
        const PolygonFrame frame = frame_of(growth);
        Growth again = grow(seed, axes_along(mean, frame.y_axis));
        if (again.area >= growth.area) growth = std::move(again);
      }
    }
    PolygonGroup& group = groups.emplace_back();
    group.members = growth.members;
    std::sort(group.members.begin(), group.members.end());
    group.frame = growth.members.size() > 1 ? frame_of(growth) : own;
    for (const std::uint32_t member : group.members) free_[member] = false;
  }
  return groups;
}

}  // namespace

std::vector<std::uint32_t> places_of_corners(const PolygonModel& model) {
  struct Corner {
    std::uint32_t part, vertex, corner;
  };
  std::vector<Corner> order;
  order.reserve(model.corners().size());
  for (const Polygon& polygon : model.polygons())
    for (std::uint32_t i = polygon.first_corner; i < polygon.first_corner + polygon.corner_count; ++i)
      order.push_back({polygon.part, model.corners()[i], i});
  const auto key = [&](const Corner& c) {
    const glm::dvec3& p = model.vertices()[c.vertex];
    return std::make_tuple(c.part, p.x, p.y, p.z);
  };
  std::sort(order.begin(), order.end(), [&](const Corner& a, const Corner& b) { return key(a) < key(b); });
  std::vector<std::uint32_t> places(model.corners().size(), 0);
  std::uint32_t place = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i > 0 && key(order[i - 1]) != key(order[i])) ++place;
    places[order[i].corner] = place;
  }
  return places;
}

std::vector<bool> outline_of_groups(const PolygonModel& model, const std::vector<std::uint32_t>& group_of) {
  std::vector<bool> outline(model.corners().size(), true);
  EdgeTable(model, places_of_corners(model))
      .for_each_pair([&](std::uint32_t corner, std::uint32_t polygon, std::uint32_t, std::uint32_t across) {
        if (group_of[polygon] == group_of[across]) outline[corner] = false;
      });
  return outline;
}

std::vector<PolygonGroup> group_polygons(const PolygonModel& model, const std::vector<bool>& may_group,
                                         const GroupingLimits& limits) {
  std::vector<PolygonGroup> groups = Grouper(model, may_group, limits).run();
  std::vector<bool> grouped(model.polygons().size(), false);
  for (const PolygonGroup& group : groups)
    for (const std::uint32_t member : group.members) grouped[member] = true;
  for (std::uint32_t p = 0; p < grouped.size(); ++p)
    if (!grouped[p]) groups.push_back({{p}, polygon_frame(model, p)});
  std::sort(groups.begin(), groups.end(),
            [](const PolygonGroup& a, const PolygonGroup& b) { return a.members[0] < b.members[0]; });
  return groups;
}

}  // namespace foreview
