#pragma once
#include <string>

#include "foreview/viewer/evaluation.h"

namespace foreview {

/// Mean over the instants (of dB: the arithmetic mean of the instants' dB) and the worst one.
struct MeanAndWorst {
  double mean = 0, worst = 0;
  std::string worst_stem;    ///< of the instant's picture
  std::size_t instants = 0;  ///< that have this figure; 0: nothing above holds
};

struct EvaluationSummary {
  struct View {
    MeanAndWorst psnr, ssim;
  };
  View predicted, delayed, rotation;
  double seen = 0, filled = 0, never_seen = 0;  ///< means over the instants, 0..1
  MeanAndWorst psnr_over_seen;
  PixelError beyond_silhouettes;  ///< over the pixels of all instants together
  PixelError ghosts;              ///< likewise
  double age = 0;                 ///< mean, seconds
};
[[nodiscard]] EvaluationSummary summarise(const Evaluation& evaluation);

/// The table for the terminal, lines of at most 80 columns.
[[nodiscard]] std::string evaluation_table(const Evaluation& evaluation, const EvaluationOptions& options);

inline constexpr int kEvaluationJsonVersion = 1;
/// One JSON object: "format" "foreview-evaluation", "version" kEvaluationJsonVersion, "complete", "recording",
/// "options", "summary" and "instants". Times in seconds, PSNR in dB, coverage as parts of 1, errors in 1/255; null
/// where there is no pixel to measure. Described in docs/evaluation.md.
[[nodiscard]] std::string evaluation_json(const Evaluation& evaluation, const EvaluationOptions& options);

}  // namespace foreview
