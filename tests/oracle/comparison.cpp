#include "oracle/comparison.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

namespace foreview::oracle {
namespace {

constexpr std::size_t kNotesKept = 12;
constexpr double kAlphaRounding = 1e-3;  // 31/32 may be kept in eight bits

AlphaImage alpha_of(const cv::Mat& gl) {
  AlphaImage result(gl.cols, gl.rows);
  for (int y = 0; y < gl.rows; ++y) {
    for (int x = 0; x < gl.cols; ++x) {
      const double a = gl.at<float>(y, x);
      result.at(x, y) = std::abs(a - kOutside) < kAlphaRounding ? kOutside : a;
    }
  }
  return result;
}

float largest_difference(const glm::dvec3& a, const glm::dvec3& b) {
  return static_cast<float>(std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)}));
}

float percentile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

glm::dvec3 colour(const cv::Vec4b& bgra) {
  return {bgra[0], bgra[1], bgra[2]};
}

}  // namespace

Options oracle_options(const ExtractionOptions& extraction, const ChartOptions& charts) {
  Options options;
  switch (extraction.artefacts) {
    case ArtefactSuppression::none:
      options.suppression = Suppression::none;
      break;
    case ArtefactSuppression::diamond:
      options.suppression = Suppression::diamond;
      break;
    case ArtefactSuppression::alternating:
      options.suppression = Suppression::alternating;
      break;
    case ArtefactSuppression::progressive:
      options.suppression = Suppression::progressive;
      break;
  }
  switch (extraction.fill) {
    case HoleFilling::none:
      options.fill = Filling::none;
      break;
    case HoleFilling::pyramid:
      options.fill = Filling::pyramid;
      break;
    case HoleFilling::iterative:
      options.fill = Filling::iterative;
      break;
  }
  options.passes = extraction.passes;
  options.alpha_c = extraction.alpha_c;
  options.small_texture = extraction.small_texture;
  options.near_plane = extraction.near_plane;
  options.texels_per_metre = charts.texels_per_metre;
  options.max_texels = charts.max_texels;
  return options;
}

Texture texture_of(const cv::Mat& bgra) {
  Texture texture(bgra.cols, bgra.rows);
  for (int y = 0; y < bgra.rows; ++y) {
    for (int x = 0; x < bgra.cols; ++x) {
      const auto& t = bgra.at<cv::Vec4b>(y, x);
      texture.colour.at(x, y) = colour(t);
      texture.valid.at(x, y) = t[3] == 255 ? 1 : 0;
    }
  }
  return texture;
}

Comparison::Comparison(const PolygonModel& model, const ExtractionOptions& extraction, const ChartOptions& charts)
    : model_(model), options_(oracle_options(extraction, charts)), oracle_(model, options_) {}

void Comparison::note(const std::string& step, std::size_t polygon, int x, int y, double gl, double expected) {
  ++wrong_;
  if (notes_.size() >= kNotesKept) return;
  notes_.push_back(step + ", polygon " + std::to_string(polygon) + " at (" + std::to_string(x) + ", " +
                   std::to_string(y) + "): " + std::to_string(gl) + " instead of " + std::to_string(expected));
}

void Comparison::add_undistorted(const cv::Mat& gl, const PreparedFrame& frame) {
  const UndistortedPicture& expected = frame.picture;
  ASSERT_EQ(gl.cols, expected.colour.width);
  ASSERT_EQ(gl.rows, expected.colour.height);
  for (int y = 0; y < gl.rows; ++y) {
    for (int x = 0; x < gl.cols; ++x) {
      const auto& t = gl.at<cv::Vec4b>(y, x);
      ++decisions_;
      if (expected.doubtful.at(x, y) != 0) {
        ++doubtful_;
        continue;
      }
      if ((t[3] == 255) != (expected.usable.at(x, y) != 0))
        note("undistorted", 0, x, y, t[3], expected.usable.at(x, y));
      if (t[3] == 255 && expected.usable.at(x, y) != 0) {
        undistorted_differences_.push_back(largest_difference(colour(t), expected.colour.at(x, y)));
      }
    }
  }
}

void Comparison::compare_masks(const PerPolygonExtraction::Intermediate& gl, const PolygonResult& expected,
                               std::size_t polygon) {
  const AlphaImage before = alpha_of(gl.box_alpha_before), after = alpha_of(gl.box_alpha_after);
  const AlphaImage after_of_this = expected.exempt_small ? before : suppress(before, options_);
  for (int y = 0; y < before.height; ++y) {
    for (int x = 0; x < before.width; ++x) {
      const double low = expected.before.low.at(x, y), high = expected.before.high.at(x, y);
      const double alpha = before.at(x, y);
      ++decisions_;
      if (low != high) ++doubtful_;
      if (alpha < low - kAlphaRounding || alpha > high + kAlphaRounding) {
        note("occlusion", polygon, x + gl.box_x, y + gl.box_y, alpha, expected.before.alpha.at(x, y));
      }
      mask_before_.add(alpha > kOutside, expected.before.alpha.at(x, y) > kOutside);
      mask_after_.add(after.at(x, y) > kOutside, expected.after.alpha.at(x, y) > kOutside);
      if (std::abs(after.at(x, y) - after_of_this.at(x, y)) > kAlphaRounding) {
        note("suppression", polygon, x + gl.box_x, y + gl.box_y, after.at(x, y), after_of_this.at(x, y));
      }
    }
  }
}

void Comparison::compare_fused(const PerPolygonExtraction::Intermediate& gl, const NormalisedTexture& fresh,
                               std::size_t polygon, const std::optional<Texture>& before, bool late) {
  const Texture fused = texture_of(gl.fused);
  for (int y = 0; y < fused.height(); ++y) {
    for (int x = 0; x < fused.width(); ++x) {
      const bool was_valid = before.has_value() && before->valid.at(x, y) != 0;
      const bool surely = fresh.surely_valid.at(x, y) != 0, possibly = fresh.possibly_valid.at(x, y) != 0;
      const bool valid = fused.valid.at(x, y) != 0;
      ++decisions_;
      if (surely != possibly) ++doubtful_;
      texels_.add(valid, was_valid || fresh.texture.valid.at(x, y) != 0);
      if ((valid && !possibly && !was_valid) || (!valid && (surely || was_valid))) {
        note("normalisation", polygon, x, y, valid ? 1 : 0, valid ? 0 : 1);
        continue;
      }
      if (!valid || surely != possibly) continue;
      const bool from_before = was_valid && (late || !surely);
      if (!from_before && fresh.colour_doubtful.at(x, y) != 0) continue;
      const glm::dvec3& expected = from_before ? before->colour.at(x, y) : fresh.texture.colour.at(x, y);
      fused_differences_.push_back(largest_difference(fused.colour.at(x, y), expected));
    }
  }
}

void Comparison::compare_filled(const PerPolygonExtraction::Intermediate& gl, std::size_t polygon) {
  const Texture fused = texture_of(gl.fused);
  const ColourImage expected = fill(fused, options_.fill, open_holes(model_, polygon, fused));
  for (int y = 0; y < fused.height(); ++y) {
    for (int x = 0; x < fused.width(); ++x) {
      const auto& t = gl.filled.at<cv::Vec4b>(y, x);
      const float difference = largest_difference(colour(t), expected.at(x, y));
      filled_differences_.push_back(difference);
      if (fused.valid.at(x, y) != 0 && difference > 0)
        note("filling a valid texel", polygon, x, y, t[0], expected.at(x, y).x);
      if ((t[3] == 255) != (fused.valid.at(x, y) != 0))
        note("validity after filling", polygon, x, y, t[3], fused.valid.at(x, y));
    }
  }
}

void Comparison::add_polygon(const PerPolygonExtraction::Intermediate& gl, const PreparedFrame& frame,
                             std::size_t polygon, const std::optional<Texture>& before, bool late) {
  const PolygonResult expected = oracle_.inspect(frame, polygon);
  ASSERT_EQ(expected.skip, Skip::none) << "polygon " << polygon;
  const Box& box = expected.projected.grown_box;
  ASSERT_EQ(gl.box_x, box.left) << "polygon " << polygon;
  ASSERT_EQ(gl.box_y, box.top) << "polygon " << polygon;
  ASSERT_EQ(gl.box_alpha_before.cols, box.width()) << "polygon " << polygon;
  ASSERT_EQ(gl.box_alpha_before.rows, box.height()) << "polygon " << polygon;
  ASSERT_EQ(gl.box_alpha_before.size(), gl.box_alpha_after.size()) << "polygon " << polygon;
  ASSERT_EQ(gl.box_alpha_before.type(), CV_32F);
  ASSERT_EQ(gl.box_alpha_after.type(), CV_32F);
  ASSERT_EQ(gl.fused.cols, expected.fused.width()) << "polygon " << polygon;
  ASSERT_EQ(gl.fused.rows, expected.fused.height()) << "polygon " << polygon;
  ASSERT_EQ(gl.fused.size(), gl.filled.size()) << "polygon " << polygon;
  ++polygons_;
  compare_masks(gl, expected, polygon);

  Mask mask;
  mask.alpha = alpha_of(gl.box_alpha_after);
  mask.low = mask.high = mask.alpha;
  const PolygonFrame plane = polygon_frame(model_, polygon);
  const NormalisedTexture fresh = normalise(model_, polygon, plane, {gl.fused.cols, gl.fused.rows}, expected.projected,
                                            mask, frame.picture, frame.frame->state, options_.near_plane);
  compare_fused(gl, fresh, polygon, before, late);
  compare_filled(gl, polygon);
}

void Comparison::add_chart(const cv::Mat& page, const Chart& chart, std::size_t polygon,
                           const PerPolygonExtraction::Intermediate& gl) {
  const Texture fused = texture_of(gl.fused);
  const ChartBlock expected = copy_to_chart(chart, polygon_frame(model_, polygon), fused, texture_of(gl.filled).colour);
  for (int y = 0; y < chart.size.y; ++y) {
    for (int x = 0; x < chart.size.x; ++x) {
      const auto& t = page.at<cv::Vec4b>(chart.origin.y + y, chart.origin.x + x);
      chart_differences_.push_back(largest_difference(colour(t), expected.colour.at(x, y)));
      ++decisions_;
      if (expected.doubtful.at(x, y) != 0) {
        ++doubtful_;
      } else if ((t[3] == 255) != (expected.observed.at(x, y) != 0) || (t[3] != 0 && t[3] != 255)) {
        note("chart's provenance", polygon, x, y, t[3], expected.observed.at(x, y) * 255);
      }
    }
  }
}

double Comparison::doubtful_share() const {
  return decisions_ == 0 ? 1.0 : static_cast<double>(doubtful_) / static_cast<double>(decisions_);
}

void Comparison::expect_agreement(const std::string& what) const {
  const auto figures = [](const std::vector<float>& differences) {
    return std::to_string(percentile(differences, 0.999)) + " (99.9 %), " + std::to_string(percentile(differences, 1)) +
           " (maximum)";
  };
  std::cout << what << ": " << polygons_ << " polygons, " << decisions_ << " decisions, " << 100 * doubtful_share()
            << " % left to rounding, " << wrong_ << " wrong; intersection over union " << mask_before_.ratio()
            << " before suppression, " << mask_after_.ratio() << " after, texels " << texels_.ratio()
            << "; differences in 1/255: undistorted " << figures(undistorted_differences_) << ", fused "
            << figures(fused_differences_) << ", filled " << figures(filled_differences_) << ", chart "
            << figures(chart_differences_) << '\n';
  EXPECT_EQ(wrong_, 0u) << what;
  for (const std::string& line : notes_) ADD_FAILURE() << line;
  EXPECT_GE(mask_before_.ratio(), 0.99);
  EXPECT_GE(mask_after_.ratio(), 0.99);
  EXPECT_GE(texels_.ratio(), 0.99);
  EXPECT_LT(doubtful_share(), 0.02);
  EXPECT_LE(percentile(undistorted_differences_, 0.999), 2);
  EXPECT_LE(percentile(fused_differences_, 0.999), 2);
  EXPECT_LE(percentile(filled_differences_, 0.999), 3);
  EXPECT_LE(percentile(chart_differences_, 0.999), 2);
}

}  // namespace foreview::oracle
