#include "foreview/recordings/tum_parsing.h"

#include <cmath>

#include "foreview/recordings/stamp_order.h"
#include "foreview/recordings/text_lines.h"
#include "foreview/scene/input_file.h"

namespace foreview {
namespace {

constexpr double kLargestPosition = 1e9;  // metres; no site is larger, and products of such numbers stay finite
constexpr double kUnitTolerance = 1e-2;

struct PoseLine {
  Timestamp stamp;
  Pose pose;
  std::size_t line;
};

}  // namespace

bool stays_inside(const std::filesystem::path& relative) {
  if (relative.empty() || relative.is_absolute() || relative.has_root_name()) return false;
  for (const std::filesystem::path& step : relative) {
    if (step == "..") return false;
  }
  return true;
}

std::vector<ListedPicture> parse_picture_list(std::string_view text, const std::string& file, DamageLog& damage) {
  std::vector<ListedPicture> pictures;
  for_each_line(text, [&](std::size_t number, std::string_view line) {
    const auto drop = [&](const std::string& why) {
      damage.note(&RecordingDamage::lines_malformed, file + ":" + std::to_string(number), why);
    };
    if (line.size() > kLongestLine || line.find('\0') != std::string_view::npos) return drop("is no text");
    std::string_view rest = line;
    const std::string_view word = take_word(rest);
    Timestamp stamp;
    if (!parse_stamp(word, stamp)) return drop(in_quotes(word) + " is no stamp in seconds");
    if (rest.empty()) return drop("expected 'stamp file'");
    if (!stays_inside(std::string(rest))) return drop(in_quotes(rest) + " leads out of the recording");
    pictures.push_back({stamp, std::string(rest), number});
  });
  sort_by_stamp(pictures, file, damage);
  return pictures;
}

Trajectory parse_trajectory(std::string_view text, const std::string& file, DamageLog& damage) {
  std::vector<PoseLine> poses;
  for_each_line(text, [&](std::size_t number, std::string_view line) {
    const auto drop = [&](DamageLog::Kind kind, const std::string& why) {
      damage.note(kind, file + ":" + std::to_string(number), why);
    };
    constexpr DamageLog::Kind kMalformed = &RecordingDamage::lines_malformed;
    if (line.size() > kLongestLine) return drop(kMalformed, "is no text");
    std::string_view rest = line;
    const std::string_view first = take_word(rest);
    Timestamp stamp;
    if (!parse_stamp(first, stamp)) return drop(kMalformed, in_quotes(first) + " is no stamp in seconds");
    double v[7];
    bool is_finite = true;
    for (double& value : v) {
      const std::string_view word = take_word(rest);
      if (!parse_number(word, value)) {
        return drop(kMalformed, in_quotes(line) + "; expected 'stamp tx ty tz qx qy qz qw'");
      }
      is_finite = is_finite && std::abs(value) <= kLargestPosition;
    }
    if (!rest.empty() && rest.front() != '#') {
      return drop(kMalformed, "more than 8 numbers; expected 'stamp tx ty tz qx qy qz qw'");
    }
    if (!is_finite) return drop(&RecordingDamage::poses_not_finite, in_quotes(line));
    const glm::dquat rotation(v[6], v[3], v[4], v[5]);
    const double length = std::sqrt(glm::dot(rotation, rotation));
    if (!(std::abs(length - 1) <= kUnitTolerance)) {
      return drop(&RecordingDamage::poses_not_unit, "the quaternion's length is " + number_text(length));
    }
    poses.push_back({stamp, {rotation / length, {v[0], v[1], v[2]}}, number});
  });
  sort_by_stamp(poses, file, damage);
  Trajectory trajectory;
  for (const PoseLine& pose : poses) trajectory.add(pose.stamp, pose.pose);
  return trajectory;
}

}  // namespace foreview
