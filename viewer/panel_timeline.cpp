#include <imgui.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "foreview/viewer/interface_theme.h"
#include "foreview/viewer/interface_widgets.h"
#include "foreview/viewer/panels.h"

namespace foreview {
namespace {

void show_transport(const PanelInput& input) {
  using widgets::Icon;
  ViewerControl& control = input.control;
  const PlaybackClock& clock = *control.clock();
  const auto button = [&](const char* id, Icon icon, ViewerAction action, const char* what, bool lit = false) {
    const std::string text = std::string(what) + " (" + keys_of(action) + ")";
    if (widgets::icon_button(id, icon, lit, input.em, text.c_str())) control.act(action);
    ImGui::SameLine(0, ImGui::GetStyle().ItemInnerSpacing.x * 0.5F);
  };
  const bool running = clock.playing() && !clock.at_end();
  button("##start", Icon::to_start, ViewerAction::to_start, "To the start");
  button("##back", Icon::step_back, ViewerAction::step_back, "To the picture before");
  button("##play", running ? Icon::pause : Icon::play, ViewerAction::pause, running ? "Pause" : "Play", running);
  button("##forward", Icon::step_forward, ViewerAction::step_forward, "To the picture after");
  button("##end", Icon::to_end, ViewerAction::to_end, "To the end");
  button("##loop", Icon::loop, ViewerAction::toggle_loop, "Begin anew at the end", clock.loop());
}

/// The scrubber: a slider over the recording's time, with the newest picture's capture marked behind it, so that one
/// sees how far the view is ahead.
void show_scrubber(const PanelInput& input, float width) {
  ViewerControl& control = input.control;
  const PlaybackClock& clock = *control.clock();
  const Duration span = clock.last() - clock.first();
  const auto length = static_cast<float>(std::max(span.seconds(), 1e-3));
  auto position = static_cast<float>((input.status.now - clock.first()).seconds());
  // Beside the line, where the grab does not cover it; where there is no room for that, the window's title has it.
  const std::string whole = time_text(span), text = time_text(input.status.now - clock.first()) + " / " + whole;
  const float beside = ImGui::CalcTextSize((whole + " / " + whole).c_str()).x + 2 * ImGui::GetStyle().ItemSpacing.x;
  const bool has_room = width - beside > input.em * 6;
  if (has_room) {
    const float right = ImGui::GetCursorPosX() + beside - ImGui::GetStyle().ItemSpacing.x;
    ImGui::SetCursorPosX(right - ImGui::CalcTextSize(text.c_str()).x);
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(text.c_str());
    ImGui::SameLine();
  }
  ImGui::SetNextItemWidth(has_room ? width - beside : width);
  if (ImGui::SliderFloat("##time", &position, 0, length, "", ImGuiSliderFlags_NoInput)) {
    control.scrub(clock.first() + Duration::from_seconds(static_cast<double>(position)));
  }
  const ImVec2 from = ImGui::GetItemRectMin(), to = ImGui::GetItemRectMax();
  if (input.status.newest_picture) {
    const float at = static_cast<float>((*input.status.newest_picture - clock.first()).seconds()) / length;
    // The grab's centre moves within the frame less its own width, and so does this.
    const float margin = 2 + ImGui::GetStyle().GrabMinSize / 2;
    const float x = from.x + margin + std::clamp(at, 0.0F, 1.0F) * (to.x - from.x - 2 * margin);
    ImGui::GetWindowDrawList()->AddRectFilled({x - 1, from.y + 1}, {x + 1, to.y - 1}, interface_colour::kWarning);
    if (ImGui::IsItemHovered() && !ImGui::IsItemActive()) {
      widgets::tooltip("Time shown; the line marks when the newest picture in the textures was taken, " +
                       age_text(input.status.now - *input.status.newest_picture) + " before");
    }
  }
}

void show_speed(const PanelInput& input, float width) {
  PlaybackClock& clock = *input.control.clock();
  char text[16];
  std::snprintf(text, sizeof text, "%gx", clock.speed());
  ImGui::SetNextItemWidth(width);
  if (ImGui::BeginCombo("##speed", text, ImGuiComboFlags_HeightLarge)) {
    for (const double speed : ViewerControl::kSpeeds) {
      std::snprintf(text, sizeof text, "%gx", speed);
      const bool is_chosen = speed == clock.speed();
      if (ImGui::Selectable(text, is_chosen)) clock.set_speed(speed);
      if (is_chosen) ImGui::SetItemDefaultFocus();
    }
    ImGui::EndCombo();
  }
  widgets::tooltip("Speed (" + keys_of(ViewerAction::slower) + ", " + keys_of(ViewerAction::faster) + ")");
}

}  // namespace

void show_timeline(const PanelInput& input) {
  ImGui::SetCursorPosY((ImGui::GetWindowHeight() - ImGui::GetFrameHeight()) / 2);
  if (input.control.clock() == nullptr) {
    ImGui::AlignTextToFramePadding();
    ImGui::Text("live: %s", input.status.name.c_str());
    ImGui::SameLine();
    ImGui::TextDisabled("no pause, no way back: it happens now; foreview record keeps it");
    return;
  }
  show_transport(input);
  const float speed_width = input.em * 4.8F, gap = ImGui::GetStyle().ItemSpacing.x;
  show_scrubber(input, std::max(ImGui::GetContentRegionAvail().x - speed_width - gap, input.em * 4));
  ImGui::SameLine();
  show_speed(input, speed_width);
}

}  // namespace foreview
