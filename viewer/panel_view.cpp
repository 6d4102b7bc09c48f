#include <imgui.h>

#include <array>

#include "foreview/viewer/interface_widgets.h"
#include "foreview/viewer/panels.h"

namespace foreview {
namespace {

void show_modes(const PanelInput& input) {
  constexpr std::array<const char*, 3> kUpper{"Predicted", "Delayed", "Side by side"};
  constexpr std::array<const char*, 2> kLower{"Split", "Difference"};
  constexpr std::array kActions{ViewerAction::view_predicted, ViewerAction::view_delayed,
                                ViewerAction::view_side_by_side, ViewerAction::view_split,
                                ViewerAction::view_difference};
  const std::array<std::string, 5> tips{
      "What the operator sees: the model, textured by the pictures that have come (" + keys_of(kActions[0]) + ")",
      "The newest picture as it came (" + keys_of(kActions[1]) + ")", "Both (" + keys_of(kActions[2]) + ")",
      "Predicted at the left of a line, delayed at its right; drag the line (" + keys_of(kActions[3]) + ")",
      "Between the predicted view and the picture that was really taken at that moment (" + keys_of(kActions[4]) + ")"};
  const ViewMode mode = input.control.settings().choice.mode;
  const int chosen = static_cast<int>(mode);
  const int upper = widgets::choice_row("modes", kUpper.data(), 3, chosen, tips.data());
  const int lower = widgets::choice_row("more modes", kLower.data(), 2, chosen - 3, tips.data() + 3);
  if (upper >= 0) input.control.act(kActions[static_cast<std::size_t>(upper)]);
  if (lower >= 0) input.control.act(kActions[static_cast<std::size_t>(lower) + 3]);
  if (mode == ViewMode::difference && !input.status.truth_known) {
    ImGui::TextDisabled("no picture was taken at this moment");
  }
}

void show_camera(const PanelInput& input) {
  struct Entry {
    CameraMode mode;
    const char* name;
    const char* tip;
  };
  constexpr std::array<Entry, 4> kEntries{
      Entry{CameraMode::follow, "Recorded", "Where the camera really was"},
      Entry{CameraMode::look_around, "Look around", "At the recorded place, turned with the mouse"},
      Entry{CameraMode::free, "Free", "Anywhere: left drag turns, right drag moves, the wheel goes nearer"},
      Entry{CameraMode::overview, "Overview", "From above and behind, with what the camera sees lit"},
  };
  const CameraMode mode = input.control.camera().mode();
  const char* name = "";
  for (const Entry& entry : kEntries) {
    if (entry.mode == mode) name = entry.name;
  }
  widgets::label("Camera", input.em);
  if (ImGui::BeginCombo("##camera", name)) {
    for (const Entry& entry : kEntries) {
      if (ImGui::Selectable(entry.name, entry.mode == mode)) input.control.set_camera_mode(entry.mode);
      if (entry.mode == mode) ImGui::SetItemDefaultFocus();
      widgets::tooltip(entry.tip);
    }
    ImGui::EndCombo();
  }
  widgets::tooltip("From where the scene is looked at (" + keys_of(ViewerAction::next_camera) +
                   "; back: " + keys_of(ViewerAction::reset_camera) + ")");
}

void show_overlays(const PanelInput& input) {
  struct Entry {
    const char* name;
    ViewerAction action;
    bool on;
    const char* tip;
  };
  const ViewerControl::Settings& settings = input.control.settings();
  const Overlays& overlays = settings.choice.overlays;
  const std::array<Entry, 8> entries{
      Entry{"Holes", ViewerAction::toggle_holes, overlays.holes, "In pink: what no picture has shown and was filled"},
      Entry{"Never seen", ViewerAction::toggle_never_seen, overlays.never_seen,
            "Hatched: polygons that no picture has shown at all"},
      Entry{"Texture age", ViewerAction::toggle_age, overlays.age,
            "Heat map: how long ago the picture was taken that a colour is from"},
      Entry{"Texel density", ViewerAction::toggle_density, overlays.density,
            "Heat map: how many pixels a texel covers; red where the texture is too coarse"},
      Entry{"Wireframe", ViewerAction::toggle_wireframe, overlays.wireframe,
            "The model's edges over the predicted view"},
      Entry{"Model's edges", ViewerAction::toggle_edges, overlays.edges,
            "The model's edges over the delayed picture: if they do not lie on the picture's, registration is wrong"},
      Entry{"Field of view", ViewerAction::toggle_cone, overlays.cone, "Lights what the real camera sees"},
      Entry{"Polygon", ViewerAction::toggle_probe, settings.probe, "Tells of the polygon under the cursor"},
  };
  if (!ImGui::BeginTable("overlays", 2, ImGuiTableFlags_SizingStretchSame)) return;
  for (const Entry& entry : entries) {
    ImGui::TableNextColumn();
    bool on = entry.on;
    if (ImGui::Checkbox(entry.name, &on)) input.control.act(entry.action);
    widgets::tooltip(std::string(entry.tip) + " (" + keys_of(entry.action) + ")");
  }
  ImGui::EndTable();
}

}  // namespace

void show_view_panel(const PanelInput& input) {
  show_modes(input);
  show_camera(input);
  show_overlays(input);
}

}  // namespace foreview
