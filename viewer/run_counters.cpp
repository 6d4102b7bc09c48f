#include "foreview/viewer/run_counters.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "foreview/gpu/texture_store.h"

namespace foreview {
namespace {

template <typename... Values>
std::string line(const char* format, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return std::string(text) + "\n";
}

}  // namespace

void RunCounters::describe(const TextureStore& store) {
  polygons = store.model().polygons().size();
  texels_useful = store.layout().useful_texels;
  memory_bytes = store.memory_bytes();
}

std::string counters_text(const RunCounters& counters) {
  const ExtractionStatistics& sum = counters.sum;
  const auto mean = [&](std::size_t total) {
    return counters.pictures_extracted == 0
               ? 0.0
               : static_cast<double>(total) / static_cast<double>(counters.pictures_extracted);
  };
  std::string text = "counters of the run (per picture: means)\n";
  text += line("  pictures    in %zu: extracted %zu, overwritten unread %zu, damaged %zu",
               counters.pictures_extracted + counters.pictures_overwritten + counters.pictures_damaged,
               counters.pictures_extracted, counters.pictures_overwritten, counters.pictures_damaged);
  text += line("  texels      written %.3f M, filled over %.3f M per picture", 1e-6 * mean(sum.texels_written),
               1e-6 * mean(sum.texels_filled));
  if (counters.observed_counted) {
    text += line("              observed %.3f M per picture (counting them cost a read-back each time)",
                 1e-6 * mean(sum.texels_observed));
  } else {
    text += "              observed: not counted (it costs a read-back per picture)\n";
  }
  text += line("              useful in the layout %.3f M (all polygons but the backdrop's)",
               1e-6 * counters.texels_useful);
  text += line("  polygons    visible %.1f of %zu per picture, in %.1f charts", mean(sum.polygons_visible),
               counters.polygons, mean(sum.charts_touched));
  text += line("              skipped: back faces %.1f, outside the picture %.1f, too small %.1f",
               mean(sum.polygons_skipped_back_face), mean(sum.polygons_skipped_outside),
               mean(sum.polygons_skipped_too_small));
  text += line("              too small to be suppressed: %.1f", mean(sum.polygons_exempt_small));
  text += line("  commands    %.1f passes, %.1f draw calls per picture", mean(sum.passes), mean(sum.draw_calls));
  text += line("  memory      %.1f MB of texture pages", 1e-6 * static_cast<double>(counters.memory_bytes));
  return text;
}

nlohmann::ordered_json counters_json(const RunCounters& counters) {
  const ExtractionStatistics& sum = counters.sum;
  nlohmann::ordered_json json{
      {"pictures_in", counters.pictures_extracted + counters.pictures_overwritten + counters.pictures_damaged},
      {"pictures_extracted", counters.pictures_extracted},
      {"pictures_overwritten", counters.pictures_overwritten},
      {"pictures_damaged", counters.pictures_damaged},
      {"texels_written", sum.texels_written},
      {"texels_filled", sum.texels_filled},
      {"texels_observed", nullptr},
      {"texels_useful_in_layout", counters.texels_useful},
      {"polygons", counters.polygons},
      {"polygons_visible", sum.polygons_visible},
      {"polygons_skipped_back_face", sum.polygons_skipped_back_face},
      {"polygons_skipped_outside", sum.polygons_skipped_outside},
      {"polygons_skipped_too_small", sum.polygons_skipped_too_small},
      {"polygons_exempt_small", sum.polygons_exempt_small},
      {"charts_touched", sum.charts_touched},
      {"passes", sum.passes},
      {"draw_calls", sum.draw_calls},
      {"texture_bytes", counters.memory_bytes},
  };
  if (counters.observed_counted) json["texels_observed"] = sum.texels_observed;
  return json;
}

}  // namespace foreview
