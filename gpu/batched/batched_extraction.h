#pragma once
#include <memory>

#include "foreview/gpu/extraction.h"
#include "foreview/gpu/texture_store.h"

namespace foreview {

/// Textures of all polygons at once, in a fixed number of passes (design 5): the default.
///
/// The rules, which the CPU oracle (tests/oracle) follows independently. "Chart" is a block of ChartLayout::groups.
///
/// 0. *Undistort*, as rule 0 of PerPolygonExtraction.
/// 1. *Surfaces*: every pixel's nearest polygon at its centre, front or back face, every part at its pose in M_t, cut
/// at
///    z = near_plane: w = 1/z of the polygon's plane there and its slopes (a, b) per pixel along u and v; w is kept
///    within the least and greatest 1/z of the polygon's corners (those nearer than near_plane count as lying on it).
///    Nothing there: w = a = b = 0. A surface *continued* by (du, dv) pixels: w + a du + b dv, kept within the same
///    range. (That range is stored as half floats, and never narrower than w itself.)
/// 2. *Contours*: between two edge-adjacent pixels p and q lies a gap of min(|d_p|, |d_q|), where d_p = (w of p) -
///    (q's surface continued to p) and d_q = (p's surface continued to q) - (w of q); none where d_p d_q <= 0: there
///    the two surfaces meet between the pixels, as two polygons do that share an edge. The pair is *open* where the gap
///    is more than kGap times the greater w of the two. A pixel that is nearer (greater w) than a neighbour across an
///    open pair is an occluder's *rim*.
/// 3. *Suppression* (only with `passes` > 0): R(p) = w where p is a rim, else 0; one diamond pass is the maximum of a
///    pixel's and its four edge neighbours' R, simultaneously. After `passes` of them, what lies behind R is unsafe.
/// 4. *Cells*: between four pixels (a square of 2 x 2 centres) a surface may take colours if its 1/z lies within
///    [l, u]. For each of the four surfaces, continued to the middle of the cell, h = 0.5 (|a| + |b|): its 1/z within
///    the cell is [w - h, w + h], kept within its range; l and u are the least and greatest of all four, l (1 -
///    kRounding) and u (1 + kRounding). With suppression l is at least (1 - kGap) times the greatest R of the four
///    pixels. A cell with an unusable pixel, or that shows no surface, takes nothing. One with an open pair among its
///    four edges, or all of which suppression makes unsafe, takes only texels of *thin* polygons, without suppression.
///    Thin is a polygon wholly before the near plane whose projection's area, times four, is less than its perimeter,
///    and that is at most kThinPerimeter: narrower than a pixel, it may own no pixel's centre, is mostly seen beside a
///    contour, and would never get a colour (spec 5 leaves very small textures alone, too). What is longer is seen
///    edge-on, and better from elsewhere. (l, u and R are stored as half floats.)
/// 5. *Gather and fuse*: every texel whose centre lies in a polygon that shows its front, or within kChartGutter texels
///    of an edge of it that is the chart's outline, beside the edge or beyond a corner of two such edges (a polygon's
///    own texels win over others' gutter), is the point of the polygon's plane above it, with 1/z = w at the pixel (u,
///    v). It takes the bilinear sample there if z > near_plane, all four pixels are in the picture and [w - s, w + s]
///    meets the cell's [l, u], with s the least of |a| + |b| and the polygon's range of 1/z: what is wrong by less than
///    a pixel is right. Else the old texel stays. A polygon so near that its texels can be larger than kFootprint
///    pixels (greatest focal length * greatest 1/z of its corners / least density of its chart) is sampled more often:
///    n x m samples, n and m the length of a texel's step along x and y in pixels (the projection's derivative), less
///    1/1000 and rounded up, 1..4; all must pass; their mean is taken. Newest wins: if a newer picture has had a front
///    of the chart in it, even a hidden one, only texels without observation take anything.
///    With compensate_exposure textures hold colours under one exposure, exposed(picture, 1 / gain) (gpu/exposure.h,
///    per channel), with a gain for every picture; shown is exposed(texture, gain of the newest picture): where that
///    looked, its own colours appear, and what older pictures left beside them changes with it. The gain is found
///    before the gather (1 for the first picture). Of every 16 x 16 texels of a chart, the texel of level 2 that lies
///    nearest to the middle and wholly under a polygon's front (else: with its centre) is a *sample*, if its patch can
///    be changed by the picture, all of it was observed, and its centre could take a colour even if no polygon were
///    thin. It remembers what was observed there as a running mean (a tenth new each time it is a sample; compared with
///    the last picture alone, gains drift: 0.06 dB on kitchen; anew where it differed by more than a factor of
///    exp(0.14) from its picture), and e = exposed(that, last gain) is compared with c, the mean of four bilinear
///    samples of the picture in it. Counted is if all channels of both lie within 16..235 / 255 and differ by a factor
///    of at most exp(0.3). The channel's change is exp(sum(c - e) / sum of the means of f(c) and f(e)), f(c) = c (1 -
///    c^4), over those within a factor of exp(0.14) of the median weighted by these means (in bins of 0.005): so what
///    changes its colour has no say, and noise leans to neither side. Fewer than 48 samples change nothing, and the
///    gain stays within 1/3..3. A late picture is given a gain, too, but decides nothing about what is shown.
/// 6. *Pull*: level k's texel is the mean of the observed colours among its 4 children, each weighted by the share of
/// it
///    that was observed; alpha is that share (at least 1/255 if any). 16 x 16 texels make one of level 4;
///    above, a chart's own level has half its size, rounded up (what lies beyond the chart does not count), up to a
///    single texel.
/// 7. *Push* down: F = the tip's colour; F_k = m * pulled_k + (1 - m) * (F_{k+1} enlarged bilinearly, kept within the
///    chart's block), with m = min(1, 2 * share), down to level 1; at level 0 only where nothing is observed. These F
///    are the levels that are shown: what little was observed of a texel does not decide about all of it, so there is
///    no averaging again. (m = share measured 0.03 dB worse on the workcell, m = 1 wherever anything is observed 0.15
///    dB.) What hardly changes is left alone: a texel of F_4 stays as it was unless it changed by more than 1.5/255 in
///    a channel, or its share did; and a patch without such a texel in it or next to it keeps its fill: its holes, and
///    the texels of levels 1..3 of which less than half was observed. Holes are not filled again in a patch where all
///    is observed that can be (but for some texels: areas tell, not counts).
/// 8. A polygon's state is its chart's tip: seen once any texel of the chart is. Those never seen take their
/// neighbours'
///    colours (TextureStore::spread_to_never_seen) with the first and then every kSpreadEvery-th picture.
///
/// Rules 5 to 7 touch only *patches*, squares of the charts, in which the picture can change something; which do is
/// found out on the GPU, without a read-back.
class BatchedExtraction final : public ExtractionPipeline {
 public:
  static constexpr unsigned kSpreadEvery = 8;
  static constexpr float kGap = 0.01F;          ///< relative: steps of depth that make a contour
  static constexpr float kRounding = 1e-3F;     ///< relative: what half floats cost
  static constexpr double kFootprint = 2;       ///< pixels per texel, from which on one sample is too few
  static constexpr double kThinPerimeter = 64;  ///< pixels, at most

  /// The store must outlive the pipeline. Throws InputError where the options are out of range, or ask for a variant
  /// that only PerPolygonExtraction has (bilinear suppression, iterative filling or none).
  BatchedExtraction(TextureStore& store, const ExtractionOptions& options);
  ~BatchedExtraction() override;
  /// Leaves the context as set_up_context_state() makes it, with scissor, blending, culling and depth test off, all
  /// colours written and no samplers bound; it may find these otherwise. Program, framebuffer, viewport, vertex array
  /// and the other bindings are left as they happen to be. No polygon is skipped for being too small.
  ExtractionStatistics extract(const CameraFrame& frame) override;
  /// Ten kinds of slices; a picture goes in one of each, if they may be as large as they like. The pieces reach down to
  /// a row of patches or pixels.
  [[nodiscard]] std::span<const SliceKind> slice_kinds() const override;
  void begin(CameraFrame frame) override;
  [[nodiscard]] bool is_busy() const override;
  /// The set of textures to write into is needed rather late, after the picture's own geometry: only there may there be
  /// nothing to do for a while.
  [[nodiscard]] std::optional<ExtractionSlice> pending_slice() override;
  double run_slice(double size) override;
  [[nodiscard]] const ExtractionStatistics& statistics() const override;
  void clear() override;
  /// Levels and fills stay as they were loaded until the next picture. Stamps are not among what is saved: the next
  /// picture overwrites whatever its age.
  void adopt_store() override;
  void set_timing(ExtractionTiming timing) override;
  void set_counting(bool on) override;

  /// For tests: what rule 3 and 4 say of the last picture.
  struct Intermediate {
    cv::Mat surfaces;  ///< CV_32FC3, rule 1: w, a, b (1/m; per pixel)
    cv::Mat unsafe;    ///< CV_32F, rule 3: R
    cv::Mat cells;     ///< CV_32FC2, rule 4: l, u; a cell that takes nothing has l > u. One less than pixels each way
    cv::Mat undistorted;  ///< CV_8UC4 BGRA, rule 0
  };
  [[nodiscard]] Intermediate intermediate() const;
  /// For tests: levels 1..4 as rule 6 pulled them, CV_8UC4 BGRA, one a page.
  [[nodiscard]] std::vector<cv::Mat> pulled(int level) const;

 private:
  void end_phase();

  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
