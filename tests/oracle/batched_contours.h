#pragma once
#include <vector>

#include "foreview/scene/camera_frame.h"
#include "foreview/scene/polygon_model.h"
#include "oracle/image.h"

// Rules 1 to 4 of BatchedExtraction: which places of a picture a surface of which depth may take colours from.

namespace foreview::oracle {

inline constexpr double kBatchedGap = 0.01;
inline constexpr double kBatchedRounding = 1e-3;
inline constexpr double kBatchedThinPerimeter = 64;  // pixels

/// 1/z of a polygon's corners, those nearer than the near plane counting as lying on it.
struct InverseRange {
  double least = 0, greatest = 0;
  [[nodiscard]] double keep(double w) const;
  [[nodiscard]] double size() const { return greatest - least; }
};

/// A polygon as the camera without distortion sees it: 1/z is linear over the picture.
struct PictureSurface {
  Pose camera_from_part;
  bool front = false;   ///< the camera stands before its plane
  bool shown = false;   ///< a front, some of which is in the picture, hidden or not
  double origin = 0;    ///< 1/z of the plane at pixel coordinates (0, 0)
  double a = 0, b = 0;  ///< its slopes along u and v, 1/m per pixel
  InverseRange range;
  bool thin = false;  ///< rule 5: narrower than a pixel
  double doubt = 0;   ///< relative: how much its corners' distance from the plane and rounding can change 1/z
  [[nodiscard]] double plane_at(double u, double v) const { return origin + a * u + b * v; }
};
[[nodiscard]] PictureSurface picture_surface(const PolygonModel& model, std::size_t polygon, const CameraModel& camera,
                                             const CaptureState& state, double near_plane);

/// Rule 1, at a pixel's centre. Nothing: polygon -1, all zero.
struct Surface {
  int polygon = -1;
  double w = 0, a = 0, b = 0;
  InverseRange range;
  bool doubtful = false;  ///< a rasteriser may find another polygon here
  [[nodiscard]] double continued(double du, double dv) const { return range.keep(w + a * du + b * dv); }
};
[[nodiscard]] Image<Surface> surfaces(const PolygonModel& model, const CameraModel& camera, const CaptureState& state,
                                      double near_plane);

/// Rule 2: `q` is the pixel at (dx, dy) from `p`, one of (1, 0), (0, 1), (-1, 0), (0, -1).
[[nodiscard]] bool is_open(const Surface& p, const Surface& q, int dx, int dy);
/// Rule 3 before the first pass: w of rims, else 0.
[[nodiscard]] AlphaImage rims(const Image<Surface>& surfaces);
/// Rule 3: so many diamond passes.
[[nodiscard]] AlphaImage spread(const AlphaImage& rims, int passes);

/// Rule 4: what 1/z may take colours.
struct Cell {
  double least = 1, greatest = 0;  ///< takes nothing where least > greatest
  bool thin_only = false;          ///< what is between them is for thin polygons
  [[nodiscard]] bool takes_nothing(bool thin) const { return least > greatest || (thin_only && !thin); }
};
/// Cell (x, y) lies between the centres of pixels (x, y) and (x + 1, y + 1). `unsafe`: null without suppression.
[[nodiscard]] Image<Cell> cells(const Image<Surface>& surfaces, const AlphaImage* unsafe, const Flags& usable);

}  // namespace foreview::oracle
