#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "foreview/scene/camera_frame.h"
#include "foreview/scene/chart_layout.h"
#include "oracle/hole_filling.h"
#include "oracle/normalisation.h"
#include "oracle/occlusion.h"

namespace foreview::oracle {

enum class Suppression { none, diamond, alternating, progressive };
enum class Filling { none, pyramid, iterative };

/// As ExtractionOptions and ChartOptions; the oracle knows nothing of gpu/.
struct Options {
  Suppression suppression = Suppression::diamond;
  int passes = 3;
  double alpha_c = 3.5;
  int small_texture = 12;
  Filling fill = Filling::pyramid;
  double near_plane = 0.02;
  double texels_per_metre = 500;
  int max_texels = 256;
};

/// A picture with what all polygons share of it (steps 0 and 1).
struct PreparedFrame {
  const CameraFrame* frame = nullptr;
  UndistortedPicture picture;
  Visibility visibility;
};

/// What became of one polygon in one picture (steps 2-7).
struct PolygonResult {
  Skip skip = Skip::none;
  bool exempt_small = false;
  ProjectedPolygon projected;
  Mask before, after;       ///< suppression
  NormalisedTexture fresh;  ///< step 5
  Texture fused;            ///< step 6
  ColourImage filled;       ///< step 7
};

/// The whole of gpu/per_polygon's rules, on the CPU. The model must outlive it.
class PolygonExtraction {
 public:
  PolygonExtraction(const PolygonModel& model, const Options& options);

  [[nodiscard]] PreparedFrame prepare(const CameraFrame& frame) const;
  /// The polygon's steps for this picture, without remembering them.
  [[nodiscard]] PolygonResult inspect(const PreparedFrame& frame, std::size_t polygon) const;
  /// All polygons; fuses into their textures. Returns how many were touched.
  std::size_t extract(const PreparedFrame& frame);
  /// The texture so far; no texels where no picture touched the polygon.
  [[nodiscard]] const Texture& texture(std::size_t polygon) const { return textures_[polygon]; }

 private:
  const PolygonModel& model_;
  Options options_;
  std::vector<Texture> textures_;
  std::vector<std::optional<Timestamp>> newest_;
};

/// The three variants of step 4 on a mask, its lower and its upper bound.
[[nodiscard]] AlphaImage suppress(const AlphaImage& alpha, const Options& options);
/// HoleFilling::none: the texels that are holes of the polygon itself and stay grey, if they are not valid.
[[nodiscard]] Flags open_holes(const PolygonModel& model, std::size_t polygon, const Texture& texture);
[[nodiscard]] ColourImage fill(const Texture& texture, Filling filling, const Flags& open);

/// Step 8: the block of a chart, level 0.
struct ChartBlock {
  ColourImage colour;
  Flags observed;
  Flags doubtful;  ///< rounding decides which texel contains the point
};
[[nodiscard]] ChartBlock copy_to_chart(const Chart& chart, const PolygonFrame& frame, const Texture& texture,
                                       const ColourImage& filled);

}  // namespace foreview::oracle
