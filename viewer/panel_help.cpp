#include <imgui.h>

#include <algorithm>
#include <cstring>

#include "foreview/viewer/interface_theme.h"
#include "foreview/viewer/panels.h"

namespace foreview {
namespace {

void show_rows(const std::vector<KeyRow>& rows, std::size_t from, std::size_t to) {
  const char* group = "";
  for (std::size_t i = from; i < to; ++i) {
    if (std::strcmp(group, rows[i].group) != 0) {
      if (i > from) ImGui::Spacing();
      group = rows[i].group;
      ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(interface_colour::kAccent), "%s", group);
    }
    ImGui::TextUnformatted(rows[i].keys.c_str());
    ImGui::SameLine(ImGui::GetFontSize() * 8.5F);
    ImGui::PushTextWrapPos(0);
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    ImGui::TextUnformatted(rows[i].effect);
    ImGui::PopStyleColor();
    ImGui::PopTextWrapPos();
  }
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
  bool open = true;
  if (ImGui::Begin("Keys and mouse", &open,
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                       ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_AlwaysAutoResize)) {
    const std::vector<KeyRow>& rows = key_rows();
    const bool two_columns = width > input.em * 44;
    const std::size_t split = two_columns ? middle(rows) : rows.size();
    if (ImGui::BeginTable("keys", two_columns ? 2 : 1, ImGuiTableFlags_PadOuterX)) {
      ImGui::TableNextColumn();
      show_rows(rows, 0, split);
      if (two_columns) {
        ImGui::TableNextColumn();
        show_rows(rows, split, rows.size());
      }
      ImGui::EndTable();
    }
  }
  ImGui::End();
  if (!open) input.control.settings().help = false;
}

}  // namespace foreview
