#include "foreview/scene/chart_layout.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

constexpr int kPageStep = 256;                                   // a page's side shrinks in steps of this
constexpr int kMaxPages = 2048;                                  // layers that GL guarantees for an array texture
constexpr int kLeastInner = kChartAlignment - 2 * kChartGutter;  // lower densities do not make a block smaller

int round_up(int value, int step) {
  return (value + step - 1) / step * step;
}

/// Texels that `extent` spans; what is whole but for rounding stays whole.
int whole_texels(double extent) {
  return std::max(1, static_cast<int>(std::ceil(extent - 1e-6)));
}

std::size_t bytes_of_pages(std::uint32_t pages, int page_size) {
  std::size_t texels = 0;
  for (int level = 0; level < kChartLevels; ++level)
    texels += static_cast<std::size_t>(page_size >> level) * static_cast<std::size_t>(page_size >> level);
  return texels * pages * 4;
}

struct Wish {
  PolygonFrame frame;
  glm::dvec2 density{0, 0};  // texels per metre along each axis
};

/// A chart no longer than `cap` texels along an axis.
void size_chart(const Wish& wish, int cap, Chart& chart) {
  const glm::dvec2 texels = wish.frame.extent * wish.density;
  const double shrink = std::min(1.0, cap / std::max(texels.x, texels.y));
  chart.texels_per_metre = wish.density * shrink;
  chart.inner = {whole_texels(texels.x * shrink), whole_texels(texels.y * shrink)};
  chart.size = {round_up(chart.inner.x + 2 * kChartGutter, kChartAlignment),
                round_up(chart.inner.y + 2 * kChartGutter, kChartAlignment)};
}

/// Shelves: blocks sorted by height, side by side until the page's side is full, then a shelf below. Heights come in
/// steps of kChartAlignment, so that hardly anything is lost above a block.
std::uint32_t pack(std::vector<Chart>& charts, const std::vector<std::uint32_t>& order, int page_size) {
  std::uint32_t page = 0;
  int x = 0;
  int y = 0;
  int shelf = 0;
  for (const std::uint32_t i : order) {
    Chart& chart = charts[i];
    if (x + chart.size.x > page_size) {
      x = 0;
      y += shelf;
      shelf = 0;
    }
    if (y + chart.size.y > page_size) {
      ++page;
      x = y = shelf = 0;
    }
    chart.page = page;
    chart.origin = {x, y};
    x += chart.size.x;
    shelf = std::max(shelf, chart.size.y);
  }
  return page + 1;
}

struct Packing {
  std::uint32_t pages = 0;
  int page_size = 0;
};

/// Packs, big blocks first, into as few pages as there must be, and those no larger than they must be.
Packing pack_tightly(std::vector<Chart>& charts, int page_size) {
  std::vector<std::uint32_t> order(charts.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const glm::ivec2 p = charts[a].size;
    const glm::ivec2 q = charts[b].size;
    return p.y != q.y ? p.y > q.y : p.x > q.x;
  });
  int widest = 0;
  double area = 0;
  for (const Chart& chart : charts) {
    widest = std::max({widest, chart.size.x, chart.size.y});
    area += static_cast<double>(chart.size.x) * chart.size.y;
  }
  const std::uint32_t pages = pack(charts, order, page_size);
  const auto least = static_cast<int>(std::sqrt(area / pages));
  for (int size = round_up(std::max({widest, least, 1}), kPageStep); size < page_size; size += kPageStep)
    if (pack(charts, order, size) <= pages) return {pages, size};
  pack(charts, order, page_size);
  return {pages, page_size};
}

void check_options(const ChartOptions& options) {
  if (!(options.texels_per_metre > 0 && options.texels_per_metre <= 1e7))
    throw InputError("texture density", "is " + std::to_string(options.texels_per_metre) +
                                            ", expected texels per metre above 0, up to 1e7");
  if (options.max_texels < 1 || options.max_texels > 16384)
    throw InputError("largest texture", "is " + std::to_string(options.max_texels) + ", expected 1 to 16384 texels");
  if (options.page_size < 64)
    throw InputError("texture page", "is " + std::to_string(options.page_size) + " texels wide, expected at least 64");
}

/// Area of the polygon and of the polygon grown by the gutter, in texels (Steiner: area + perimeter g + pi g^2).
void add_figures(const PolygonModel& model, std::size_t polygon, const Chart& chart, ChartLayout& layout) {
  const auto corners = model.corners_of(polygon);
  double area = 0;
  double perimeter = 0;
  const glm::dvec2 first = chart.texel_from_part(model.vertices()[corners[0]]);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec2 a = chart.texel_from_part(model.vertices()[corners[i]]) - first;
    const glm::dvec2 b = chart.texel_from_part(model.vertices()[corners[(i + 1) % corners.size()]]) - first;
    area += 0.5 * (a.x * b.y - a.y * b.x);
    perimeter += glm::length(b - a);
  }
  area = std::abs(area);
  layout.useful_texels += area;
  layout.written_texels += area + perimeter * kChartGutter + std::numbers::pi * kChartGutter * kChartGutter;
}

std::string mebibytes(std::size_t bytes) {
  return std::to_string((bytes + (std::size_t{1} << 20) - 1) >> 20) + " MiB";
}

}  // namespace

glm::dvec2 Chart::texel_from_part(const glm::dvec3& p) const {
  return glm::dvec2(origin) + static_cast<double>(kChartGutter) + frame.plane_from_part(p) * texels_per_metre;
}

glm::dvec3 Chart::part_from_texel(const glm::dvec2& texel) const {
  return frame.part_from_plane((texel - glm::dvec2(origin) - static_cast<double>(kChartGutter)) / texels_per_metre);
}

ChartLayout lay_out_charts(const PolygonModel& model, const ChartOptions& options) {
  check_options(options);
  ChartLayout layout;
  const int page_size = options.page_size / kChartAlignment * kChartAlignment;
  const int page_inner = page_size - 2 * kChartGutter;
  const std::size_t count = model.polygons().size();
  layout.charts.resize(count);
  std::vector<Wish> wishes(count);
  int longest = 1;
  std::size_t capped_by_page = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Polygon& polygon = model.polygons()[i];
    Wish& wish = wishes[i];
    wish.frame = polygon_frame(model, i);
    const bool fixed = polygon.texels_per_metre > 0;
    const double density = fixed ? polygon.texels_per_metre : options.texels_per_metre;
    const int cap = fixed ? page_inner : std::min(options.max_texels, page_inner);
    bool is_capped = false;
    for (int axis = 0; axis < 2; ++axis) {
      const double extent = wish.frame.extent[axis];
      const bool too_long = density * extent > cap + 1e-6;
      wish.density[axis] = too_long ? cap / extent : density;
      is_capped = is_capped || too_long;
      longest = std::max(longest, whole_texels(extent * wish.density[axis]));
    }
    layout.polygons_capped += is_capped ? 1 : 0;
    capped_by_page += is_capped && (fixed || options.max_texels > page_inner) ? 1 : 0;
    layout.charts[i].frame = wish.frame;
  }
  if (capped_by_page > 0)
    layout.notes.push_back(std::to_string(capped_by_page) + " textures are held to " + std::to_string(page_inner) +
                           " texels by the page's size of " + std::to_string(page_size));

  const auto try_cap = [&](int cap) {
    for (std::size_t i = 0; i < count; ++i) size_chart(wishes[i], cap, layout.charts[i]);
    const Packing packing = pack_tightly(layout.charts, page_size);
    layout.pages = packing.pages;
    layout.page_size = packing.page_size;
    layout.memory_bytes = bytes_of_pages(packing.pages, packing.page_size);
    return layout.pages <= kMaxPages && layout.memory_bytes <= options.memory_budget;
  };
  if (!try_cap(longest)) {
    const std::size_t wanted = layout.memory_bytes;
    // Only the largest charts are longer than the cap: the smaller keep their density for as long as can be.
    int good = std::min(kLeastInner, longest);
    int bad = longest;
    if (!try_cap(good))
      throw InputError("texture memory", "of " + mebibytes(options.memory_budget) + " does not hold the textures of " +
                                             std::to_string(count) + " polygons, which need " +
                                             mebibytes(layout.memory_bytes) +
                                             " even at the lowest density; allow more, or simplify the model");
    while (bad - good > 1) {
      const int middle = good + (bad - good) / 2;
      (try_cap(middle) ? good : bad) = middle;
    }
    try_cap(good);
    for (std::size_t i = 0; i < count; ++i)
      layout.polygons_lowered += layout.charts[i].texels_per_metre != wishes[i].density ? 1 : 0;
    layout.notes.push_back("the texture budget of " + mebibytes(options.memory_budget) + " is less than the " +
                           mebibytes(wanted) + " wanted: " + std::to_string(layout.polygons_lowered) + " of " +
                           std::to_string(count) + " textures, the largest, are lowered to at most " +
                           std::to_string(good) + " texels along an axis (from up to " + std::to_string(longest) + ")");
  }
  for (std::size_t i = 0; i < count; ++i)
    if (!model.polygons()[i].is_backdrop) add_figures(model, i, layout.charts[i], layout);
  layout.allocated_texels = std::size_t{layout.pages} * static_cast<std::size_t>(layout.page_size) *
                            static_cast<std::size_t>(layout.page_size);
  return layout;
}

}  // namespace foreview
