#include <gtest/gtest.h>
#include <imgui_internal.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "foreview/viewer/extraction_names.h"
#include "viewer/panel_harness.h"

namespace foreview {
namespace {

using test::PanelHarness;

/// All that controls can change, by name.
std::map<std::string, std::string> state_of(PanelHarness& panels) {
  const ViewerControl& control = panels.control();
  const ViewerControl::Settings& settings = control.settings();
  const Overlays& overlays = settings.choice.overlays;
  const ExtractionOptions& extraction = settings.extraction;
  const PlaybackClock& clock = panels.clock();
  const auto text = [](auto value) { return std::to_string(value); };
  return {
      {"view", to_string(settings.choice.mode)},
      {"camera", text(static_cast<int>(settings.choice.camera))},
      {"holes", text(overlays.holes)},
      {"never seen", text(overlays.never_seen)},
      {"age", text(overlays.age)},
      {"density", text(overlays.density)},
      {"wireframe", text(overlays.wireframe)},
      {"edges", text(overlays.edges)},
      {"cone", text(overlays.cone)},
      {"probe", text(settings.probe)},
      {"delay", text(settings.link.delay.nanoseconds)},
      {"jitter", text(settings.link.jitter.nanoseconds)},
      {"loss", text(settings.link.loss)},
      {"bandwidth", text(settings.link.bandwidth)},
      {"artefacts", to_string(extraction.artefacts)},
      {"passes", text(extraction.passes)},
      {"alpha c", text(extraction.alpha_c)},
      {"small", text(extraction.small_texture)},
      {"filling", to_string(extraction.fill)},
      {"near plane", text(extraction.near_plane)},
      {"exposure", text(extraction.compensate_exposure)},
      {"playing", text(clock.playing())},
      {"time", clock.now().time.to_string()},
      {"loop", text(clock.loop())},
      {"speed", text(clock.speed())},
      {"help", text(settings.help)},
      {"panels", text(settings.panels)},
  };
}

/// Goes with the arrow keys to all that can be gone to, as an operator without a mouse, and uses it.
class Walker {
 public:
  explicit Walker(PanelHarness& panels) : panels_(panels) {}

  /// What was changed by any control of the panel that the keyboard is in.
  void walk() {
    ImGuiContext& context = *ImGui::GetCurrentContext();
    to_the_top();
    for (int row = 0; row < 120; ++row) {
      use_row();
      const ImGuiID before = context.NavId;
      panels_.press(ImGuiKey_DownArrow);
      if (context.NavId == before) return;
    }
    FAIL() << "there is no end to the panel";
  }
  [[nodiscard]] const std::map<std::string, std::set<std::string>>& changed() const { return changed_; }

 private:
  void to_the_top() {
    const ImGuiContext& context = *ImGui::GetCurrentContext();
    ImGuiID before = 0;
    for (int row = 0; row < 120 && before != context.NavId; ++row) {
      before = context.NavId;
      panels_.press(ImGuiKey_UpArrow);
    }
  }

  void use_row() {
    ImGuiContext& context = *ImGui::GetCurrentContext();
    const ImGuiID first = context.NavId;
    for (const int direction : {ImGuiKey_RightArrow, ImGuiKey_LeftArrow}) {
      for (ImGuiID before = 0; before != context.NavId;) {
        use();
        before = context.NavId;
        const float height = context.NavWindow->ContentSize.y;
        panels_.press(direction);
        // The left arrow has closed a section, the right one opens it.
        if (context.NavWindow->ContentSize.y < height - 20) panels_.press(ImGuiKey_RightArrow);
      }
    }
    // Back to where the row was entered, from its left end.
    for (int column = 0; column < 20 && context.NavId != first; ++column) panels_.press(ImGuiKey_RightArrow);
  }

  void use() {
    ImGuiContext& context = *ImGui::GetCurrentContext();
    const ImGuiID id = context.NavId;
    if (id == 0 || !used_.insert(id).second) return;
    ImGuiWindow* window = context.NavWindow;
    const auto before = state_of(panels_);
    const float height = window->ContentSize.y;
    panels_.press(ImGuiKey_Space);
    if (ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup)) {
      panels_.frames(3);
      panels_.press(ImGuiKey_DownArrow);
      note(before);
      panels_.press(ImGuiKey_Space);
      if (state_of(panels_) == before) {  // it was the last of the list already
        panels_.press(ImGuiKey_Space);
        panels_.frames(3);
        panels_.press(ImGuiKey_UpArrow);
        panels_.press(ImGuiKey_Space);
      }
    } else if (context.ActiveId != 0) {
      for (const int arrow : {ImGuiKey_RightArrow, ImGuiKey_LeftArrow, ImGuiKey_LeftArrow}) {
        panels_.press(arrow);
        note(before);
      }
      panels_.press(ImGuiKey_Space);
    }
    note(before);
    if (window->ContentSize.y < height - 20 && state_of(panels_) == before) panels_.press(ImGuiKey_Space);  // a section
    restore();
    if (context.NavId != id || context.NavWindow != window) {
      ImGui::FocusWindow(window);
      ImGui::SetNavID(id, ImGuiNavLayer_Main, 0, window->NavRectRel[0]);
      panels_.frames(2);
    }
  }

  void note(const std::map<std::string, std::string>& before) {
    for (const auto& [name, value] : state_of(panels_)) {
      if (before.at(name) != value) changed_[name].insert(value);
    }
    if (panels_.control().take_save_request()) changed_["save"].insert("asked for");
    if (panels_.control().take_copy_request()) changed_["copy"].insert("asked for");
  }

  /// What would be in the way of what comes next.
  void restore() {
    panels_.control().settings().help = false;
    panels_.control().settings().panels = true;
    panels_.control().settings().probe = false;  // its section would push others down
    panels_.frames(3);
  }

  PanelHarness& panels_;
  std::set<ImGuiID> used_;
  std::map<std::string, std::set<std::string>> changed_;
};

std::set<std::string> names_of(const std::map<std::string, std::set<std::string>>& changed) {
  std::set<std::string> names;
  for (const auto& [name, values] : changed) names.insert(name);
  return names;
}

std::set<std::string> all_reached(PipelineKind pipeline) {
  PanelHarness panels(1280, 1000, 1, pipeline);
  // Each of the buttons before it is another choice, and so is this one then.
  panels.control().act(ViewerAction::view_difference);
  panels.frames(3);
  Walker walker(panels);
  panels.enter();
  EXPECT_TRUE(panels.focus().wants_keys());
  // Both panels, wherever it begins.
  walker.walk();
  panels.enter();
  walker.walk();
  std::set<std::string> reached = names_of(walker.changed());
  for (const std::string& view :
       walker.changed().count("view") > 0 ? walker.changed().at("view") : std::set<std::string>()) {
    reached.insert("view " + view);
  }
  return reached;
}

TEST(PanelKeyboard, ReachesEveryControl) {
  const std::set<std::string> reached = all_reached(PipelineKind::batched);
  for (const char* name :
       {"view predicted", "view delayed", "view both", "view split", "view difference", "camera", "holes",
        "never seen",     "age",          "density",   "wireframe",  "edges",           "cone",   "probe",
        "delay",          "jitter",       "loss",      "bandwidth",  "artefacts",       "passes", "near plane",
        "exposure",       "playing",      "time",      "loop",       "speed",           "help",   "panels",
        "save",           "copy"}) {
    EXPECT_TRUE(reached.contains(name)) << name << " cannot be reached, or not be changed, without the mouse";
  }
}

TEST(PanelKeyboard, ReachesThePerPolygonPipelinesParameters) {
  const std::set<std::string> reached = all_reached(PipelineKind::per_polygon);
  for (const char* name : {"artefacts", "passes", "alpha c", "small", "filling", "near plane"}) {
    EXPECT_TRUE(reached.contains(name)) << name << " cannot be reached, or not be changed, without the mouse";
  }
}

TEST(PanelKeyboard, GoesIntoThePanelsFromOneToTheNextAndOut) {
  PanelHarness panels(1280, 1000, 1);
  panels.frames(3);
  EXPECT_FALSE(panels.focus().wants_keys());
  std::set<const ImGuiWindow*> visited;
  for (int i = 0; i < 3; ++i) {
    panels.enter();
    EXPECT_TRUE(panels.focus().wants_keys());
    visited.insert(ImGui::GetCurrentContext()->NavWindow);
  }
  EXPECT_EQ(visited.size(), 2U) << "the side panel and the timeline";
  EXPECT_FALSE(visited.contains(nullptr));
  panels.focus().leave();
  panels.frames(2);
  EXPECT_FALSE(panels.focus().wants_keys());
  EXPECT_EQ(ImGui::GetCurrentContext()->NavWindow, nullptr);
}

TEST(PanelKeyboard, ComesBackToTheControlThatItLeft) {
  PanelHarness panels(1280, 1000, 1);
  panels.frames(3);
  panels.enter();
  const ImGuiContext& context = *ImGui::GetCurrentContext();
  const ImGuiID first = context.NavId;
  panels.press(ImGuiKey_RightArrow);
  panels.press(ImGuiKey_RightArrow);
  const ImGuiID control = context.NavId;
  EXPECT_NE(control, 0U);
  EXPECT_NE(control, first);
  panels.press(ImGuiKey_Escape);
  panels.focus().leave();
  panels.frames(3);
  EXPECT_FALSE(panels.focus().wants_keys());
  panels.enter();
  EXPECT_EQ(context.NavId, control);
}

TEST(PanelKeyboard, LeavingClosesAnOpenListFirst) {
  PanelHarness panels(1280, 1000, 1);
  panels.frames(3);
  panels.enter();
  // The speed, at the right end of the timeline.
  if (std::string(ImGui::GetCurrentContext()->NavWindow->Name) != "Timeline") panels.enter();
  for (int i = 0; i < 12; ++i) panels.press(ImGuiKey_RightArrow);
  panels.press(ImGuiKey_Space);
  ASSERT_TRUE(ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup));
  panels.focus().leave();
  EXPECT_TRUE(panels.focus().wants_keys());
}

}  // namespace
}  // namespace foreview
