#include "foreview/gpu/extraction.h"

#include <cmath>

#include "foreview/scene/errors.h"

namespace foreview {

void ExtractionOptions::validate() const {
  const auto refuse = [](const char* option, const std::string& value, const char* expected) {
    throw InputError(option, value + " is out of range; expected " + expected);
  };
  if (passes < 0 || passes > 64) refuse("--passes", std::to_string(passes), "0 to 64");
  // From 3.875 on, texels outside the polygon would eat into it; below 3 an invalid texel does not grow.
  if (!(alpha_c >= 3 && alpha_c < 3.875)) refuse("--alpha-c", std::to_string(alpha_c), "3 or more and below 3.875");
  if (small_texture < 0) refuse("--small-texture", std::to_string(small_texture), "0 or more pixels");
  if (!(near_plane >= 1e-4 && near_plane <= 100)) {
    refuse("--near-plane", std::to_string(near_plane), "0.0001 to 100 metres");
  }
}

}  // namespace foreview
