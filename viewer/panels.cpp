#include "foreview/viewer/panels.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <string>

#include "foreview/viewer/interface_theme.h"
#include "foreview/viewer/interface_widgets.h"

namespace foreview {
namespace {

constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus;

void place(const PanelLayout::Area& area) {
  ImGui::SetNextWindowPos({area.x, area.y});
  ImGui::SetNextWindowSize({area.width, area.height});
}

void section(const char* name, bool open, void (*show)(const PanelInput&), const PanelInput& input) {
  ImGui::SetNextItemOpen(open, ImGuiCond_Once);
  if (!ImGui::CollapsingHeader(name)) return;
  ImGui::PushID(name);
  ImGui::Dummy({0, 0});
  show(input);
  ImGui::Dummy({0, input.em * 0.3F});
  ImGui::PopID();
}

/// At the top, so that no window is too low for it.
void show_actions(const PanelInput& input) {
  struct Entry {
    const char* name;
    ViewerAction action;
    const char* tip;
  };
  constexpr std::array<Entry, 4> kEntries{
      Entry{"Save", ViewerAction::save_picture, "What is shown, in the camera's own size, as PNG"},
      Entry{"Copy", ViewerAction::copy_command,
            "The command line that shows the same without a window, into the clipboard"},
      Entry{"Keys", ViewerAction::toggle_help, "All keys"},
      Entry{"Hide", ViewerAction::toggle_panels, "The panels; the same key shows them again"},
  };
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
  const float width = (ImGui::GetContentRegionAvail().x - gap * (kEntries.size() - 1)) / kEntries.size();
  for (const Entry& entry : kEntries) {
    if (&entry != kEntries.data()) ImGui::SameLine(0, gap);
    if (ImGui::Button(entry.name, {width, 0})) input.control.act(entry.action);
    widgets::tooltip(std::string(entry.tip) + " (" + keys_of(entry.action) + ")");
  }
}

void show_side(const PanelInput& input, const PanelLayout& layout) {
  place(layout.side);
  if (ImGui::Begin("Panels", nullptr, kFixed)) {
    show_actions(input);
    ImGui::Dummy({0, input.em * 0.1F});
    section("View", true, show_view_panel, input);
    section("Link", true, show_link_panel, input);
    if (input.control.settings().probe) section("Polygon under the cursor", true, show_polygon_panel, input);
    section("Status", true, show_status_panel, input);
    section("Extraction", false, show_extraction_panel, input);
  }
  ImGui::End();
}

/// Over the view, at its lower left: also where panels are hidden.
void show_message(const PanelInput& input, const PanelLayout& layout) {
  if (input.status.message.empty()) return;
  const float inset = input.em * 0.7F;
  ImGui::SetNextWindowPos({layout.view.x + inset, layout.view.y + layout.view.height - inset}, ImGuiCond_Always,
                          {0, 1});
  ImGui::SetNextWindowSizeConstraints({0, 0}, {std::max(layout.view.width - 2 * inset, 1.0F), layout.view.height});
  ImGui::SetNextWindowBgAlpha(0.85F);
  if (ImGui::Begin("Message", nullptr,
                   kFixed | ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_AlwaysAutoResize)) {
    ImGui::PushTextWrapPos(layout.view.width - 3 * inset);
    if (input.status.message_is_error) {
      ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(interface_colour::kWarning), "%s",
                         input.status.message.c_str());
    } else {
      ImGui::TextUnformatted(input.status.message.c_str());
    }
    ImGui::PopTextWrapPos();
  }
  ImGui::End();
}

}  // namespace

void show_panels(const PanelInput& input, const PanelLayout& layout) {
  if (layout.panels) {
    show_side(input, layout);
    place(layout.timeline);
    if (ImGui::Begin("Timeline", nullptr, kFixed | ImGuiWindowFlags_NoScrollbar)) show_timeline(input);
    ImGui::End();
  }
  show_message(input, layout);
  if (input.control.settings().help) show_help(input, layout);
}

}  // namespace foreview
