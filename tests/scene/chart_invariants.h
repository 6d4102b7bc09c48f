#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <set>

#include "foreview/scene/chart_grouping.h"
#include "foreview/scene/chart_layout.h"

// What every layout must keep, checked with plain definitions and none of the layout's own code.

namespace foreview {

/// Blocks apart and aligned, every polygon in one group, its box inside, its map affine and invertible.
inline void check_layout(const PolygonModel& model, const ChartLayout& layout) {
  ASSERT_EQ(layout.charts.size(), model.polygons().size());
  ASSERT_EQ(layout.outline.size(), model.corners().size());
  const int blocks = layout.page_size / kChartAlignment;
  std::vector<bool> taken(layout.pages * static_cast<std::size_t>(blocks) * static_cast<std::size_t>(blocks), false);
  std::size_t overlaps = 0;
  std::size_t outside = 0;
  std::size_t misaligned = 0;
  std::size_t wrong_size = 0;
  for (const ChartGroup& group : layout.groups) {
    for (int axis = 0; axis < 2; ++axis) {
      misaligned += group.origin[axis] % kChartAlignment + group.size[axis] % kChartAlignment;
      outside += group.origin[axis] < 0 || group.origin[axis] + group.size[axis] > layout.page_size ? 1 : 0;
      const int least = group.inner[axis] + 2 * kChartGutter;
      wrong_size += group.inner[axis] < 1 || group.size[axis] < least || group.size[axis] >= least + kChartAlignment;
    }
    ASSERT_LT(group.page, layout.pages);
    if (outside > 0) continue;
    for (int y = group.origin.y; y < group.origin.y + group.size.y; y += kChartAlignment) {
      for (int x = group.origin.x; x < group.origin.x + group.size.x; x += kChartAlignment) {
        const std::size_t cell =
            (group.page * static_cast<std::size_t>(blocks) + static_cast<std::size_t>(y / kChartAlignment)) *
                static_cast<std::size_t>(blocks) +
            static_cast<std::size_t>(x / kChartAlignment);
        overlaps += taken[cell] ? 1 : 0;
        taken[cell] = true;
      }
    }
  }
  EXPECT_EQ(overlaps, 0U);
  EXPECT_EQ(outside, 0U);
  EXPECT_EQ(misaligned, 0U);
  EXPECT_EQ(wrong_size, 0U);
  EXPECT_EQ(layout.allocated_texels,
            std::size_t{layout.pages} * static_cast<std::size_t>(layout.page_size) * layout.page_size);

  // Every polygon is in one group, and agrees with it.
  std::vector<std::uint32_t> members = layout.members;
  std::sort(members.begin(), members.end());
  ASSERT_EQ(members.size(), model.polygons().size());
  std::size_t corners_outside = 0;
  std::size_t wrong_maps = 0;
  std::size_t next_member = 0;
  for (std::uint32_t g = 0; g < layout.groups.size(); ++g) {
    const ChartGroup& group = layout.groups[g];
    ASSERT_EQ(group.first_member, next_member);
    next_member += group.member_count;
    const auto own = layout.members_of(group);
    ASSERT_GE(own.size(), 1U);
    EXPECT_TRUE(std::is_sorted(own.begin(), own.end()));
    for (const std::uint32_t i : own) {
      ASSERT_EQ(members[i], i);
      const Chart& chart = layout.charts[i];
      ASSERT_EQ(chart.group, g);
      ASSERT_EQ(chart.page, group.page);
      ASSERT_EQ(chart.origin, group.origin);
      ASSERT_EQ(chart.size, group.size);
      ASSERT_EQ(chart.inner, group.inner);
      for (const std::uint32_t corner : model.corners_of(i)) {
        const glm::dvec2 t = chart.texel_from_part(model.vertices()[corner]) - glm::dvec2(chart.origin);
        for (int axis = 0; axis < 2; ++axis)
          corners_outside +=
              t[axis] < static_cast<double>(kChartGutter) - 1e-6 || t[axis] > kChartGutter + chart.inner[axis] + 1e-5
                  ? 1
                  : 0;
      }
      // Inverse of each other on the polygon's plane, anywhere in the block; and finite.
      for (const glm::dvec2& at : {glm::dvec2(0.5), glm::dvec2(chart.size) - 0.5, glm::dvec2(3.25, 7.75)}) {
        const glm::dvec2 texel = glm::dvec2(chart.origin) + at;
        const glm::dvec3 p = chart.part_from_texel(texel);
        const double off_plane = std::abs(glm::dot(model.polygons()[i].normal, p) - model.polygons()[i].offset);
        wrong_maps += glm::distance(chart.texel_from_part(p), texel) < 1e-5 && off_plane < 1e-9 ? 0 : 1;
      }
    }
  }
  EXPECT_EQ(next_member, model.polygons().size());
  EXPECT_EQ(corners_outside, 0U);
  EXPECT_EQ(wrong_maps, 0U);
}

/// Corners of a polygon in its block, texels.
inline std::vector<glm::dvec2> corners_in_block(const PolygonModel& model, const ChartLayout& layout, std::size_t i) {
  std::vector<glm::dvec2> corners;
  for (const std::uint32_t vertex : model.corners_of(i))
    corners.push_back(layout.charts[i].texel_from_part(model.vertices()[vertex]) - glm::dvec2(layout.charts[i].origin));
  return corners;
}

inline std::array<double, 3> place_of(const PolygonModel& model, std::uint32_t vertex) {
  const glm::dvec3& p = model.vertices()[vertex];
  return {p.x, p.y, p.z};
}

inline double distance_to_segment(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b) {
  const double squared = glm::dot(b - a, b - a);
  const double t = squared > 0 ? std::clamp(glm::dot(p - a, b - a) / squared, 0.0, 1.0) : 0.0;
  return glm::distance(p, a + t * (b - a));
}

/// Of polygons that do not cross: from a corner of one to the outline of the other.
inline double distance_between(const std::vector<glm::dvec2>& a, const std::vector<glm::dvec2>& b) {
  double nearest = 1e300;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < b.size(); ++k) {
      nearest = std::min(nearest, distance_to_segment(a[i], b[k], b[(k + 1) % b.size()]));
      nearest = std::min(nearest, distance_to_segment(b[k], a[i], a[(i + 1) % a.size()]));
    }
  }
  return nearest;
}

/// What group_polygons() promises, of a layout's groups.
inline void check_groups(const PolygonModel& model, const ChartLayout& layout, int max_texels) {
  using Place = std::array<double, 3>;
  std::size_t strangers = 0, steep = 0, torn = 0, overlapping = 0, slits = 0, wrong_outline = 0, too_long = 0;
  for (const ChartGroup& group : layout.groups) {
    const auto members = layout.members_of(group);
    std::map<std::pair<Place, Place>, std::vector<std::size_t>> edges;  // directed, to numbers of members
    std::vector<std::set<Place>> places(members.size());
    std::vector<std::vector<glm::dvec2>> corners;
    for (std::size_t m = 0; m < members.size(); ++m) {
      const auto own = model.corners_of(members[m]);
      for (std::size_t k = 0; k < own.size(); ++k) {
        edges[{place_of(model, own[k]), place_of(model, own[(k + 1) % own.size()])}].push_back(m);
        places[m].insert(place_of(model, own[k]));
      }
      corners.push_back(corners_in_block(model, layout, members[m]));
    }
    const auto share_place = [&](std::size_t a, std::size_t b) {
      return std::any_of(places[a].begin(), places[a].end(), [&](const Place& p) { return places[b].contains(p); });
    };
    std::vector<glm::dvec2> lows, highs;
    for (const auto& own : corners) {
      lows.push_back(own[0]);
      highs.push_back(own[0]);
      for (const glm::dvec2& c : own) lows.back() = glm::min(lows.back(), c), highs.back() = glm::max(highs.back(), c);
    }
    const auto boxes_are_near = [&](std::size_t a, std::size_t b) {
      const glm::dvec2 apart = glm::max(lows[a] - highs[b], lows[b] - highs[a]);
      return std::max(apart.x, apart.y) < kChartGutter;
    };
    // Of the polygons that `in` names, those that can be reached from the first through `linked`.
    const auto reached_from = [&](std::size_t first, const std::vector<std::size_t>& in, const auto& linked) {
      std::set<std::size_t> rest(in.begin(), in.end()), reached{first};
      std::vector<std::size_t> open{first};
      while (!open.empty()) {
        const std::size_t from = open.back();
        open.pop_back();
        for (const std::size_t to : std::vector<std::size_t>(rest.begin(), rest.end())) {
          if (!linked(from, to)) continue;
          rest.erase(to);
          reached.insert(to);
          open.push_back(to);
        }
      }
      return reached;
    };
    std::vector<std::set<std::size_t>> across(members.size());
    for (std::size_t m = 0; m < members.size(); ++m) {
      const Polygon& polygon = model.polygons()[members[m]];
      const auto own = model.corners_of(members[m]);
      for (std::size_t k = 0; k < own.size(); ++k) {
        const auto found = edges.find({place_of(model, own[(k + 1) % own.size()]), place_of(model, own[k])});
        const bool is_inside = found != edges.end() && (found->second.size() > 1 || found->second[0] != m);
        wrong_outline += layout.outline[polygon.first_corner + k] == is_inside ? 1 : 0;
        if (is_inside) across[m].insert(found->second.begin(), found->second.end());
      }
    }
    if (members.size() == 1) continue;

    too_long += std::max(group.inner.x, group.inner.y) > max_texels ? 1 : 0;
    const Polygon& first = model.polygons()[members[0]];
    for (const std::uint32_t member : members) {
      const Polygon& polygon = model.polygons()[member];
      const Chart& chart = layout.charts[member];
      strangers += polygon.part != first.part || polygon.is_backdrop ? 1 : 0;
      const double cosine = glm::dot(glm::cross(chart.frame.x_axis, chart.frame.y_axis), polygon.normal);
      steep += cosine < kLeastTinyCosine - 1e-9 ? 1 : 0;
    }
    std::vector<std::size_t> all(members.size());
    for (std::size_t m = 0; m < all.size(); ++m) all[m] = m;
    torn += reached_from(0, all, [&](std::size_t a, std::size_t b) { return across[a].contains(b); }).size() !=
                    members.size()
                ? 1
                : 0;

    // Owners of points, nine in each texel: inside by more than rounding. The middle one is the texel's centre.
    std::map<std::pair<int, int>, std::size_t> owner;
    for (std::size_t m = 0; m < members.size(); ++m) {
      const glm::dvec2 low = lows[m], high = highs[m];
      for (int y = static_cast<int>(3 * low.y); y <= static_cast<int>(3 * high.y); ++y) {
        for (int x = static_cast<int>(3 * low.x); x <= static_cast<int>(3 * high.x); ++x) {
          const glm::dvec2 p((x + 0.5) / 3, (y + 0.5) / 3);
          double inside = 1e300;
          for (std::size_t k = 0; k < corners[m].size(); ++k) {
            const glm::dvec2 edge = corners[m][(k + 1) % corners[m].size()] - corners[m][k];
            const glm::dvec2 to = p - corners[m][k];
            if (glm::length(edge) > 0) inside = std::min(inside, (edge.x * to.y - edge.y * to.x) / glm::length(edge));
          }
          if (inside > 2e-3 && !owner.emplace(std::pair(x, y), m).second) ++overlapping;
        }
      }
    }

    std::vector<std::vector<std::size_t>> near(members.size());
    for (std::size_t a = 0; a < members.size(); ++a)
      for (std::size_t b = 0; b < a; ++b)
        if (boxes_are_near(a, b) &&
            (share_place(a, b) || distance_between(corners[a], corners[b]) < kChartGutter - 1e-9))
          near[a].push_back(b), near[b].push_back(a);
    for (std::size_t a = 0; a < members.size(); ++a) {
      const std::set<std::size_t> reached = reached_from(a, near[a], share_place);
      for (const std::size_t b : near[a]) {
        if (reached.contains(b)) continue;
        std::vector<std::size_t> both = near[a];
        both.insert(both.end(), near[b].begin(), near[b].end());
        slits += reached_from(a, both, share_place).contains(b) ? 0 : 1;
      }
    }
  }
  EXPECT_EQ(strangers, 0U);
  EXPECT_EQ(steep, 0U);
  EXPECT_EQ(torn, 0U) << "groups that are not connected through edges";
  EXPECT_EQ(overlapping, 0U) << "points with two owners";
  EXPECT_EQ(slits, 0U) << "members nearer than the gutter that do not hang together";
  EXPECT_EQ(wrong_outline, 0U);
  EXPECT_EQ(too_long, 0U);
}

}  // namespace foreview
