#pragma once
#include <memory>

#include "foreview/gpu/extraction.h"
#include "foreview/gpu/texture_store.h"

namespace foreview {

/// The method of 2005, step by step and polygon by polygon (spec 3-9): the reproduction of the paper, the reference of
/// the tests and the baseline of the benchmark. Works in textures of its own (one of w x h per polygon, created once)
/// and copies each finished one into the polygon's chart.
///
/// The rules, which the CPU oracle (tests/oracle) follows independently:
///
/// 0. *Undistort* (once a picture): the undistorted camera has the same size, focal length and principal point. Each of
///    its pixels takes the bilinear sample of the lens's picture at the distorted position of its centre; where one of
///    the four taps lies outside the lens's picture, the pixel is unusable: its alpha is 31/32 for every polygon. A
///    camera without distortion needs no resampling: all its pixels are usable.
/// 1. *Depth and owner* (once a picture): all polygons, front and back faces, every part at its pose in M_t, cut at
///    z = near_plane, at pixel centres: D = 1/z (0: nothing there) and the owner's index. Back faces occlude and take
///    no texture. The backdrop is a polygon like any other: it takes textures, and occludes what lies beyond it.
/// 2. *Perspective texture*: the polygon is clipped at z = near_plane before the divide and projected. Its bounding box
///    in whole pixels, floor of the least to ceil of the greatest coordinate (after moving both inwards by 1e-6 pixels,
///    so that rounding adds no row), cut to the picture, decides about "outside" (no pixel left) and about
///    small_texture. Grown by 3 pixels and again cut to the picture it is what
///    steps 3-5 work on. Skipped, in this order: back faces (the camera not in front of the plane), boxes outside the
///    picture (or all behind near_plane), polygons whose clipped projection (not cut to the picture) has less than 0.05
///    square pixels.
/// 3. *Occlusion* (alpha of a pixel of the box, judged at its centre):
///    - inside the projection: 0 where D exceeds the polygon's own 1/z by more than a relative 1e-4, else 1. But always
///      1 where the polygon is the owner, or a neighbour sharing an edge is and the pixel's centre lies within 1/64
///      pixel of the outline: a rasteriser rounds corners to 1/256 pixel, and a slanted polygon's depth with them;
///    - outside, but within kBand = 2.5 pixels (Euclidean) of its outline (spec 8's lines of 5 pixels; edges made by
///      clipping at the near plane count as outline too, those of the picture do not): let f be the nearest point of
///      the outline and e the polygon's 1/z at f. 1 where the owner is a neighbour sharing an edge or the polygon
///      itself; else 0 where D > 1.02 e, 1 where D >= 0.98 e, 31/32 where the pixel lies behind (beyond the polygon's
///      own silhouette: another surface's colour, but no occluder);
///    - elsewhere 31/32. Pixels beyond the box count as 31/32.
/// 4. *Artefact suppression* on alpha (spec 5), skipped where the shorter side of the box before growing is less than
///    `small_texture` pixels. Passes are simultaneous (they read only the pass before). A texel that survives keeps its
///    own alpha, an invalid one stays 0.
///    - diamond: one pass kills a texel where the sum of its four edge neighbours' alphas is <= alpha_c.
///    - alternating: one pass = reduce to (ceil(w/2), ceil(h/2)), the mean of 2x2 texels counted from the box's upper
///      left (beyond the box: 31/32), where <= 3/4 becomes 0 and anything else stays; enlarge bilinearly to (w, h)
///      (texel centres at (i + 0.5) / 2 of the small image, so weights 9/16, 3/16, 3/16, 1/16; coordinates clamped),
///      kill where the result is <= 15/16.
///    - progressive: n such reductions, each of the one before, then n such enlargements back through the same sizes,
///      in each of which <= 15/16 becomes 0; kill where the last is 0.
/// 5. *Normalise and scale* (spec 6): w = min(r_max, next power of two >= d * extent (1 - 1e-6)), per axis, of the
///    polygon_frame()'s box, which fills the texture (the tolerance keeps rounding from doubling a size). A polygon
///    with a density of its own (the backdrop) takes that as d, and no r_max. The texel (i, j) is cut into n x n cells,
///    n = ceil of the longer of the texel's two steps in pixels (the projection's derivative at the texel's centre,
///    times the texel's side), less 1/1000 so that rounding does not decide, 1..4; each cell's centre is projected into
///    the picture and takes the bilinear sample of four pixels. Valid if for every cell z > near_plane, all four pixels
///    are in the picture and have alpha > 31/32. Colour: the mean of the cells.
/// 6. *Fuse* (spec 7): new where valid, else what was there; reversed for a picture older than the newest one that this
///    polygon's texture was made from.
/// 7. *Fill* (spec 9), on a copy. Validity is kept from before.
///    - pyramid: pull means of valid children; push bilinearly (a texel's centre lies at half its coordinates in the
///      coarser level; clamped), valid texels of the finer level overwrite. Where max_texels is no power of two, an odd
///      size halves upwards and what lies beyond is not valid.
///    - iterative: an invalid texel with a valid one among its 8 neighbours becomes the mean of the valid ones in its
///      5x5 window, as far as that lies in the texture; repeat, texels just filled counting as valid.
///    - none: as pyramid, but mid grey (128) where a texel is invalid and its centre lies in the polygon, or at most
///      0.25 texels beyond an edge's line; or at most 2 texels, if the texel is invalid that contains the centre after
///      moving it, for one edge after the other, to at least 1 texel inside the edge's line. Colours further out are
///      never shown, yet coarse levels mix them with those that are.
///    No valid texel at all: mid grey everywhere.
/// 8. *Copy to the chart*: each texel of the chart's block takes the bilinear sample (clamped) of the filled texture at
///    its own point of the plane, and alpha 1 or 0 from the texel that contains the point (clamped). Then the chart's
///    levels are rebuilt, and the polygon's mean colour (the pyramid's top) goes to its PolygonState.
class PerPolygonExtraction final : public ExtractionPipeline {
 public:
  static constexpr double kBand = 2.5;  ///< pixels

  /// `density` (texels/m) and `max_texels` of spec 6 come from `chart_options`, the ones the store was laid out with.
  /// The store must outlive the pipeline. Throws InputError where the store was laid out with groups of polygons: what
  /// is copied is a whole block.
  PerPolygonExtraction(TextureStore& store, const ChartOptions& chart_options, const ExtractionOptions& options);
  ~PerPolygonExtraction() override;
  ExtractionStatistics extract(const CameraFrame& frame) override;
  void begin(CameraFrame frame) override;
  [[nodiscard]] std::optional<ExtractionSlice> pending_slice() override;
  void clear() override;
  void adopt_store() override;
  void set_timing(ExtractionTiming timing) override;
  void set_counting(bool on) override;

  /// For tests: the state after the steps of the last picture that touched `polygon`.
  struct Intermediate {
    cv::Mat box_alpha_before;  ///< CV_32F, step 3, of the box
    cv::Mat box_alpha_after;   ///< CV_32F, step 4
    int box_x = 0, box_y = 0;  ///< upper left pixel of the box
    cv::Mat fused;             ///< CV_8UC4 BGRA, step 6: alpha 255 valid
    cv::Mat filled;            ///< CV_8UC4 BGRA, step 7
  };
  /// Runs the picture again for this polygon alone, without changing the store or the textures.
  [[nodiscard]] Intermediate inspect(const CameraFrame& frame, std::uint32_t polygon);
  /// The undistorted picture of step 0 (CV_8UC4 BGRA, alpha 255 usable).
  [[nodiscard]] cv::Mat undistorted(const CameraFrame& frame);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
