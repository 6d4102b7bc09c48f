#pragma once
#include <array>
#include <vector>

#include "foreview/gpu/extraction.h"

// What was measured in 2005, on an Athlon XP with 2.2 GHz and a GeForce 6800 GT, milliseconds per picture (spec 12).

namespace foreview {

inline constexpr double kDensity2005 = 500;
inline constexpr int kMaxTexels2005 = 256;
inline constexpr std::array<int, 5> kPasses2005{2, 4, 6, 8, 10};
inline constexpr std::array<double, 6> kBilinear2005{0, 15.3, 25.7, 36.1, 46.5, 56.9};
inline constexpr std::array<double, 6> kDiamond2005{0, 18.6, 29.5, 40.5, 51.5, 62.4};

struct Size2005 {
  double density;
  int max_texels;
  double ms;
};
inline constexpr std::array<Size2005, 7> kSizes2005{{{50, 512, 118.3},
                                                     {100, 64, 100.9},
                                                     {100, 256, 112.5},
                                                     {100, 512, 128.9},
                                                     {500, 64, 104.8},
                                                     {500, 256, 125.7},
                                                     {500, 512, 464.7}}};

struct Filling2005 {
  const char* name;
  HoleFilling fill;
  bool query;
  std::array<double, 3> ms;  ///< complex scene, object, cube
};
inline constexpr std::array<Filling2005, 3> kFillings2005{
    {{"pyramid", HoleFilling::pyramid, true, {66.2, 58.3, 4.8}},
     {"iterative, no query", HoleFilling::iterative, false, {3014.9, 892.1, 160.7}},
     {"iterative, with query", HoleFilling::iterative, true, {1752.5, 404.2, 3.7}}}};

/// A row of table 7.1, and which of our steps it is the sum of.
struct StepRow2005 {
  const char* label;
  double ms;
  std::vector<ExtractionStep> steps;
};

inline const std::vector<StepRow2005>& step_rows_2005() {
  static const std::vector<StepRow2005> rows{
      {"perspective texture", 14.6, {ExtractionStep::projection}},
      {"occlusion", 4.6, {ExtractionStep::occlusion}},
      {"artefact suppression", 24.1, {ExtractionStep::suppression}},
      {"normalisation and scaling", 4.8, {ExtractionStep::normalisation}},
      {"fusion", 2.3, {ExtractionStep::fusion}},
      {"hole filling", 66.2, {ExtractionStep::filling}},
      {"other: upload + publishing + rest",
       9.1,
       {ExtractionStep::upload, ExtractionStep::publishing, ExtractionStep::other}}};
  return rows;
}
inline constexpr double kTotal2005 = 125.7;

/// A column of table 7.5: extraction beside a display of so many frames a second; 0: none.
struct Display2005 {
  double rate;
  double few_ms, many_ms;  ///< views with few and with many polygons
};
inline constexpr std::array<Display2005, 5> kDisplays2005{
    {{0, 125.7, 125.7}, {25, 147.4, 156.7}, {33, 156.9, 171.3}, {50, 179.9, 209.9}, {100, 332.8, 613.7}}};

}  // namespace foreview
