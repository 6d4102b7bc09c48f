#include "foreview/server/tf_buffer.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace foreview {
namespace {

constexpr double kFarthest = 1e9;          // metres, as in recordings
constexpr double kQuaternionSlack = 1e-2;  // likewise

/// ROS 1 wrote "/map" for what ROS 2 calls "map".
std::string plain(const std::string& frame) {
  return frame.starts_with('/') ? frame.substr(1) : frame;
}

std::optional<Pose> checked(const Pose& pose) {
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(pose.translation[i]) <= kFarthest)) return std::nullopt;
  }
  const double length = glm::length(pose.rotation);
  if (!(std::abs(length - 1) <= kQuaternionSlack)) return std::nullopt;
  // What is of unit length up to rounding stays as it was sent.
  constexpr double kRounding = 1e-12;
  return Pose{std::abs(length - 1) <= kRounding ? pose.rotation : pose.rotation / length, pose.translation};
}

}  // namespace

std::optional<Pose> TfBuffer::Link::at(Timestamp time) const {
  if (is_static) return samples.front().parent_from_child;
  const auto next = std::lower_bound(samples.begin(), samples.end(), time,
                                     [](const Sample& sample, Timestamp t) { return sample.stamp < t; });
  if (next == samples.end()) return std::nullopt;
  if (next->stamp == time) return next->parent_from_child;
  if (next == samples.begin()) return std::nullopt;
  const Sample& before = *(next - 1);
  const double fraction = (time - before.stamp).seconds() / (next->stamp - before.stamp).seconds();
  return interpolate(before.parent_from_child, next->parent_from_child, fraction);
}

bool TfBuffer::add(const std::string& parent_name, const std::string& child_name, Timestamp stamp,
                   const Pose& parent_from_child, bool is_static) {
  const std::string parent = plain(parent_name), child = plain(child_name);
  const std::optional<Pose> pose = checked(parent_from_child);
  if (!pose || parent.empty() || child.empty() || parent == child) return false;
  auto place = links_.find(child);
  if (place == links_.end()) {
    if (links_.size() >= options_.most_frames) return false;
    place = links_.emplace(child, Link{}).first;
  }
  Link& link = place->second;
  if (link.parent != parent || link.is_static != is_static || is_static) link.samples.clear();
  link.parent = parent;
  link.is_static = is_static;
  auto& samples = link.samples;
  if (samples.empty() || samples.back().stamp < stamp) {
    samples.push_back({stamp, *pose});
  } else {
    if (samples.back().stamp - stamp > options_.memory) return false;
    const auto next = std::lower_bound(samples.begin(), samples.end(), stamp,
                                       [](const Sample& sample, Timestamp t) { return sample.stamp < t; });
    if (next->stamp == stamp) return false;
    samples.insert(next, {stamp, *pose});
  }
  // The one before the first within `memory` stays: poses are known between the two.
  while (samples.size() > options_.most_samples ||
         (samples.size() > 2 && samples.back().stamp - samples[1].stamp > options_.memory)) {
    samples.pop_front();
  }
  return true;
}

std::vector<TfBuffer::Step> TfBuffer::way_up(const std::string& frame) const {
  std::vector<Step> steps;
  for (auto link = links_.find(frame); link != links_.end() && steps.size() <= links_.size();
       link = links_.find(steps.back().frame)) {
    steps.push_back({&link->second, link->second.parent});
  }
  return steps;
}

std::optional<TfBuffer::Chain> TfBuffer::chain(const std::string& target_name, const std::string& source_name) const {
  const std::string target = plain(target_name), source = plain(source_name);
  const std::vector<Step> up = way_up(source), other = way_up(target);
  // Where the ways meet: at most as far up as necessary, so that what moves above does not matter.
  for (std::size_t i = 0; i <= up.size(); ++i) {
    const std::string& meeting = i == 0 ? source : up[i - 1].frame;
    for (std::size_t k = 0; k <= other.size(); ++k) {
      if ((k == 0 ? target : other[k - 1].frame) != meeting) continue;
      Chain result;
      for (std::size_t n = 0; n < i; ++n) result.from_source.push_back(up[n].link);
      for (std::size_t n = 0; n < k; ++n) result.from_target.push_back(other[n].link);
      return result;
    }
  }
  return std::nullopt;
}

std::optional<Pose> TfBuffer::at(const std::string& target, const std::string& source, Timestamp time) const {
  const std::optional<Chain> links = chain(target, source);
  if (!links) return std::nullopt;
  const auto along = [&](const std::vector<const Link*>& way) -> std::optional<Pose> {
    std::optional<Pose> top_from_bottom;
    for (const Link* link : way) {
      const std::optional<Pose> pose = link->at(time);
      if (!pose) return std::nullopt;
      top_from_bottom = top_from_bottom ? *pose * *top_from_bottom : *pose;
    }
    return top_from_bottom ? top_from_bottom : Pose();
  };
  const std::optional<Pose> meeting_from_source = along(links->from_source);
  if (!meeting_from_source || links->from_target.empty()) return meeting_from_source;
  const std::optional<Pose> meeting_from_target = along(links->from_target);
  if (!meeting_from_target) return std::nullopt;
  return meeting_from_target->inverse() * *meeting_from_source;
}

std::optional<Timestamp> TfBuffer::newest(const std::string& target, const std::string& source, Timestamp now) const {
  const std::optional<Chain> links = chain(target, source);
  if (!links) return std::nullopt;
  std::optional<Timestamp> newest;
  for (const auto* way : {&links->from_source, &links->from_target}) {
    for (const Link* link : *way) {
      if (link->is_static) continue;
      // Cleared: known again when the next comes.
      if (link->samples.empty()) return std::nullopt;
      newest = std::min(newest.value_or(link->samples.back().stamp), link->samples.back().stamp);
    }
  }
  return newest.value_or(now);
}

bool TfBuffer::has(const std::string& frame) const {
  return links_.count(plain(frame)) != 0;
}

std::size_t TfBuffer::samples() const {
  std::size_t count = 0;
  for (const auto& [child, link] : links_) count += link.samples.size();
  return count;
}

void TfBuffer::clear_moving() {
  std::erase_if(links_, [](const auto& entry) { return !entry.second.is_static; });
}

}  // namespace foreview
