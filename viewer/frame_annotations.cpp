#include "foreview/viewer/frame_annotations.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace foreview {
namespace {

const glm::vec4 kWhite{1, 1, 1, 1}, kInk{0.04F, 0.04F, 0.05F, 1}, kGround{0.04F, 0.04F, 0.05F, 0.72F};
const glm::vec4 kStale{0.86F, 0.10F, 0.06F, 1}, kSilent{0.72F, 0, 0.35F, 1};

float line_height(const FrameArea& area) {
  return std::clamp(static_cast<float>(area.height) / 24.0F, 13.0F, 48.0F);
}

struct Bar {
  glm::vec2 corner{0}, size{0};
  float line = 0;
};

/// Ground and title of a scale; the bar is between title and ticks.
Bar begin_scale(FramePainter& painter, const FrameArea& view, int place, std::string_view title) {
  const float line = 0.8F * line_height(view);
  const float height = 3.1F * line;
  const glm::vec2 size(std::min(12.0F * line, 0.9F * static_cast<float>(view.width)), height);
  const glm::vec2 corner(
      static_cast<float>(view.x) + 0.5F * line,
      static_cast<float>(view.y + view.height) - (static_cast<float>(place) + 1) * (height + 0.5F * line));
  painter.rectangle(corner, size, kGround);
  painter.text(corner + glm::vec2(0.6F * line, 0.1F * line), line, title, kWhite);
  return {corner + line * glm::vec2(0.6F, 1.2F), {size.x - 1.2F * line, 0.6F * line}, line};
}

/// `at` 0..1 along the bar.
void tick(FramePainter& painter, const Bar& bar, float at, std::string_view text) {
  const float x = bar.corner.x + at * bar.size.x;
  painter.rectangle({x - 0.5F, bar.corner.y}, {1, bar.size.y + 0.2F * bar.line}, kWhite);
  const float height = 0.85F * bar.line, width = painter.text_width(height, text);
  const float left =
      std::clamp(x - 0.5F * width, bar.corner.x - 0.3F * bar.line, bar.corner.x + bar.size.x - width + 0.3F * bar.line);
  painter.text({left, bar.corner.y + bar.size.y + 0.2F * bar.line}, height, text, kWhite);
}

}  // namespace

void paint_staleness(FramePainter& painter, const FrameArea& frame, const Staleness& staleness) {
  if (staleness.level < Staleness::Level::stale) return;
  const glm::vec4& colour = staleness.level == Staleness::Level::silent ? kSilent : kStale;
  const auto width = static_cast<float>(frame.width), height = static_cast<float>(frame.height);
  const glm::vec2 corner(frame.x, frame.y);
  const float border = std::clamp(0.02F * height, 4.0F, 24.0F);
  painter.rectangle(corner, {width, border}, colour);
  painter.rectangle(corner + glm::vec2(0, height - border), {width, border}, colour);
  painter.rectangle(corner, {border, height}, colour);
  painter.rectangle(corner + glm::vec2(width - border, 0), {border, height}, colour);
  float line = 1.4F * line_height(frame);
  const float wanted = painter.text_width(line, staleness.text);
  line *= std::min(1.0F, (width - 4 * border) / std::max(wanted, 1.0F));
  const float text_width = painter.text_width(line, staleness.text);
  painter.rectangle(corner + glm::vec2(0, border), {width, 1.3F * line}, colour);
  painter.text(corner + glm::vec2(0.5F * (width - text_width), border + 0.15F * line), line, staleness.text, kWhite);
}

void paint_split(FramePainter& painter, const FrameArea& frame, int line) {
  const auto x = static_cast<float>(line);
  const auto height = static_cast<float>(frame.height);
  painter.rectangle({x - 2, static_cast<float>(frame.y)}, {4, height}, kInk);
  painter.rectangle({x - 1, static_cast<float>(frame.y)}, {2, height}, kWhite);
}

void paint_age_scale(FramePainter& painter, const FrameArea& view, double span_seconds, int place) {
  const Bar bar = begin_scale(painter, view, place, "texture age, seconds");
  painter.scale(bar.corner, bar.size, FramePainter::Scale::age);
  char text[32];
  for (int i = 0; i <= 4; i += 2) {
    std::snprintf(text, sizeof text, "%s%.3g", i == 4 ? ">" : "", span_seconds * i / 4);
    tick(painter, bar, 0.25F * static_cast<float>(i), text);
  }
}

void paint_density_scale(FramePainter& painter, const FrameArea& view, int place) {
  const Bar bar = begin_scale(painter, view, place, "pixels per texel");
  painter.scale(bar.corner, bar.size, FramePainter::Scale::density);
  constexpr std::array<const char*, 7> kTicks{"1/8", "", "1/2", "1", "2", "", "8"};
  for (std::size_t i = 0; i < kTicks.size(); ++i) tick(painter, bar, static_cast<float>(i) / 6.0F, kTicks[i]);
}

void paint_note(FramePainter& painter, const FrameArea& view, std::string_view text) {
  const float line = 0.9F * line_height(view), width = painter.text_width(line, text);
  const glm::vec2 corner(static_cast<float>(view.x + view.width) - width - 1.7F * line,
                         static_cast<float>(view.y + view.height) - 1.7F * line);
  painter.rectangle(corner, {width + 1.2F * line, 1.2F * line}, kGround);
  painter.text(corner + line * glm::vec2(0.6F, 0.1F), line, text, kWhite);
}

}  // namespace foreview
