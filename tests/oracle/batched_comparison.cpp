#include "oracle/batched_comparison.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <iomanip>
#include <iostream>
#include <limits>
#include <sstream>

#include "oracle/comparison.h"

namespace foreview::oracle {
namespace {

constexpr std::size_t kNotesKept = 12;

float largest_difference(const glm::dvec3& a, const glm::dvec3& b) {
  return static_cast<float>(std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)}));
}

float relative_difference(double a, double b) {
  return static_cast<float>(std::abs(a - b) / std::max(std::abs(b), 1e-12));
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

ShareLevel level_of_bgra(const cv::Mat& bgra) {
  ShareLevel result(bgra.cols, bgra.rows);
  for (int y = 0; y < bgra.rows; ++y) {
    for (int x = 0; x < bgra.cols; ++x) {
      const auto& t = bgra.at<cv::Vec4b>(y, x);
      result.colour.at(x, y) = colour(t);
      result.share.at(x, y) = t[3] / 255.0;
    }
  }
  return result;
}

ColourImage colours_of(const cv::Mat& bgra) {
  return level_of_bgra(bgra).colour;
}

std::vector<cv::Mat> read_level(const TextureStore& store, int level) {
  const int size = store.layout().page_size >> level;
  std::vector<cv::Mat> pages;
  for (std::uint32_t page = 0; page < store.layout().pages; ++page) {
    cv::Mat& picture = pages.emplace_back(size, size, CV_8UC4);
    glGetTextureSubImage(store.pages(), level, 0, 0, static_cast<GLint>(page), size, size, 1, GL_BGRA, GL_UNSIGNED_BYTE,
                         size * size * 4, picture.data);
  }
  return pages;
}

BatchedOptions batched_options(const ExtractionOptions& options) {
  BatchedOptions result;
  result.passes = options.artefacts == ArtefactSuppression::none ? 0 : options.passes;
  result.near_plane = options.near_plane;
  return result;
}

}  // namespace

/// An own texel that the picture could show.
struct BatchedComparison::Verdict {
  glm::dvec2 pixel{0};
  double w = 0, reach = 0, step = 0;
  std::size_t group = 0;
  int x = 0, y = 0;
  bool gl = false, oracle = false;  ///< observed
  bool is_new = false;              ///< they differ since this picture
};

BatchedComparison::BatchedComparison(const PolygonModel& model, TextureStore& store, BatchedExtraction& gl,
                                     const ExtractionOptions& options, BatchedFigures& figures)
    : figures_(figures), store_(store), gl_(gl), oracle_(model, store.layout(), batched_options(options)) {
  suppressing_ = batched_options(options).passes > 0;
  shown_.resize(kChartLevels);
  pulled_.resize(kChartLevels);
  for (const ChartGroup& group : store.layout().groups) {
    in_picture_.emplace_back(group.size.x, group.size.y);
    differed_.emplace_back(group.size.x, group.size.y);
    seen_.push_back(0);
    fourth_before_.push_back({ColourImage(group.size.x >> 4, group.size.y >> 4, glm::dvec3(0)),
                              AlphaImage(group.size.x >> 4, group.size.y >> 4, 0.0)});
  }
  for (std::size_t level = 0; level < kChartLevels; ++level) {
    shown_[level] = read_level(store, static_cast<int>(level));
  }
}

void BatchedComparison::note(const std::string& text) {
  if (figures_.notes.size() < kNotesKept)
    figures_.notes.push_back("picture " + std::to_string(figures_.pictures) + ": " + text);
}

cv::Mat BatchedComparison::block(const std::vector<cv::Mat>& pages, std::size_t group, int level) const {
  const ChartGroup& g = store_.layout().groups[group];
  return pages[g.page](cv::Rect(g.origin.x >> level, g.origin.y >> level, g.size.x >> level, g.size.y >> level));
}

void BatchedComparison::compare_picture(const BatchedPicture& oracle, const BatchedExtraction::Intermediate& gl) {
  const int width = oracle.surfaces.width, height = oracle.surfaces.height;
  ASSERT_EQ(gl.surfaces.size(), cv::Size(width, height));
  ASSERT_EQ(gl.cells.size(), cv::Size(width - 1, height - 1));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Surface& s = oracle.surfaces.at(x, y);
      const auto& t = gl.surfaces.at<cv::Vec3f>(y, x);
      ++figures_.pixels;
      if (!s.doubtful) {
        ++figures_.pixels_judged;
        const double slope = std::abs(s.a) + std::abs(s.b);
        if (s.polygon >= 0) {
          figures_.w.push_back(relative_difference(t[0], s.w));
          figures_.slopes.push_back(
              static_cast<float>((std::abs(t[1] - s.a) + std::abs(t[2] - s.b)) / std::max(slope, 1e-6)));
        }
        const bool wrong =
            s.polygon < 0 ? t != cv::Vec3f(0, 0, 0) : relative_difference(t[0], s.w) > 1e-4 + 0.02 * slope / s.w;
        if (wrong) {
          ++figures_.wrong_surfaces;
          note("surface at (" + std::to_string(x) + ", " + std::to_string(y) + "), polygon " +
               std::to_string(s.polygon) + ": w " + std::to_string(t[0]) + " instead of " + std::to_string(s.w));
        }
      }
      if (suppressing_) {
        const double expected = oracle.unsafe.at(x, y), found = gl.unsafe.at<float>(y, x);
        if (relative_difference(found, expected) < 0.01) {
          figures_.unsafe.push_back(relative_difference(found, expected));
        } else if (found != 0 || expected != 0) {
          ++figures_.wrong_unsafe;
        }
      }
      if (x + 1 == width || y + 1 == height) continue;
      const Cell& cell = oracle.cells.at(x, y);
      const auto& found = gl.cells.at<cv::Vec2f>(y, x);
      ++figures_.cells;
      const bool found_none = found[0] > found[1], found_none_thin = found[0] > std::abs(found[1]);
      if (!cell.takes_nothing(false)) ++figures_.open_cells;
      if (cell.takes_nothing(false) != found_none || cell.takes_nothing(true) != found_none_thin) {
        ++figures_.wrong_cells;
      } else if (!cell.takes_nothing(true)) {
        figures_.cell_bounds.push_back(std::max(relative_difference(found[0], cell.least),
                                                relative_difference(std::abs(found[1]), cell.greatest)));
      }
    }
  }
}

void BatchedComparison::compare_texels(const CameraFrame& frame, const BatchedPicture& picture,
                                       const BatchedExtraction::Intermediate& gl) {
  Image<Cell> gl_cells(gl.cells.cols, gl.cells.rows);
  for (int y = 0; y < gl_cells.height; ++y) {
    for (int x = 0; x < gl_cells.width; ++x) {
      const auto& c = gl.cells.at<cv::Vec2f>(y, x);
      gl_cells.at(x, y) = {c[0], std::abs(c[1]), c[1] < 0};
    }
  }
  const ColourImage gl_picture = colours_of(gl.undistorted);
  std::vector<Verdict> verdicts;
  SetOverlap invalid, valid;
  owners_.clear();
  const std::vector<cv::Mat> before = shown_[0];
  for (int level = 0; level < kChartLevels; ++level) {
    shown_[static_cast<std::size_t>(level)] = read_level(store_, level);
    if (level > 0) pulled_[static_cast<std::size_t>(level)] = gl_.pulled(level);
  }
  for (std::size_t g = 0; g < store_.layout().groups.size(); ++g) {
    const auto expected = oracle_.gather_group(g, frame, picture.picture.colour, picture.cells);
    const auto step = oracle_.gather_group(g, frame, gl_picture, gl_cells);
    const cv::Mat now = block(shown_[0], g, 0), then = block(before, g, 0);
    const bool is_late = oracle_.is_late(g, frame.state.stamp);
    oracle_.fuse_group(g, frame.state.stamp, expected);
    const Texture& observed = oracle_.observed(g);
    for (int y = 0; y < now.rows; ++y) {
      for (int x = 0; x < now.cols; ++x) {
        const TexelOwner& owner = expected.owners.at(x, y);
        const auto& found = now.at<cv::Vec4b>(y, x);
        const bool has = found[3] == 255, has_oracle = observed.valid.at(x, y) != 0;
        if (found[3] != 0 && found[3] != 255) ++figures_.wrong_alphas;
        if (owner.polygon < 0) {
          if (has && then.at<cv::Vec4b>(y, x)[3] == 0) {
            ++figures_.wrong_alphas;
            note("a texel that belongs to nothing is observed, group " + std::to_string(g) + " at (" +
                 std::to_string(x) + ", " + std::to_string(y) + ")");
          }
          continue;
        }
        if (!owner.inside) {
          if (has && has_oracle) ++figures_.gutter_both;
          if (has && !has_oracle) ++figures_.gutter_gl;
          if (!has && has_oracle) ++figures_.gutter_oracle;
          continue;
        }
        const GatheredTexel& texel = expected.texels.at(x, y);
        // As a step: what GL held, and what GL's cells give.
        const GatheredTexel& given = step.texels.at(x, y);
        const auto& held = then.at<cv::Vec4b>(y, x);
        const bool takes = given.taken && !(is_late && held[3] == 255);
        if (given.in_picture) ++figures_.step_texels;
        if (has != (takes || held[3] == 255)) ++figures_.wrong_step_texels;
        if (has && takes) figures_.step_colours.push_back(largest_difference(colour(found), given.colour));
        if (has && !takes && held[3] == 255) {
          figures_.step_colours.push_back(largest_difference(colour(found), colour(held)));
        }
        // As a whole.
        if (texel.in_picture) in_picture_[g].at(x, y) = 1;
        if (in_picture_[g].at(x, y) == 0) {
          if (has || has_oracle) {
            ++figures_.wrong_alphas;
            note("a texel outside all pictures is observed, group " + std::to_string(g) + " at (" + std::to_string(x) +
                 ", " + std::to_string(y) + ")");
          }
          continue;
        }
        ++figures_.texels;
        invalid.add(!has, !has_oracle);
        valid.add(has, has_oracle);
        if (has && has_oracle) figures_.colours.push_back(largest_difference(colour(found), observed.colour.at(x, y)));
        const bool differs = has != has_oracle;
        if (texel.in_picture) {
          verdicts.push_back({texel.pixel, texel.w, texel.reach, texel.step, g, x, y, has, has_oracle,
                              differs && differed_[g].at(x, y) == 0});
        }
        differed_[g].at(x, y) = differs ? 1 : 0;
      }
    }
    owners_.push_back(expected.owners);
  }
  figures_.invalid_overlaps.push_back(invalid.ratio());
  figures_.valid_overlaps.push_back(valid.ratio());
  compare_contours(verdicts, frame.camera.width, frame.camera.height);
}

void BatchedComparison::compare_contours(const std::vector<Verdict>& verdicts, int width, int height) {
  Image<std::vector<std::uint32_t>> at_pixel(width, height);
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    const glm::dvec2& p = verdicts[i].pixel;
    if (p.x >= 0 && p.y >= 0 && p.x < width && p.y < height) {
      at_pixel.at(static_cast<int>(p.x), static_cast<int>(p.y)).push_back(static_cast<std::uint32_t>(i));
    }
  }
  for (const Verdict& v : verdicts) {
    if (!v.is_new) continue;
    ++figures_.differing;
    // A pixel, and a texel: sets of texels follow a contour no closer.
    const double allowed = 1 + v.step;
    const int reach = static_cast<int>(std::ceil(allowed)) + 1;
    const int px = static_cast<int>(std::floor(v.pixel.x)), py = static_cast<int>(std::floor(v.pixel.y));
    double contour = std::numeric_limits<double>::infinity(), island = contour;
    for (int y = std::max(py - reach, 0); y <= std::min(py + reach, height - 1); ++y) {
      for (int x = std::max(px - reach, 0); x <= std::min(px + reach, width - 1); ++x) {
        for (const std::uint32_t i : at_pixel.at(x, y)) {
          const Verdict& other = verdicts[i];
          const bool same_surface =
              std::abs(other.w - v.w) <= kBatchedGap * v.w + allowed * std::max(v.reach, other.reach);
          if (!same_surface) continue;
          // Cells are squares: along rows or columns.
          const glm::dvec2 apart = glm::abs(other.pixel - v.pixel);
          const double distance = std::max(apart.x, apart.y);
          if (other.oracle == v.gl) contour = std::min(contour, distance);
          if (other.gl == v.oracle) island = std::min(island, distance);
        }
      }
    }
    if (contour <= allowed) {
      figures_.farthest = std::max(figures_.farthest, contour);
      continue;
    }
    if (island <= allowed) {
      ++figures_.beyond_islands;
      continue;
    }
    ++figures_.beyond_contour;
    std::ostringstream text;
    text << "group " << v.group << " at (" << v.x << ", " << v.y << "), pixel (" << v.pixel.x << ", " << v.pixel.y
         << "), w " << v.w << ": " << (v.gl ? "observed" : "not observed")
         << ", unlike the oracle; the oracle's contour is " << contour << " pixels away";
    note(text.str());
  }
}

void BatchedComparison::compare_fill(std::size_t group) {
  const Texture& observed = oracle_.observed(group);
  const Texture found = texture_of(block(shown_[0], group, 0));
  const bool any = BatchedExtractionOracle::any_observed(found);
  if (any != BatchedExtractionOracle::any_observed(observed)) ++figures_.charts_seen_by_one;
  seen_[group] = any ? 1 : 0;
  if (!any) return;
  // Pull, step by step.
  std::vector<ShareLevel> levels{level_of(found)};
  for (int k = 1; k < kChartLevels; ++k) {
    const ShareLevel expected = pull_by_share(levels.back());
    const ShareLevel gl = level_of_bgra(block(pulled_[static_cast<std::size_t>(k)], group, k));
    for (std::size_t i = 0; i < gl.colour.values.size(); ++i) {
      figures_.pulled_shares.push_back(
          static_cast<float>(255 * std::abs(gl.share.values[i] - expected.share.values[i])));
      if (gl.share.values[i] > 0 && expected.share.values[i] > 0) {
        figures_.pulled_colours.push_back(largest_difference(gl.colour.values[i], expected.colour.values[i]));
      }
    }
    levels.push_back(gl);
  }
  std::vector<ShareLevel> tip = levels_from(levels.back());
  levels.insert(levels.end(), tip.begin() + 1, tip.end());
  // Push, as a step.
  const FourthLevel before = fourth_before_[group];
  const std::vector<ColourImage> pushed = shown_levels(levels, 4, &before);
  std::vector<ColourImage> gl_levels;
  for (int k = 0; k < kChartLevels; ++k) {
    gl_levels.push_back(colours_of(block(shown_[static_cast<std::size_t>(k)], group, k)));
    const auto& expected = pushed[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < expected.values.size(); ++i) {
      const float difference = largest_difference(gl_levels.back().values[i], expected.values[i]);
      if (k > 0) {
        figures_.pushed_colours.push_back(difference);
      } else if (found.valid.values[i] == 0 && owners_[group].values[i].inside) {
        figures_.pushed_holes.push_back(difference);
      }
    }
  }
  fourth_before_[group] = {gl_levels[4], levels[4].share};
  // As a whole.
  if (!BatchedExtractionOracle::any_observed(observed)) return;
  const std::vector<ColourImage> filled = oracle_.fill_group(group);
  for (std::size_t i = 0; i < filled[0].values.size(); ++i) {
    if (!owners_[group].values[i].inside || found.valid.values[i] != 0 || observed.valid.values[i] != 0) continue;
    figures_.filled_colours.push_back(largest_difference(gl_levels[0].values[i], filled[0].values[i]));
  }
  for (std::size_t k = 1; k < kChartLevels; ++k) {
    for (std::size_t i = 0; i < filled[k].values.size(); ++i) {
      figures_.level_colours.push_back(largest_difference(gl_levels[k].values[i], filled[k].values[i]));
    }
  }
}

void BatchedComparison::add_picture(const CameraFrame& frame) {
  ++figures_.pictures;
  (void)gl_.extract(frame);
  const BatchedExtraction::Intermediate intermediate = gl_.intermediate();
  const BatchedPicture picture = oracle_.look(frame);
  compare_picture(picture, intermediate);
  compare_texels(frame, picture, intermediate);
  const std::vector<TextureStore::PolygonState> states = store_.read_polygon_states();
  for (std::size_t group = 0; group < store_.layout().groups.size(); ++group) {
    compare_fill(group);
    const bool any = seen_[group] != 0;
    const glm::dvec3 mean =
        !any ? glm::dvec3(0) : levels_from(level_of_bgra(block(pulled_[4], group, 4))).back().colour.at(0, 0);
    for (const std::uint32_t polygon : store_.layout().members_of(store_.layout().groups[group])) {
      const TextureStore::PolygonState& state = states[polygon];
      if ((state.seen == 1) != any) ++figures_.wrong_states;
      if (!any) continue;
      figures_.state_colours.push_back(
          largest_difference(glm::dvec3(state.blue, state.green, state.red) * 255.0, mean));
    }
  }
}

void BatchedFigures::expect_agreement(const std::string& what) const {
  const auto figures = [](const std::vector<float>& differences) {
    std::ostringstream text;
    text << std::setprecision(3) << percentile(differences, 0.99) << "/" << percentile(differences, 0.999) << "/"
         << percentile(differences, 1) << " of " << differences.size();
    return text.str();
  };
  std::cout << what << ": " << pictures << " pictures\n"
            << "  pixels judged " << pixels_judged << " of " << pixels << ", wrong " << wrong_surfaces
            << "; relative differences (99 %/99.9 %/maximum) w " << figures(w) << ", slopes " << figures(slopes)
            << "\n  unsafe: wrong " << wrong_unsafe << ", relative " << figures(unsafe) << "\n  cells " << cells
            << ", taking something " << open_cells << ", wrong " << wrong_cells << ", bounds relative "
            << figures(cell_bounds) << "\n  steps: texels " << step_texels << ", wrong " << wrong_step_texels
            << ", wrong alphas " << wrong_alphas << "; differences in 1/255 (99 %/99.9 %/maximum) gathered "
            << figures(step_colours) << "\n    pulled " << figures(pulled_colours) << ", shares "
            << figures(pulled_shares) << "\n    pushed, levels 1-4 " << figures(pushed_colours) << ", holes "
            << figures(pushed_holes) << "\n    states: wrong " << wrong_states << ", colours " << figures(state_colours)
            << "\n  whole: texels " << texels << ", intersection over union of invalid";
  for (const double overlap : invalid_overlaps) std::cout << ' ' << overlap;
  std::cout << ", of valid";
  for (const double overlap : valid_overlaps) std::cout << ' ' << overlap;
  std::cout << "\n    differing " << differing << ", farthest " << farthest << " pixels, beyond a pixel of contour "
            << beyond_contour << " and islands " << beyond_islands << "; charts seen by one only " << charts_seen_by_one
            << "; gutter texels with both " << gutter_both << ", GL only " << gutter_gl << ", oracle only "
            << gutter_oracle << "\n    colours " << figures(colours) << ", filled " << figures(filled_colours)
            << ", levels 1-4 " << figures(level_colours) << '\n';
  for (const std::string& line : notes) std::cout << "  note: " << line << '\n';
  const auto share = [](std::size_t part, std::size_t all) {
    return static_cast<double>(part) / static_cast<double>(std::max<std::size_t>(all, 1));
  };
  EXPECT_GE(share(pixels_judged, pixels), 0.99);
  EXPECT_LE(share(wrong_surfaces, pixels), 5e-6) << "slivers of polygons seen edge-on";
  EXPECT_LE(percentile(w, 0.999), 1e-4);
  EXPECT_LE(percentile(slopes, 0.999), 1e-4);
  EXPECT_LE(share(wrong_unsafe, pixels), 5e-4);
  EXPECT_LE(percentile(unsafe, 0.99), 1e-3) << "half floats";
  EXPECT_LE(share(wrong_cells, cells), 1e-3);
  EXPECT_LE(percentile(cell_bounds, 0.99), 2e-3);
  EXPECT_GE(step_texels, 1000U) << "the pictures must test something";
  EXPECT_LE(share(wrong_step_texels, step_texels), 1e-4);
  EXPECT_LE(share(wrong_alphas, step_texels), 1e-5) << "at the picture's border, or two texels from an edge";
  EXPECT_LE(percentile(step_colours, 0.999), 2);
  EXPECT_LE(percentile(pulled_colours, 1), 1);
  EXPECT_LE(percentile(pulled_shares, 1), 1);
  EXPECT_LE(percentile(pushed_colours, 0.99), 3);
  EXPECT_LE(percentile(pushed_holes, 0.99), 3);
  EXPECT_EQ(wrong_states, 0U);
  EXPECT_LE(percentile(state_colours, 1), 4);
  for (const double overlap : invalid_overlaps) EXPECT_GE(overlap, 0.9);
  for (const double overlap : valid_overlaps) EXPECT_GE(overlap, 0.9);
  EXPECT_EQ(beyond_contour, 0U);
  EXPECT_LE(share(beyond_islands, texels), 1e-3);
  EXPECT_GE(colours.size(), 500U);
  EXPECT_GE(filled_colours.size(), 100U);
  EXPECT_LE(percentile(colours, 0.99), 4);
  EXPECT_LE(percentile(filled_colours, 0.99), 4);
  EXPECT_LE(percentile(level_colours, 0.99), 4);
}

}  // namespace foreview::oracle
