#include "foreview/recordings/joints_parsing.h"

#include <cmath>
#include <set>
#include <utility>

#include "foreview/recordings/stamp_order.h"
#include "foreview/recordings/text_lines.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"

namespace foreview {
namespace {

constexpr std::size_t kMostJoints = 256;

struct JointLine {
  Timestamp stamp;
  std::vector<double> positions;
  std::size_t line;
};

std::string_view take_cell(std::string_view& line) {
  const std::size_t comma = line.find(',');
  const std::string_view cell = trim(line.substr(0, comma));
  line.remove_prefix(comma == std::string_view::npos ? line.size() : comma + 1);
  return cell;
}

std::vector<std::string> parse_header(std::string_view line, const std::string& place) {
  const std::string_view first = take_cell(line);
  if (first != "stamp" && first != "timestamp" && first != "time") {
    throw InputError(place, "begins with " + in_quotes(first) + "; expected the header 'stamp,joint1,...'");
  }
  std::vector<std::string> names;
  std::set<std::string> seen;
  while (!line.empty()) {
    const std::string name(take_cell(line));
    if (name.empty()) throw InputError(place, "a joint has no name");
    if (!seen.insert(name).second) throw InputError(place, "joint " + in_quotes(name) + " is there twice");
    if (names.size() == kMostJoints) throw InputError(place, "more than " + std::to_string(kMostJoints) + " joints");
    names.push_back(name);
  }
  if (names.empty()) throw InputError(place, "names no joint; expected the header 'stamp,joint1,...'");
  return names;
}

}  // namespace

Recording::Joints parse_joints(std::string_view text, const std::string& file, DamageLog& damage) {
  Recording::Joints joints;
  std::vector<JointLine> lines;
  for_each_line(text, [&](std::size_t number, std::string_view line) {
    const std::string place = file + ":" + std::to_string(number);
    if (joints.names.empty()) {
      joints.names = parse_header(line, place);
      return;
    }
    const auto drop = [&](const std::string& why) { damage.note(&RecordingDamage::lines_malformed, place, why); };
    if (line.size() > kLongestLine) return drop("is no text");
    std::string_view rest = line;
    const std::string_view first = take_cell(rest);
    JointLine result{{}, {}, number};
    if (!parse_stamp(first, result.stamp)) return drop(in_quotes(first) + " is no stamp in seconds");
    while (!rest.empty()) {
      const std::string_view cell = take_cell(rest);
      double position = 0;
      if (!parse_number(cell, position) || !std::isfinite(position)) {
        return drop(in_quotes(cell) + " is no joint position");
      }
      result.positions.push_back(position);
    }
    if (result.positions.size() != joints.names.size()) {
      return drop("has " + std::to_string(result.positions.size()) + " positions; expected " +
                  std::to_string(joints.names.size()));
    }
    lines.push_back(std::move(result));
  });
  if (joints.names.empty()) throw InputError(file, "is empty; expected the header 'stamp,joint1,...'");
  sort_by_stamp(lines, file, damage);
  for (JointLine& line : lines) {
    joints.stamps.push_back(line.stamp);
    joints.positions.push_back(std::move(line.positions));
  }
  return joints;
}

}  // namespace foreview
