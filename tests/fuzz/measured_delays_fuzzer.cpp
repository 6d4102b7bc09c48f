#include <cstdint>

#include "foreview/scene/errors.h"
#include "foreview/server/simulated_link.h"
#include "require.h"

// Delays a link can have come out, or an InputError of one line.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace foreview;
  try {
    LinkOptions options;
    options.measured_delays =
        parse_measured_delays(std::string(reinterpret_cast<const char*>(data), size), "delays.txt");
    FUZZ_REQUIRE(!options.measured_delays.empty());
    SimulatedLink link(options);
    FUZZ_REQUIRE(link.send({5}, 1).value() >= Timestamp{5});
  } catch (const InputError& error) {
    FUZZ_REQUIRE(std::string(error.what()).find('\n') == std::string::npos);
  }
  return 0;
}
