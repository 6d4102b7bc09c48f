#pragma once
#include <optional>
#include <string>
#include <vector>

#include "foreview/gpu/extraction.h"
#include "foreview/gpu/per_polygon/per_polygon_extraction.h"
#include "oracle/polygon_extraction.h"

namespace foreview::oracle {

[[nodiscard]] Options oracle_options(const ExtractionOptions& extraction, const ChartOptions& charts);
/// Of a CV_8UC4 BGRA picture; alpha 255 is valid.
[[nodiscard]] Texture texture_of(const cv::Mat& bgra);

/// Compares the GL pipeline with the oracle, polygon by polygon and step by step: every step of the oracle begins with
/// what GL handed to that step, so that one mistake is counted once, where it is made.
class Comparison {
 public:
  Comparison(const PolygonModel& model, const ExtractionOptions& extraction, const ChartOptions& charts);

  [[nodiscard]] const PolygonExtraction& oracle() const { return oracle_; }
  /// Step 0.
  void add_undistorted(const cv::Mat& gl, const PreparedFrame& frame);
  /// Steps 2-7. `before`: the polygon's texture before this picture (none: it had none); `late`: the picture is older.
  void add_polygon(const PerPolygonExtraction::Intermediate& gl, const PreparedFrame& frame, std::size_t polygon,
                   const std::optional<Texture>& before = std::nullopt, bool late = false);
  /// Step 8: a page of the store, given what GL's own steps 6 and 7 ended with.
  void add_chart(const cv::Mat& page, const Chart& chart, std::size_t polygon,
                 const PerPolygonExtraction::Intermediate& gl);

  /// Expects, through GoogleTest: not one decision wrong that rounding does not decide; intersection over union of what
  /// is valid, rounding or not, at least 0.99; of the differences of colour the 99.9th percentile within 2/255 (filled:
  /// 3/255). Prints the figures.
  void expect_agreement(const std::string& what) const;
  /// Share of decisions that were in doubt: a comparison that doubts everything would prove nothing.
  [[nodiscard]] double doubtful_share() const;
  [[nodiscard]] std::size_t polygons() const { return polygons_; }
  [[nodiscard]] std::size_t texels_compared() const { return fused_differences_.size(); }

 private:
  struct Overlap {
    std::size_t both = 0, any = 0;
    void add(bool a, bool b) {
      if (a && b) ++both;
      if (a || b) ++any;
    }
    [[nodiscard]] double ratio() const { return any == 0 ? 1.0 : static_cast<double>(both) / static_cast<double>(any); }
  };
  void note(const std::string& step, std::size_t polygon, int x, int y, double gl, double expected);
  void compare_masks(const PerPolygonExtraction::Intermediate& gl, const PolygonResult& expected, std::size_t polygon);
  void compare_fused(const PerPolygonExtraction::Intermediate& gl, const NormalisedTexture& fresh, std::size_t polygon,
                     const std::optional<Texture>& before, bool late);
  void compare_filled(const PerPolygonExtraction::Intermediate& gl, std::size_t polygon);

  const PolygonModel& model_;
  Options options_;
  PolygonExtraction oracle_;
  std::size_t polygons_ = 0, decisions_ = 0, doubtful_ = 0, wrong_ = 0;
  Overlap mask_before_, mask_after_, texels_;
  std::vector<float> undistorted_differences_, fused_differences_, filled_differences_, chart_differences_;
  std::vector<std::string> notes_;  ///< the first few mistakes
};

}  // namespace foreview::oracle
