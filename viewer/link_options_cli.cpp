#include "foreview/viewer/link_options_cli.h"

#include <CLI/CLI.hpp>
#include <charconv>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

/// The number that `text` begins with, and what follows it; false where it begins with none.
bool split_number(const std::string& text, double& number, std::string& rest) {
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc()) return false;
  rest.assign(stop, end);
  return true;
}

}  // namespace

double parse_bandwidth(const std::string& text, const std::string& option) {
  double bits = 0;
  std::string unit;
  bool well = split_number(text, bits, unit);
  constexpr const char* kBits = "bit/s";
  if (unit.size() >= 5 && unit.compare(unit.size() - 5, 5, kBits) == 0) unit.resize(unit.size() - 5);
  if (unit == "k") {
    bits *= 1e3;
  } else if (unit == "M") {
    bits *= 1e6;
  } else if (unit == "G") {
    bits *= 1e9;
  } else {
    well = well && unit.empty();
  }
  if (!well || !(bits == 0 || (bits >= 1e3 && bits <= 1e12))) {
    throw InputError(
        option, "'" + text + "' cannot be; expected bits per second from 1k to 1000G, as in 8M, or 0 for no limit");
  }
  return bits;
}

double parse_probability(const std::string& text, const std::string& option) {
  double value = 0;
  std::string unit;
  bool well = split_number(text, value, unit);
  if (unit == "%") {
    value /= 100;
  } else {
    well = well && unit.empty();
  }
  if (!well || !(value >= 0 && value <= 1)) {
    throw InputError(option, "'" + text + "' cannot be; expected a probability, as in 0.2 or 20%");
  }
  return value;
}

void add_link_options(CLI::App& command, LinkOptions& options) {
  const auto add = [&](const std::string& name, const char* type, const char* help, auto read) {
    command
        .add_option_function<std::string>(
            name, [name, read](const std::string& text) { read(text, name); }, help)
        ->type_name(type);
  };
  using Text = const std::string&;
  add("--jitter", "TIME", "Standard deviation of the delay, as in 50ms: pictures overtake each other (default: 0)",
      [&options](Text text, Text option) {
        options.jitter = Duration::parse(text, option);
        if (options.jitter < Duration{0} || options.jitter > Duration::from_seconds(60)) {
          throw InputError(option, "'" + text + "' is out of range; expected a duration from 0 s to 60 s, as in 50ms");
        }
      });
  add("--loss", "P", "Probability that a picture is lost, as in 0.2 or 20% (default: 0)",
      [&options](Text text, Text option) { options.loss = parse_probability(text, option); });
  add("--bandwidth", "BITS", "Bits per second that the link carries, as in 8M (default: no limit)",
      [&options](Text text, Text option) { options.bandwidth = parse_bandwidth(text, option); });
  command.add_option("--link-seed", options.seed, "Seed of the link's chance (default: 1)")->type_name("N");
}

}  // namespace foreview
