#include "oracle/batched_extraction.h"

#include <algorithm>

namespace foreview::oracle {

BatchedExtractionOracle::BatchedExtractionOracle(const PolygonModel& model, const ChartLayout& layout,
                                                 const BatchedOptions& options)
    : model_(model), layout_(layout), options_(options) {
  for (const ChartGroup& group : layout.groups)
    charts_.push_back({Texture(group.size.x, group.size.y), std::nullopt, std::nullopt});
}

BatchedPicture BatchedExtractionOracle::look(const CameraFrame& frame) const {
  BatchedPicture result;
  result.picture = undistort(frame.picture, frame.camera);
  result.surfaces = surfaces(model_, frame.camera, frame.state, options_.near_plane);
  result.unsafe = AlphaImage(frame.camera.width, frame.camera.height, 0.0);
  if (options_.passes > 0) result.unsafe = spread(rims(result.surfaces), options_.passes);
  result.cells = cells(result.surfaces, options_.passes > 0 ? &result.unsafe : nullptr, result.picture.usable);
  return result;
}

BatchedExtractionOracle::Gathered BatchedExtractionOracle::gather_group(std::size_t group, const CameraFrame& frame,
                                                                        const ColourImage& colour,
                                                                        const Image<Cell>& cells) const {
  Gathered result;
  const ChartGroup& block = layout_.groups[group];
  const auto members = layout_.members_of(block);
  std::vector<PictureSurface> members_surfaces;
  std::vector<bool> front;
  for (const std::uint32_t polygon : members) {
    members_surfaces.push_back(picture_surface(model_, polygon, frame.camera, frame.state, options_.near_plane));
    front.push_back(members_surfaces.back().front);
    result.shown = result.shown || members_surfaces.back().shown;
  }
  result.texels = Image<GatheredTexel>(block.size.x, block.size.y);
  result.owners = texel_owners(model_, layout_, group, front);
  const GatherSource source{&colour, &cells, frame.camera, options_.near_plane};
  for (int y = 0; y < block.size.y; ++y) {
    for (int x = 0; x < block.size.x; ++x) {
      const TexelOwner& owner = result.owners.at(x, y);
      if (owner.polygon < 0) continue;
      const auto polygon = static_cast<std::uint32_t>(owner.polygon);
      const auto member =
          static_cast<std::size_t>(std::lower_bound(members.begin(), members.end(), polygon) - members.begin());
      if (!front[member]) continue;
      const glm::dvec2 texel = glm::dvec2(block.origin) + glm::dvec2(x + 0.5, y + 0.5);
      result.texels.at(x, y) = gather(layout_.charts[polygon], members_surfaces[member], texel, source);
    }
  }
  return result;
}

bool BatchedExtractionOracle::is_late(std::size_t group, Timestamp stamp) const {
  const std::optional<Timestamp>& newest = charts_[group].newest;
  return newest.has_value() && *newest > stamp;
}

void BatchedExtractionOracle::fuse_group(std::size_t group, Timestamp stamp, const Gathered& gathered) {
  ChartState& chart = charts_[group];
  const bool late = is_late(group, stamp);
  for (std::size_t i = 0; i < gathered.texels.values.size(); ++i) {
    const GatheredTexel& texel = gathered.texels.values[i];
    if (!texel.taken || (late && chart.observed.valid.values[i] != 0)) continue;
    chart.observed.valid.values[i] = 1;
    chart.observed.colour.values[i] = texel.colour;
  }
  if (gathered.shown && !late) chart.newest = stamp;
}

std::vector<ColourImage> BatchedExtractionOracle::fill_group(std::size_t group) {
  ChartState& chart = charts_[group];
  const FourthLevel* before = chart.fourth_level.has_value() ? &*chart.fourth_level : nullptr;
  const std::vector<ShareLevel> levels = levels_from(level_of(chart.observed));
  std::vector<ColourImage> result = shown_levels(levels, 4, before);
  chart.fourth_level = FourthLevel{result[4], levels[4].share};
  result.resize(kChartLevels);
  return result;
}

bool BatchedExtractionOracle::any_observed(const Texture& texture) {
  return std::any_of(texture.valid.values.begin(), texture.valid.values.end(), [](unsigned char v) { return v != 0; });
}

}  // namespace foreview::oracle
