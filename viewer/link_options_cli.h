#pragma once
#include <string>

#include "foreview/server/simulated_link.h"

namespace CLI {
class App;
}

namespace foreview {

/// Adds --jitter, --loss, --bandwidth and --link-seed, what a simulated link does beside --delay. `options` must live
/// until the app has been parsed. Values that cannot be are InputErrors naming the option.
void add_link_options(CLI::App& command, LinkOptions& options);

/// "8M", "500k", "64000", each also with "bit/s": bits per second, from 1 kbit/s to 1 Tbit/s; "0": no limit.
[[nodiscard]] double parse_bandwidth(const std::string& text, const std::string& option);
/// "0.2" or "20%": a probability from 0 to 1.
[[nodiscard]] double parse_probability(const std::string& text, const std::string& option);

}  // namespace foreview
