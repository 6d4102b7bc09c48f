#include <imgui.h>

#include <algorithm>
#include <cstring>

#include "foreview/viewer/interface_theme.h"
#include "foreview/viewer/panels.h"

namespace foreview {
namespace {

void show_rows(const char* id, const std::vector<KeyRow>& rows, std::size_t from, std::size_t to, float em,
               float width) {
  if (!ImGui::BeginTable(id, 2, ImGuiTableFlags_None, {width, 0})) return;
  ImGui::TableSetupColumn("keys", ImGuiTableColumnFlags_WidthFixed, em * 10.5F);
  ImGui::TableSetupColumn("effect", ImGuiTableColumnFlags_WidthStretch);
  const char* group = "";
  for (std::size_t i = from; i < to; ++i) {
    if (std::strcmp(group, rows[i].group) != 0) {
      group = rows[i].group;
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      if (i > from) ImGui::Dummy({0, em * 0.2F});
      ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(interface_colour::kAccent), "%s", group);
    }
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::PushTextWrapPos(0);
    ImGui::TextUnformatted(rows[i].keys.c_str());
    ImGui::TableNextColumn();
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0.68F, 0.69F, 0.71F, 1));
    ImGui::TextUnformatted(rows[i].effect);
    ImGui::PopStyleColor();
    ImGui::PopTextWrapPos();
  }
  ImGui::EndTable();
}

/// Where the second column begins: the start of a group, near the middle.
std::size_t middle(const std::vector<KeyRow>& rows) {
  std::size_t best = rows.size();
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (std::strcmp(rows[i].group, rows[i - 1].group) == 0) continue;
    const auto distance = [&](std::size_t at) {
      return at > rows.size() / 2 ? at - rows.size() / 2 : rows.size() / 2 - at;
    };
    if (best == rows.size() || distance(i) < distance(best)) best = i;
  }
  return best;
}

}  // namespace

void show_help(const PanelInput& input, const PanelLayout& layout) {
  const float whole_width = layout.panels ? layout.side.x + layout.side.width : layout.view.width;
  const float whole_height = std::max(layout.view.height, layout.side.height);
  const float width = std::min(whole_width - input.em, input.em * 62);
  ImGui::SetNextWindowPos({whole_width / 2, whole_height / 2}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, std::max(whole_height - input.em, input.em)});
  // The panels behind must not shine through between the lines.
  ImGui::SetNextWindowBgAlpha(1);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1);
  bool open = true;
  if (ImGui::Begin("Keys and mouse", &open,
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                       ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_AlwaysAutoResize)) {
    const std::vector<KeyRow>& rows = key_rows();
    const bool two_columns = width > input.em * 44;
    const std::size_t split = two_columns ? middle(rows) : rows.size();
    const float room = ImGui::GetContentRegionAvail().x;
    const float column = two_columns ? (room - input.em) / 2 : room;
    show_rows("left", rows, 0, split, input.em, column);
    if (two_columns) {
      ImGui::SameLine(0, input.em);
      show_rows("right", rows, split, rows.size(), input.em, column);
    }
  }
  ImGui::End();
  ImGui::PopStyleVar();
  if (!open) input.control.settings().help = false;
}

}  // namespace foreview
