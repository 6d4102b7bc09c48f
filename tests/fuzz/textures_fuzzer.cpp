#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "foreview/gpu/textures_format.h"
#include "foreview/scene/errors.h"

/// The text files of saved textures: whatever comes in, either it is refused by an InputError, or what was read writes
/// and reads back the same. The first byte chooses the file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data + 1), size - 1);
  std::uint32_t width = 0, height = 0;
  (void)foreview::read_rgba_png_size(text, width, height);
  try {
    if (data[0] % 2 == 0) {
      const foreview::TexturesIndex index = foreview::parse_textures_yaml(text, "fuzz");
      if (!(foreview::parse_textures_yaml(foreview::to_textures_yaml(index), "again") == index)) std::abort();
    } else {
      const std::size_t polygons = data[0] / 2;
      const auto states = foreview::parse_states_csv(text, "fuzz", polygons);
      const std::string written = foreview::to_states_csv(states);
      if (foreview::to_states_csv(foreview::parse_states_csv(written, "again", polygons)) != written) std::abort();
    }
  } catch (const foreview::InputError&) {
  }
  return 0;
}
