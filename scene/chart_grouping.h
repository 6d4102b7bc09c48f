#pragma once
#include <cstdint>
#include <vector>

#include "foreview/scene/polygon_model.h"

namespace foreview {

/// Neighbouring polygons that one chart holds: seen along the normal of one plane, none hides another.
struct PolygonGroup {
  std::vector<std::uint32_t> members;  ///< ascending
  PolygonFrame frame;                  ///< of the group's plane; the box holds the projections of all members' corners
};

struct GroupingLimits {
  double texels_per_metre = 0;  ///< what "texels" means below, along both axes of a group's plane
  double max_texels = 0;        ///< longest side of a group's box
  double gutter = 0;            ///< texels that are written beyond a group's outline
  double separation = 0;        ///< texels between members that do not hang together, see group_polygons()
};

/// Cosine of the largest angle between a member's normal and its group's: 45 degrees. A member inclined by that much
/// gets this share of the density along its slope. Larger polygons, which have less to gain, are held to smaller
/// angles: none gives up more texels than a quarter of those that a gutter all round it would cost.
extern const double kLeastGroupCosine;
/// The same for polygons of fewer than 4 texels: alone, each would have a block of 256. 72 degrees.
extern const double kLeastTinyCosine;

/// Partitions the polygons, deterministically (no function is used whose rounding differs between machines); groups in
/// the order of their first members. A polygon whose `may_group` is false stays alone; so does one that fits nowhere.
/// The members of a group
/// - belong to one part and are connected through shared edges (ends at equal places, opposite directions);
/// - show their front to the group's plane, at an angle whose cosine is at least kLeastGroupCosine (tiny ones:
/// kLeastTinyCosine);
/// - do not overlap in projection, up to a thousandth of a texel;
/// - keep apart: two members nearer to each other than `separation` are connected, through shared corners, by members
///   that are nearer than that to one of the two. (In a mesh finer than the separation, many are that near; what must
///   not be is a slit, whose sides would take each other's colours.)
/// The box of a group of several is no longer than max_texels along an axis, and where hundreds of polygons lie within
/// the separation, a group ends, so that the effort stays proportional to the number of polygons.
[[nodiscard]] std::vector<PolygonGroup> group_polygons(const PolygonModel& model, const std::vector<bool>& may_group,
                                                       const GroupingLimits& limits);

/// Equal numbers for corners at equal places of one part, one per entry of model.corners(): neighbours across a cut
/// non-manifold place have vertices of their own.
[[nodiscard]] std::vector<std::uint32_t> places_of_corners(const PolygonModel& model);

/// One per entry of model.corners(): whether no other polygon of the same group has the edge that begins there, in
/// the opposite direction. `group_of` has one entry per polygon.
[[nodiscard]] std::vector<bool> outline_of_groups(const PolygonModel& model,
                                                  const std::vector<std::uint32_t>& group_of);

}  // namespace foreview
