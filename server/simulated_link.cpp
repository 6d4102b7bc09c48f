#include "foreview/server/simulated_link.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <utility>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

constexpr Duration kLongestDelay{3'600'000'000'000};
constexpr std::size_t kMostMeasuredDelays = 10'000'000;

/// What a packet's luck is drawn for: each purpose has a stream of its own.
enum class Luck : std::uint64_t { loss, jitter_radius, jitter_angle, reordering, measured };

/// SplitMix64's output function (Steele, Lea, Flood 2014): a counter in, 64 well mixed bits out.
std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}

/// Uniform in [0, 1).
double draw(std::uint64_t seed, std::uint64_t packet, Luck luck) {
  const std::uint64_t bits = mix(mix(mix(seed + 0x9e3779b97f4a7c15U) + packet) + static_cast<std::uint64_t>(luck));
  return static_cast<double>(bits >> 11) * 0x1p-53;
}

/// Box and Muller; the standard library's distribution differs between implementations.
double draw_normal(std::uint64_t seed, std::uint64_t packet) {
  const double radius = std::sqrt(-2 * std::log(1 - draw(seed, packet, Luck::jitter_radius)));
  return radius * std::cos(2 * std::numbers::pi * draw(seed, packet, Luck::jitter_angle));
}

void check_delay(Duration delay, const char* what) {
  if (delay < Duration{} || delay > kLongestDelay) {
    throw InputError(what, std::to_string(delay.seconds()) + " s is out of range; expected 0 to 3600 s");
  }
}

void check_probability(double probability, const char* what) {
  if (!(probability >= 0 && probability <= 1)) {
    throw InputError(what, std::to_string(probability) + " is no probability; expected 0 to 1");
  }
}

}  // namespace

void check_link_options(const LinkOptions& options) {
  check_delay(options.delay, "link delay");
  check_delay(options.jitter, "link jitter");
  check_delay(options.reordering_delay, "link reordering delay");
  check_delay(options.longest_queue, "link queue");
  for (const Duration delay : options.measured_delays) check_delay(delay, "measured delay");
  check_probability(options.loss, "link loss");
  check_probability(options.reordering, "link reordering");
  if (!std::isfinite(options.bandwidth) || options.bandwidth < 0) {
    throw InputError("link bandwidth", "is not a number of bits per second; expected 0 (no limit) or more");
  }
}

SimulatedLink::SimulatedLink(LinkOptions options) {
  set_options(std::move(options));
}

void SimulatedLink::set_options(LinkOptions options) {
  check_link_options(options);
  options_ = std::move(options);
}

std::optional<Timestamp> SimulatedLink::send(Timestamp sent, std::size_t bytes) {
  const std::uint64_t packet = packets_++;
  const auto luck = [&](Luck purpose) { return draw(options_.seed, packet, purpose); };
  Timestamp left = sent;
  if (options_.bandwidth > 0) {
    const Timestamp begins = queue_empty_ ? std::max(sent, *queue_empty_) : sent;
    if (begins - sent > options_.longest_queue) return std::nullopt;
    constexpr double kMostSeconds = 1e6;  // keeps the sum with any stamp within 64 bits
    left = begins + Duration::from_seconds(std::min(static_cast<double>(bytes) * 8 / options_.bandwidth, kMostSeconds));
    queue_empty_ = left;
  }
  // What is lost further on has been in the queue.
  if (luck(Luck::loss) < options_.loss) return std::nullopt;
  Duration delay = options_.delay;
  if (!options_.measured_delays.empty()) {
    const std::size_t count = options_.measured_delays.size();
    const auto pick = static_cast<std::size_t>(luck(Luck::measured) * static_cast<double>(count));
    delay = options_.measured_delays[std::min(pick, count - 1)];
  } else if (options_.jitter > Duration{}) {
    delay = delay + Duration::from_seconds(options_.jitter.seconds() * draw_normal(options_.seed, packet));
  }
  if (luck(Luck::reordering) < options_.reordering) delay = delay + options_.reordering_delay;
  Timestamp arrival = left + std::max(delay, Duration{});
  if (options_.in_order && last_arrival_) arrival = std::max(arrival, *last_arrival_);
  last_arrival_ = last_arrival_ ? std::max(arrival, *last_arrival_) : arrival;
  return arrival;
}

std::vector<Duration> parse_measured_delays(const std::string& text, const std::string& where) {
  std::vector<Duration> delays;
  std::istringstream lines(text);
  std::string line;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    line.erase(std::min(line.find('#'), line.size()));
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string::npos) continue;
    line = line.substr(begin, line.find_last_not_of(" \t\r") + 1 - begin);
    const std::string place = where + ":" + std::to_string(number);
    const Duration delay = Duration::parse(line, place);
    if (delay < Duration{} || delay > kLongestDelay) {
      throw InputError(place, "is no delay of a link; expected 0 to 3600 s");
    }
    if (delays.size() == kMostMeasuredDelays) throw InputError(place, "more delays than are accepted (10 million)");
    delays.push_back(delay);
  }
  if (delays.empty()) throw InputError(where, "holds no delay; expected one per line, as in '231ms'");
  return delays;
}

}  // namespace foreview
