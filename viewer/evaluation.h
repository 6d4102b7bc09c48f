#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "foreview/viewer/picture_metrics.h"
#include "foreview/viewer/replayer.h"

namespace foreview {

struct EvaluationOptions {
  ReplayOptions replay;
  std::size_t every = 1;                        ///< of the operator's pictures in from..to, each N-th is an instant
  std::optional<std::filesystem::path> images;  ///< write predicted/ delayed/ rotation/ truth/ NAME.png below it
};

/// One way of showing the site at an instant, against the true picture of that instant.
struct ViewScore {
  double psnr = 0;             ///< dB, over all three channels
  std::optional<double> ssim;  ///< none where the usable pixels hold not one whole window
};

/// All figures count only pixels that the undistorted true picture has (Undistortion::usable()).
struct InstantScore {
  std::size_t picture = 0;          ///< index of the true picture in the operator's camera
  std::string stem;                 ///< of its file
  double seconds = 0;               ///< since the recording's first picture
  std::size_t delayed_picture = 0;  ///< the operator's newest used picture ...
  double age = 0;                   ///< ... and how old it is, seconds: at least the delay, plus up to one period
  ViewScore predicted;              ///< the predicted view
  ViewScore delayed;                ///< the newest used picture as it is
  ViewScore rotation;               ///< the same, warped by the head's rotation: warp_by_rotation()
  double seen = 0, filled = 0, never_seen = 0;  ///< parts of the pixels, 0..1: what the predicted view shows there
  PixelError over_seen;                         ///< of the predicted view, where it shows what a picture has shown
  PixelError beyond_silhouettes;                ///< of the predicted view, pixels_beyond_silhouettes() of the newest
                                                ///< used picture of any camera
  PixelError ghosts;                            ///< there too: displaced_error() within kGhostDisplacement pixels
};

/// How good the prediction was.
struct Evaluation {
  std::vector<InstantScore> instants;
  std::size_t instants_without_picture = 0;  ///< left out: no picture had arrived yet
  std::size_t instants_damaged = 0;          ///< left out: the true picture is damaged
  bool complete = true;                      ///< false: interrupted, the instants so far
  // What it was measured with:
  std::string renderer;  ///< of the GL
  std::string recording, camera;
  int width = 0, height = 0;
  std::size_t polygons = 0;
  double texels_per_metre = 0;
  int max_texels = 0;
  std::optional<RegistrationStatus> registration;  ///< of the operator's camera, at the end
  std::size_t pictures_extracted = 0;              ///< with --history, some of them several times
  std::size_t pictures_damaged = 0;                ///< skipped when read
  RecordingDamage damage;                          ///< all that the reader dropped
  double extraction_seconds = 0;                   ///< wall clock for all pictures extracted, without reading them
};

/// Evaluates every instant of the replayer's span. `progress` (may be empty) is called before every picture and at the
/// end with the instants done; when it throws Interrupted, what is done so far is returned as not complete. InputError
/// where not one instant can be evaluated, or a picture cannot be written.
[[nodiscard]] Evaluation evaluate(Replayer& replayer, const EvaluationOptions& options,
                                  const std::function<void(std::size_t done, std::size_t todo)>& progress = {});

}  // namespace foreview
