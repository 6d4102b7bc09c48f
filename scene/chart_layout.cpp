#include "foreview/scene/chart_layout.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>

#include "foreview/scene/chart_grouping.h"
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

/// A group as it would be without a budget.
struct Wish {
  PolygonFrame frame;
  glm::dvec2 density{0, 0};  // texels per metre along each axis
  bool capped = false;       // by max_texels or the page
  bool capped_by_page = false;
};

/// By how much a group must shrink to be no longer than `cap` texels along an axis.
double shrink_of(const Wish& wish, int cap) {
  const glm::dvec2 texels = wish.frame.extent * wish.density;
  return std::min(1.0, cap / std::max(texels.x, texels.y));
}

void size_group(const Wish& wish, int cap, ChartGroup& group) {
  const glm::dvec2 texels = wish.frame.extent * wish.density * shrink_of(wish, cap);
  group.inner = {whole_texels(texels.x), whole_texels(texels.y)};
  group.size = {round_up(group.inner.x + 2 * kChartGutter, kChartAlignment),
                round_up(group.inner.y + 2 * kChartGutter, kChartAlignment)};
}

/// Shelves: blocks sorted by height, side by side until the page's side is full, then a shelf below. Heights come in
/// steps of kChartAlignment, so that hardly anything is lost above a block.
std::uint32_t pack(std::vector<ChartGroup>& groups, const std::vector<std::uint32_t>& order, int page_size) {
  std::uint32_t page = 0;
  int x = 0;
  int y = 0;
  int shelf = 0;
  for (const std::uint32_t i : order) {
    ChartGroup& group = groups[i];
    if (x + group.size.x > page_size) {
      x = 0;
      y += shelf;
      shelf = 0;
    }
    if (y + group.size.y > page_size) {
      ++page;
      x = y = shelf = 0;
    }
    group.page = page;
    group.origin = {x, y};
    x += group.size.x;
    shelf = std::max(shelf, group.size.y);
  }
  return page + 1;
}

struct Packing {
  std::uint32_t pages = 0;
  int page_size = 0;
};

/// Packs, big blocks first, into as few pages as there must be, and those no larger than they must be.
Packing pack_tightly(std::vector<ChartGroup>& groups, int page_size) {
  std::vector<std::uint32_t> order(groups.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const glm::ivec2 p = groups[a].size;
    const glm::ivec2 q = groups[b].size;
    return p.y != q.y ? p.y > q.y : p.x > q.x;
  });
  int widest = 0;
  double area = 0;
  for (const ChartGroup& group : groups) {
    widest = std::max({widest, group.size.x, group.size.y});
    area += static_cast<double>(group.size.x) * group.size.y;
  }
  const std::uint32_t pages = pack(groups, order, page_size);
  const auto least = static_cast<int>(std::sqrt(area / pages));
  for (int size = round_up(std::max({widest, least, 1}), kPageStep); size < page_size; size += kPageStep)
    if (pack(groups, order, size) <= pages) return {pages, size};
  pack(groups, order, page_size);
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

/// Areas of the groups, and of the groups grown by the gutter, in texels: area + length of the outline g + pi g^2,
/// which is exact where the outline is convex (Steiner), and too much by the corners that turn inwards elsewhere.
void add_figures(const PolygonModel& model, ChartLayout& layout) {
  for (const ChartGroup& group : layout.groups) {
    if (model.polygons()[layout.members[group.first_member]].is_backdrop) continue;
    double area = 0;
    double outline = 0;
    for (const std::uint32_t polygon : layout.members_of(group)) {
      const Chart& chart = layout.charts[polygon];
      const auto corners = model.corners_of(polygon);
      const glm::dvec2 first = chart.texel_from_part(model.vertices()[corners[0]]);
      double own_area = 0;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec2 a = chart.texel_from_part(model.vertices()[corners[i]]) - first;
        const glm::dvec2 b = chart.texel_from_part(model.vertices()[corners[(i + 1) % corners.size()]]) - first;
        own_area += 0.5 * (a.x * b.y - a.y * b.x);
        if (layout.outline[model.polygons()[polygon].first_corner + i]) outline += glm::length(b - a);
      }
      area += std::abs(own_area);
    }
    layout.useful_texels += area;
    layout.written_texels += area + outline * kChartGutter + std::numbers::pi * kChartGutter * kChartGutter;
  }
}

std::string mebibytes(std::size_t bytes) {
  return std::to_string((bytes + (std::size_t{1} << 20) - 1) >> 20) + " MiB";
}

}  // namespace

glm::dvec2 Chart::texel_from_part(const glm::dvec3& p) const {
  return glm::dvec2(origin) + static_cast<double>(kChartGutter) + frame.plane_from_part(p) * texels_per_metre;
}

glm::dvec3 Chart::part_from_texel(const glm::dvec2& texel) const {
  const glm::dvec3 p =
      frame.part_from_plane((texel - glm::dvec2(origin) - static_cast<double>(kChartGutter)) / texels_per_metre);
  const glm::dvec3 along = glm::cross(frame.x_axis, frame.y_axis);
  return p + (offset - glm::dot(normal, p)) / glm::dot(normal, along) * along;
}

namespace {

/// Groups, places in the pages and densities, for one model and its options.
class Layouter {
 public:
  Layouter(const PolygonModel& model, const ChartOptions& options);
  ChartLayout lay_out();

 private:
  void group(double separation);
  bool try_cap(int cap);
  void meet_budget();

  const PolygonModel& model_;
  const ChartOptions& options_;
  int page_size_, page_inner_;
  std::vector<PolygonGroup> members_;
  std::vector<Wish> wishes_;
  int longest_ = 1;         // texels, of all groups
  int longest_shared_ = 1;  // texels, of those with several members
  int cap_ = 1;
  ChartLayout layout_;
};

Layouter::Layouter(const PolygonModel& model, const ChartOptions& options)
    : model_(model),
      options_(options),
      page_size_(options.page_size / kChartAlignment * kChartAlignment),
      page_inner_(page_size_ - 2 * kChartGutter) {}

/// Members of a group that do not hang together stay `separation` texels apart.
void Layouter::group(double separation) {
  const std::size_t count = model_.polygons().size();
  const double max_texels = std::min(options_.max_texels, page_inner_);
  std::vector<bool> may_group(count, options_.group_polygons);
  for (std::size_t i = 0; i < count; ++i)
    if (model_.polygons()[i].is_backdrop || model_.polygons()[i].texels_per_metre > 0) may_group[i] = false;
  members_ = group_polygons(model_, may_group, {options_.texels_per_metre, max_texels, kChartGutter, separation});

  wishes_.clear();
  longest_ = longest_shared_ = 1;
  for (const PolygonGroup& group : members_) {
    const Polygon& polygon = model_.polygons()[group.members[0]];
    Wish& wish = wishes_.emplace_back();
    wish.frame = group.frame;
    const bool fixed = polygon.texels_per_metre > 0;
    const double density = fixed ? polygon.texels_per_metre : options_.texels_per_metre;
    const int cap = fixed ? page_inner_ : std::min(options_.max_texels, page_inner_);
    for (int axis = 0; axis < 2; ++axis) {
      const double extent = wish.frame.extent[axis];
      const bool too_long = density * extent > cap + 1e-6;
      wish.density[axis] = too_long ? cap / extent : density;
      wish.capped = wish.capped || too_long;
      const int texels = whole_texels(extent * wish.density[axis]);
      longest_ = std::max(longest_, texels);
      if (group.members.size() > 1) longest_shared_ = std::max(longest_shared_, texels);
    }
    wish.capped_by_page = wish.capped && (fixed || options_.max_texels > page_inner_);
  }
  layout_.groups.assign(members_.size(), {});
}

bool Layouter::try_cap(int cap) {
  for (std::size_t i = 0; i < wishes_.size(); ++i) size_group(wishes_[i], cap, layout_.groups[i]);
  const Packing packing = pack_tightly(layout_.groups, page_size_);
  layout_.pages = packing.pages;
  layout_.page_size = packing.page_size;
  layout_.memory_bytes = bytes_of_pages(packing.pages, packing.page_size);
  cap_ = cap;
  return layout_.pages <= kMaxPages && layout_.memory_bytes <= options_.memory_budget;
}

/// Only the largest groups are longer than the cap: the smaller keep their density for as long as can be. A group that
/// shrinks brings its members nearer to each other, so that groups are made anew, with more between their members, for
/// each halving of the cap.
void Layouter::meet_budget() {
  const std::size_t wanted = layout_.memory_bytes;
  const int wanted_length = longest_;
  int bad = longest_;
  for (double separation = 2.0 * kChartGutter;; separation *= 2) {
    if (longest_shared_ > kLeastInner) group(separation);
    const auto least_shared = static_cast<int>(std::ceil(longest_shared_ * kChartGutter / separation));
    const int least = std::min(std::max(least_shared, kLeastInner), longest_);
    bad = std::max(bad, least);
    if (try_cap(least)) {
      int good = least;
      bad = std::min(bad, longest_);
      while (bad - good > 1) {
        const int middle = good + (bad - good) / 2;
        (try_cap(middle) ? good : bad) = middle;
      }
      try_cap(good);
      break;
    }
    if (least <= kLeastInner)
      throw InputError("texture memory", "of " + mebibytes(options_.memory_budget) + " does not hold the textures of " +
                                             std::to_string(model_.polygons().size()) + " polygons, which need " +
                                             mebibytes(layout_.memory_bytes) +
                                             " even at the lowest density; allow more, or simplify the model");
    bad = least;
  }
  std::size_t lowered = 0;
  for (std::size_t i = 0; i < wishes_.size(); ++i) {
    if (shrink_of(wishes_[i], cap_) >= 1) continue;
    ++lowered;
    layout_.polygons_lowered += members_[i].members.size();
  }
  layout_.notes.push_back("the texture budget of " + mebibytes(options_.memory_budget) + " is less than the " +
                          mebibytes(wanted) + " wanted: " + std::to_string(lowered) + " of " +
                          std::to_string(wishes_.size()) + " textures, the largest, are lowered to at most " +
                          std::to_string(cap_) + " texels along an axis (from up to " + std::to_string(wanted_length) +
                          ")");
}

ChartLayout Layouter::lay_out() {
  group(kChartGutter);
  std::size_t capped_by_page = 0;
  for (const Wish& wish : wishes_) capped_by_page += wish.capped_by_page ? 1 : 0;
  if (capped_by_page > 0)
    layout_.notes.push_back(std::to_string(capped_by_page) + " textures are held to " + std::to_string(page_inner_) +
                            " texels by the page's size of " + std::to_string(page_size_));
  if (!try_cap(longest_)) meet_budget();

  layout_.charts.resize(model_.polygons().size());
  std::vector<std::uint32_t> group_of(model_.polygons().size());
  for (std::uint32_t i = 0; i < members_.size(); ++i) {
    ChartGroup& group = layout_.groups[i];
    group.first_member = static_cast<std::uint32_t>(layout_.members.size());
    group.member_count = static_cast<std::uint32_t>(members_[i].members.size());
    layout_.polygons_capped += wishes_[i].capped ? group.member_count : 0;
    for (const std::uint32_t polygon : members_[i].members) {
      layout_.members.push_back(polygon);
      group_of[polygon] = i;
      const Polygon& own = model_.polygons()[polygon];
      layout_.charts[polygon] = {i,          group.page,  group.origin,
                                 group.size, group.inner, wishes_[i].frame,
                                 own.normal, own.offset,  wishes_[i].density * shrink_of(wishes_[i], cap_)};
    }
  }
  layout_.outline = outline_of_groups(model_, group_of);
  add_figures(model_, layout_);
  layout_.allocated_texels = std::size_t{layout_.pages} * static_cast<std::size_t>(layout_.page_size) *
                             static_cast<std::size_t>(layout_.page_size);
  return std::move(layout_);
}

}  // namespace

ChartLayout lay_out_charts(const PolygonModel& model, const ChartOptions& options) {
  check_options(options);
  return Layouter(model, options).lay_out();
}

}  // namespace foreview
