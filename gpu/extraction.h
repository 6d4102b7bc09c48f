#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "foreview/scene/camera_frame.h"

namespace foreview {

class TextureStore;

enum class ArtefactSuppression { none, diamond, alternating, progressive };  ///< spec 5
enum class HoleFilling { none, pyramid, iterative };                         ///< spec 9

struct ExtractionOptions {
  ArtefactSuppression artefacts = ArtefactSuppression::diamond;
  int passes = 3;          ///< diamond passes, or n of the bilinear variants
  double alpha_c = 3.5;    ///< diamond threshold on the sum of four alphas; 3 <= alpha_c < 3.875 (spec 5)
  int small_texture = 12;  ///< pixels: a perspective texture with a shorter side is not suppressed (would vanish)
  HoleFilling fill = HoleFilling::pyramid;
  bool occlusion_query = true;  ///< iterative filling: stop when a pass changed nothing, asked by an occlusion query
  double near_plane = 0.02;     ///< metres
  /// Throws InputError naming the option that is out of its range.
  void validate() const;
};

/// What became of one picture.
struct ExtractionStatistics {
  std::size_t polygons_visible = 0;  ///< front faces with a part in the picture, whose textures were touched
  std::size_t polygons_skipped_back_face = 0, polygons_skipped_outside = 0, polygons_skipped_too_small = 0;
  std::size_t polygons_exempt_small = 0;  ///< not suppressed because of small_texture
  std::size_t texels_observed = 0;        ///< only counted when asked for (it costs a read-back); else 0
  /// Milliseconds per step of spec 12 (finish + wall clock), filled only when timing is switched on.
  double ms_upload = 0, ms_perspective = 0, ms_occlusion = 0, ms_suppression = 0, ms_normalisation = 0, ms_fusion = 0,
         ms_filling = 0, ms_other = 0, ms_total = 0;
};

/// Turns delayed pictures into textures of the store's charts. One picture at a time; after extract() returns, all its
/// GL commands are issued and the store shows either all of the picture's textures or none. A GL context that shares
/// with the store's must be current.
class ExtractionPipeline {
 public:
  virtual ~ExtractionPipeline() = default;
  ExtractionPipeline() = default;
  ExtractionPipeline(const ExtractionPipeline&) = delete;
  ExtractionPipeline& operator=(const ExtractionPipeline&) = delete;
  /// Fuses the frame's picture. Newest wins by capture stamp: a frame older than what a polygon's texture already holds
  /// only fills what is not valid there.
  virtual ExtractionStatistics extract(const CameraFrame& frame) = 0;
  /// Forgets all that has been seen.
  virtual void clear() = 0;
  /// Takes over what the store's charts hold now (after textures were loaded from a file).
  virtual void adopt_store() = 0;
};

}  // namespace foreview
