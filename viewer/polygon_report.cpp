#include "foreview/viewer/polygon_report.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <utility>

#include "foreview/gpu/texture_sets.h"

namespace foreview {
namespace {

std::vector<glm::dvec2> corners_in_page(const PolygonModel& model, const ChartLayout& layout, std::uint32_t polygon) {
  std::vector<glm::dvec2> corners;
  for (const std::uint32_t corner : model.corners_of(polygon)) {
    corners.push_back(layout.charts[polygon].texel_from_part(model.vertices()[corner]));
  }
  return corners;
}

/// Where a convex polygon meets the row y; empty (first > last) where it does not.
std::pair<double, double> span_of_row(const std::vector<glm::dvec2>& corners, double y) {
  double first = std::numeric_limits<double>::infinity(), last = -first;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec2 a = corners[i], b = corners[(i + 1) % corners.size()];
    if ((a.y <= y) == (b.y <= y)) continue;
    const double x = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
    first = std::min(first, x);
    last = std::max(last, x);
  }
  return {first, last};
}

}  // namespace

PolygonReport describe_polygon(const PolygonModel& model, const ChartLayout& layout, std::uint32_t polygon) {
  const Polygon& source = model.polygons()[polygon];
  const Chart& chart = layout.charts[polygon];
  PolygonReport report;
  report.polygon = polygon;
  report.part = model.parts()[source.part].name;
  report.corners = source.corner_count;
  glm::dvec3 doubled(0);
  for (std::uint32_t i = 2; i < source.corner_count; ++i) {
    doubled += glm::cross(model.corner(polygon, i - 1) - model.corner(polygon, 0),
                          model.corner(polygon, i) - model.corner(polygon, 0));
  }
  report.area = 0.5 * glm::length(doubled);
  report.is_backdrop = source.is_backdrop;
  report.group = chart.group;
  report.group_polygons = layout.groups[chart.group].member_count;
  report.page = chart.page;
  report.origin = chart.origin;
  report.size = chart.size;
  report.texels_per_metre = chart.texels_per_metre;
  return report;
}

TexelBox texel_box(const PolygonModel& model, const ChartLayout& layout, std::uint32_t polygon) {
  const Chart& chart = layout.charts[polygon];
  glm::dvec2 least(std::numeric_limits<double>::infinity()), greatest = -least;
  for (const glm::dvec2& corner : corners_in_page(model, layout, polygon)) {
    least = glm::min(least, corner);
    greatest = glm::max(greatest, corner);
  }
  const glm::ivec2 end = chart.origin + chart.size;
  const glm::ivec2 first = glm::clamp(glm::ivec2(glm::floor(least)), chart.origin, end - 1);
  const glm::ivec2 last = glm::clamp(glm::ivec2(glm::ceil(greatest)), first + 1, end);
  return {first, last - first};
}

void count_texels(PolygonReport& report, const PolygonModel& model, const ChartLayout& layout, const cv::Mat& texels,
                  const cv::Mat& times, Timestamp epoch) {
  const TexelBox box = texel_box(model, layout, report.polygon);
  assert(texels.type() == CV_8UC4 && texels.cols == box.size.x && texels.rows == box.size.y);
  const std::vector<glm::dvec2> corners = corners_in_page(model, layout, report.polygon);
  const glm::ivec2 first_block = box.first / kChartAlignment;
  cv::Mat touched = cv::Mat::zeros(times.size(), CV_8U);
  std::size_t observed = 0;
  report.texels = 0;
  for (int y = 0; y < texels.rows; ++y) {
    const auto [first, last] = span_of_row(corners, box.first.y + y + 0.5);
    if (first > last) continue;
    const int from = std::max(0, static_cast<int>(std::ceil(first - 0.5)) - box.first.x);
    const int to = std::min(texels.cols - 1, static_cast<int>(std::floor(last - 0.5)) - box.first.x);
    for (int x = from; x <= to; ++x) {
      ++report.texels;
      if (texels.at<cv::Vec4b>(y, x)[3] >= 128) ++observed;
      touched.at<unsigned char>((box.first.y + y) / kChartAlignment - first_block.y,
                                (box.first.x + x) / kChartAlignment - first_block.x) = 1;
    }
  }
  report.observed_share = report.texels > 0 ? static_cast<double>(observed) / static_cast<double>(report.texels) : 0.0;

  std::map<std::int32_t, std::size_t, std::greater<>> blocks;
  std::size_t all = 0;
  for (int y = 0; y < times.rows; ++y) {
    for (int x = 0; x < times.cols; ++x) {
      if (touched.at<unsigned char>(y, x) == 0) continue;
      ++all;
      if (times.at<std::int32_t>(y, x) != kNeverCaptured) ++blocks[times.at<std::int32_t>(y, x)];
    }
  }
  report.captures.clear();
  for (const auto& [time, count] : blocks) {
    if (report.captures.size() == PolygonReport::kMostCaptures) break;
    report.captures.push_back(
        {epoch + Duration{std::int64_t{time} * 1'000'000}, static_cast<double>(count) / static_cast<double>(all)});
  }
}

}  // namespace foreview
