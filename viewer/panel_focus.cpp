#include "foreview/viewer/panel_focus.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <vector>

namespace foreview {
namespace {

/// Panels that the keyboard can go to, in the order in which they are shown.
std::vector<ImGuiWindow*> panels_with_keys() {
  constexpr ImGuiWindowFlags kWithout =
      ImGuiWindowFlags_NoNavInputs | ImGuiWindowFlags_ChildWindow | ImGuiWindowFlags_Tooltip | ImGuiWindowFlags_Popup;
  std::vector<ImGuiWindow*> panels;
  for (ImGuiWindow* window : ImGui::GetCurrentContext()->Windows) {
    // Dear ImGui has a window of its own for what is outside all others.
    if (window->Active && !window->IsFallbackWindow && (window->Flags & kWithout) == 0) panels.push_back(window);
  }
  std::ranges::sort(panels, {}, [](const ImGuiWindow* window) { return window->BeginOrderWithinContext; });
  return panels;
}

}  // namespace

void PanelFocus::begin() {
  const ImGuiContext& context = *ImGui::GetCurrentContext();
  const bool busy = ImGui::IsAnyItemActive() || ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup);
  if (context.NavWindowingTarget != nullptr) entered_ = true;  // Ctrl+Tab
  // Without this a click into a panel would take the keys with it.
  if (!entered_ && !busy && context.NavWindow != nullptr) ImGui::SetWindowFocus(nullptr);
}

void PanelFocus::remember() {
  const ImGuiContext& context = *ImGui::GetCurrentContext();
  const ImGuiWindow* window = context.NavWindow;
  if (!entered_ || window == nullptr || context.NavId == 0 || context.NavLayer != ImGuiNavLayer_Main ||
      (window->Flags & (ImGuiWindowFlags_Popup | ImGuiWindowFlags_ChildWindow)) != 0) {
    return;
  }
  auto place = std::ranges::find(places_, window->ID, &Place::panel);
  if (place == places_.end()) place = places_.insert(places_.end(), Place{window->ID, 0, {}});
  const ImRect& area = window->NavRectRel[ImGuiNavLayer_Main];
  *place = {window->ID, context.NavId, {area.Min.x, area.Min.y, area.Max.x, area.Max.y}};
}

void PanelFocus::end() {
  // Dear ImGui forgets it when Escape is pressed.
  remember();
  if (!entering_) return;
  entering_ = false;
  const std::vector<ImGuiWindow*> panels = panels_with_keys();
  if (panels.empty()) return;
  ImGuiContext& context = *ImGui::GetCurrentContext();
  if (entered_) {
    const auto current = std::ranges::find(panels, context.NavWindow);
    ImGui::FocusWindow(current == panels.end() || current + 1 == panels.end() ? panels.front() : *(current + 1));
  } else {
    // The one on top is the one that had it last.
    ImGui::FocusTopMostWindowUnderOne(nullptr, nullptr);
  }
  if (ImGuiWindow* window = context.NavWindow) {
    const auto place = std::ranges::find(places_, window->ID, &Place::panel);
    if (place == places_.end()) {
      ImGui::NavInitWindow(window, true);
    } else {
      const auto& area = place->area;
      ImGui::SetNavID(place->control, ImGuiNavLayer_Main, 0, ImRect(area[0], area[1], area[2], area[3]));
    }
    context.NavDisableHighlight = false;
    entered_ = true;
  }
}

void PanelFocus::leave() {
  if (!ImGui::IsAnyItemActive() && !ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup)) entered_ = false;
}

bool PanelFocus::wants_keys() const {
  return entered_ || ImGui::GetIO().WantTextInput || ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup);
}

}  // namespace foreview
