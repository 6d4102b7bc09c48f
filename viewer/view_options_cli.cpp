#include "foreview/viewer/view_options_cli.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <limits>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

constexpr double kDegrees = 57.29577951308232;  // in a radian
constexpr double kFarthest = 1e9;               // metres, of poses

std::string to_text(double number) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), error == std::errc() ? end : text.data()};
}

/// A text from outside as an error's one line may have it.
std::string shown(const std::string& text) {
  constexpr std::size_t kMost = 80;
  std::string result = text.substr(0, kMost);
  for (char& c : result) {
    if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) c = '?';
  }
  return "'" + result + (text.size() > kMost ? "...'" : "'");
}

/// Numbers between blanks or commas; empty unless all of the text is finite numbers, `count` of them.
std::vector<double> read_numbers(const std::string& text, std::size_t count) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto is_gap = [](char c) { return c == ' ' || c == ',' || c == '\t'; };
  while (true) {
    while (at != end && is_gap(*at)) ++at;
    if (at == end) break;
    double number = 0;
    const auto [stop, error] = std::from_chars(at, end, number);
    if (error != std::errc() || !std::isfinite(number) || numbers.size() == count) return {};
    if (stop != end && !is_gap(*stop)) return {};
    numbers.push_back(number);
    at = stop;
  }
  return numbers.size() == count ? numbers : std::vector<double>();
}

double parse_number(const std::string& text, const std::string& option, double least, double greatest,
                    const std::string& what) {
  const std::vector<double> number = read_numbers(text, 1);
  if (number.empty() || !(number[0] >= least && number[0] <= greatest)) {
    throw InputError(
        option, shown(text) + " cannot be; expected " + what + " from " + to_text(least) + " to " + to_text(greatest));
  }
  return number[0];
}

template <class Values>
std::string listed(const Values& values) {
  std::string result;
  for (std::size_t i = 0; i < values.size(); ++i) {
    result += (i == 0 ? "" : i + 1 == values.size() ? " or " : ", ") + std::string(to_string(values[i]));
  }
  return result;
}

template <class Parse, class Values>
auto parse_name(const std::string& text, const std::string& option, const Parse& parse, const Values& values) {
  const auto value = parse(text);
  if (!value) throw InputError(option, shown(text) + " is not known; expected " + listed(values));
  return *value;
}

/// Each option is read by a function that is given its text and its name: so that our own errors name it.
template <typename Function>
void add(CLI::App& command, const std::string& name, const char* type, const std::string& help, Function&& read) {
  command
      .add_option_function<std::string>(
          name, [name, read](const std::string& text) { read(text, name); }, help)
      ->type_name(type);
}

struct Flag {
  const char* name;
  bool Overlays::*member;
  const char* help;
};
constexpr std::array<Flag, 7> kFlags{{
    {"--edges", &Overlays::edges, "The model's edges over the delayed picture, where its camera was"},
    {"--holes", &Overlays::holes, "Holes in pink"},
    {"--never-seen", &Overlays::never_seen, "Hatch polygons that no picture has shown"},
    {"--age", &Overlays::age, "Heat map of how old the textures are"},
    {"--texel-density", &Overlays::density, "Heat map of how many pixels a texel covers"},
    {"--wireframe", &Overlays::wireframe, "The model's edges over the predicted view"},
    {"--cone", &Overlays::cone, "Light what the newest picture's camera saw, and draw its field of view"},
}};

}  // namespace

Pose parse_pose(const std::string& text, const std::string& option) {
  const std::vector<double> n = read_numbers(text, 7);
  const auto refuse = [&](const char* why) -> InputError {
    return {option, shown(text) + " " + why + "; expected \"x y z qx qy qz qw\", metres and a unit quaternion"};
  };
  if (n.empty()) throw refuse("is not seven numbers");
  Pose pose{{n[6], n[3], n[4], n[5]}, {n[0], n[1], n[2]}};
  for (int i = 0; i < 3; ++i) {
    if (std::abs(pose.translation[i]) > kFarthest) throw refuse("is too far away");
  }
  const double length = glm::length(pose.rotation);
  if (!(std::abs(length - 1) <= 1e-2)) throw refuse("has no unit quaternion");
  pose.rotation /= length;
  return pose;
}

std::string to_text(const Pose& pose) {
  std::string result;
  for (const double number : {pose.translation.x, pose.translation.y, pose.translation.z, pose.rotation.x,
                              pose.rotation.y, pose.rotation.z, pose.rotation.w}) {
    result += (result.empty() ? "" : " ") + to_text(number);
  }
  return result;
}

void add_view_options(CLI::App& command, ViewChoice& choice) {
  using Text = const std::string&;
  add(command, "--view", "VIEW",
      "What is shown, in a window to begin with: " + listed(kViewModes) + " (default: predicted)",
      [&choice](Text text, Text option) { choice.mode = parse_name(text, option, parse_view_mode, kViewModes); });
  add(command, "--split", "PART", "Where split's line is, from 0 (left) to 1 (right) (default: 0.5)",
      [&choice](Text text, Text option) { choice.split = parse_number(text, option, 0, 1, "a part of the width"); });
  add(command, "--quality", "QUALITY",
      "Of frames: full, fast (less filtering, hard edges: a sixth of the time in software) or auto (what fits the "
      "rate; "
      "full for pictures) (default: auto)",
      [&choice](Text text, Text option) {
        if (text == "auto") return;
        if (!parse_view_quality(text)) {
          throw InputError(option, shown(text) + " is not known; expected full, fast or auto");
        }
        choice.quality = *parse_view_quality(text);
      });
  for (const Flag& flag : kFlags) command.add_flag(flag.name, choice.overlays.*flag.member, flag.help);
  add(command, "--age-span", "SECONDS", "Upper end of --age's scale (default: 10)",
      [&choice](Text text, Text option) { choice.age_span = parse_number(text, option, 0.01, 1e6, "seconds"); });
  add(command, "--polygon", "N", "Highlight this polygon, and less so what shares its chart",
      [&choice](Text text, Text option) {
        std::uint32_t polygon = 0;
        const char* const end = text.data() + text.size();
        const auto [stop, error] = std::from_chars(text.data(), end, polygon);
        if (error != std::errc() || stop != end) {
          throw InputError(option, shown(text) + " cannot be; expected a polygon's number, from 0 on");
        }
        choice.polygon = polygon;
      });
  add(command, "--camera-mode", "MODE", "Where the view is seen from: " + listed(kCameraModes) + " (default: follow)",
      [&choice](Text text, Text option) { choice.camera = parse_name(text, option, parse_camera_mode, kCameraModes); });
  add(command, "--camera-pose", "POSE",
      "free, overview: where the camera is, as --camera-pose=\"x y z qx qy qz qw\" (metres; world from camera)",
      [&choice](Text text, Text option) { choice.pose = parse_pose(text, option); });
  add(command, "--camera-turn", "ANGLES",
      "look-around: degrees to the right and down, as --camera-turn=\"20 -5\" (default: 0 0)",
      [&choice](Text text, Text option) {
        const std::vector<double> angles = read_numbers(text, 2);
        if (angles.empty() || std::max(std::abs(angles[0]), std::abs(angles[1])) > 36000) {
          throw InputError(option, shown(text) + " cannot be; expected two angles in degrees, as in \"20 -5\"");
        }
        choice.turn = glm::dvec2(angles[0], angles[1]) / kDegrees;
      });
  add(command, "--fov", "DEGREES",
      "Field of view from the frame's top to its bottom, from 1 to 160 (default: the camera's own)",
      [&choice](Text text, Text option) {
        choice.field_of_view = parse_number(text, option, 1, 160, "an angle in degrees") / kDegrees;
      });
}

std::vector<std::string> to_view_arguments(const ViewChoice& choice) {
  const ViewChoice usual;
  std::vector<std::string> words;
  const auto give = [&](const std::string& option, const std::string& value) {
    words.push_back(option + "=" + value);  // "=": a value may begin with a minus
  };
  if (choice.mode != usual.mode) give("--view", to_string(choice.mode));
  if (choice.split != usual.split) give("--split", to_text(choice.split));
  if (choice.quality != usual.quality) give("--quality", to_string(choice.quality));
  for (const Flag& flag : kFlags) {
    if (choice.overlays.*flag.member) words.emplace_back(flag.name);
  }
  if (choice.age_span != usual.age_span) give("--age-span", to_text(choice.age_span));
  if (choice.polygon) give("--polygon", std::to_string(*choice.polygon));
  if (choice.camera != usual.camera) give("--camera-mode", to_string(choice.camera));
  if (choice.pose) give("--camera-pose", to_text(*choice.pose));
  if (choice.turn != usual.turn) {
    give("--camera-turn", to_text(choice.turn.x * kDegrees) + " " + to_text(choice.turn.y * kDegrees));
  }
  if (choice.field_of_view) give("--fov", to_text(*choice.field_of_view * kDegrees));
  return words;
}

}  // namespace foreview
