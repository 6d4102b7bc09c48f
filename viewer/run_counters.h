#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "foreview/gpu/extraction.h"

namespace foreview {

class TextureStore;

/// What `--stats` prints of any run that extracts textures.
struct RunCounters {
  std::size_t pictures_extracted = 0;
  std::size_t pictures_overwritten = 0;  ///< unread: only where pictures arrive live
  std::size_t pictures_damaged = 0;
  ExtractionStatistics sum;       ///< over the pictures extracted
  bool observed_counted = false;  ///< else sum.texels_observed says nothing
  // Of the model and its layout:
  std::size_t polygons = 0;
  double texels_useful = 0;      ///< area of all polygons but the backdrop's times density
  std::size_t memory_bytes = 0;  ///< of all textures and states of the store

  void describe(const TextureStore& store);
};

/// Lines of at most 100 columns. Texels, polygons, passes and draw calls are means over the pictures extracted.
[[nodiscard]] std::string counters_text(const RunCounters& counters);
/// The sums, by name; "texels_observed" null where it was not counted.
[[nodiscard]] nlohmann::ordered_json counters_json(const RunCounters& counters);

}  // namespace foreview
