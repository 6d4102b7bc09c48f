#pragma once
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "foreview/gpu/batched/batched_extraction.h"
#include "foreview/gpu/texture_store.h"
#include "oracle/batched_extraction.h"

namespace foreview::oracle {

/// How many of two sets' elements they have in common.
struct SetOverlap {
  std::size_t both = 0, any = 0;
  void add(bool a, bool b) {
    if (a && b) ++both;
    if (a || b) ++any;
  }
  [[nodiscard]] double ratio() const { return any == 0 ? 1.0 : static_cast<double>(both) / static_cast<double>(any); }
};

/// What comparisons of one or of several scenes found.
struct BatchedFigures {
  /// Expects agreement, through GoogleTest, and prints the figures.
  void expect_agreement(const std::string& what) const;

  using Floats = std::vector<float>;
  std::size_t pictures = 0;
  // Rules 1 to 4. Pixels of which a rasteriser may find another owner are not judged. Relative differences.
  std::size_t pixels = 0, pixels_judged = 0, wrong_surfaces = 0;
  std::size_t wrong_unsafe = 0;  ///< pixels
  std::size_t cells = 0, open_cells = 0, wrong_cells = 0;
  Floats w, slopes, unsafe, cell_bounds;
  // Rules 5 to 8, each beginning with what GL handed to it. Differences in 1/255.
  std::size_t step_texels = 0, wrong_step_texels = 0;
  std::size_t wrong_alphas = 0;  ///< neither 0 nor 1, or observed where no picture could show anything
  Floats step_colours, pulled_colours, pulled_shares, pushed_colours, pushed_holes, state_colours;
  std::size_t wrong_states = 0;
  // As a whole: own texels that any picture could show, after each picture.
  std::vector<double> invalid_overlaps, valid_overlaps;
  std::size_t texels = 0;
  std::size_t differing = 0;       ///< observed with one and not with the other
  std::size_t beyond_contour = 0;  ///< of those, further from the oracle's contour than a pixel (and a texel) ...
  std::size_t beyond_islands = 0;  ///< ... or within it of GL's: what only one of them has, no wider than that
  std::size_t charts_seen_by_one = 0;
  std::size_t gutter_both = 0, gutter_gl = 0, gutter_oracle = 0;  ///< observed with
  double farthest = 0;                                            ///< pixels from the oracle's contour
  Floats colours, filled_colours, level_colours;
  std::vector<std::string> notes;  ///< the first few mistakes
};

/// Compares BatchedExtraction with the oracle, on the same pictures, in two ways: step by step, every step of the
/// oracle beginning with what GL handed to that step; and as a whole, the oracle keeping textures of its own.
class BatchedComparison {
 public:
  /// All must outlive the comparison; nothing may have been extracted yet.
  BatchedComparison(const PolygonModel& model, TextureStore& store, BatchedExtraction& gl,
                    const ExtractionOptions& options, BatchedFigures& figures);
  /// Extracts from the picture with both.
  void add_picture(const CameraFrame& frame);

 private:
  struct Verdict;
  void compare_picture(const BatchedPicture& oracle, const BatchedExtraction::Intermediate& gl);
  void compare_texels(const CameraFrame& frame, const BatchedPicture& picture,
                      const BatchedExtraction::Intermediate& gl);
  void compare_contours(const std::vector<Verdict>& verdicts, int width, int height);
  void compare_fill(std::size_t group);
  [[nodiscard]] cv::Mat block(const std::vector<cv::Mat>& pages, std::size_t group, int level) const;
  void note(const std::string& text);

  BatchedFigures& figures_;
  TextureStore& store_;
  BatchedExtraction& gl_;
  BatchedExtractionOracle oracle_;
  bool suppressing_ = false;

  /// Of the last picture, by level, as the store shows them; and what GL pulled.
  std::vector<std::vector<cv::Mat>> shown_, pulled_;
  std::vector<Flags> in_picture_;  ///< by group: own texels that any picture could have shown
  std::vector<Flags> differed_;    ///< by group: observed with one and not with the other
  std::vector<Image<TexelOwner>> owners_;
  std::vector<char> seen_;                  ///< by group, with both
  std::vector<FourthLevel> fourth_before_;  ///< by group, GL's after the picture before
};

}  // namespace foreview::oracle
