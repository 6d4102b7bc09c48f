#pragma once
#include <imgui.h>

#include <vector>

#include "foreview/viewer/interface_theme.h"
#include "foreview/viewer/panel_focus.h"
#include "foreview/viewer/panel_layout.h"
#include "foreview/viewer/panels.h"

namespace foreview::test {

/// The panels over a made-up state, in simulated frames: no window, and no OpenGL unless a test brings it.
class PanelHarness {
 public:
  /// Sizes in pixels, which are Dear ImGui's units here; `scale` as Window::content_scale().
  PanelHarness(float width, float height, float scale, PipelineKind pipeline = PipelineKind::batched)
      : clock_(clock_options(), [this] { return real_; }), control_(control_options(pipeline), &clock_) {
    context_ = ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = io.LogFilename = nullptr;
    io.ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
    io.DisplaySize = {width, height};
    io.DeltaTime = 1.0F / 60;
    for (const int key : {ImGuiKey_Tab, ImGuiKey_LeftArrow, ImGuiKey_RightArrow, ImGuiKey_UpArrow, ImGuiKey_DownArrow,
                          ImGuiKey_Space, ImGuiKey_Enter, ImGuiKey_Escape}) {
      io.KeyMap[key] = key;
    }
    apply_interface_theme(scale);
    em_ = load_interface_font(*io.Fonts, scale);
    unsigned char* pixels = nullptr;
    int font_width = 0, font_height = 0;
    io.Fonts->GetTexDataAsAlpha8(&pixels, &font_width, &font_height);
    status_.name = "made up";
    status_.renderer = "a renderer, OpenGL 4.5";
    status_.first = time(100);
    status_.last = time(110);
    status_.rate_wanted = 33;
    status_.truth_known = true;
  }
  ~PanelHarness() { ImGui::DestroyContext(context_); }
  PanelHarness(const PanelHarness&) = delete;
  PanelHarness& operator=(const PanelHarness&) = delete;

  /// A frame, up to and with ImGui::Render().
  void frame() {
    real_ = real_ + Duration::from_seconds(1.0 / 60);
    status_.now = clock_.now().time;
    ImGui::NewFrame();
    focus_.begin();
    if (control_.take_enter_request()) focus_.enter();
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    layout_ = lay_out_panels(size.x, size.y, em_, control_.settings().panels);
    show_panels({control_, status_, em_}, layout_);
    focus_.end();
    ImGui::Render();
  }
  void frames(int count) {
    for (int i = 0; i < count; ++i) frame();
  }
  /// An ImGuiKey_ goes down and up again; long enough for Dear ImGui to see it, too short for it to repeat.
  void press(int key) {
    ImGui::GetIO().KeysDown[key] = true;
    frames(2);
    ImGui::GetIO().KeysDown[key] = false;
    frames(2);
  }
  void enter() {
    focus_.enter();
    frames(3);
  }

  static Timestamp time(double seconds) { return Timestamp{} + Duration::from_seconds(seconds); }
  [[nodiscard]] ViewerControl& control() { return control_; }
  [[nodiscard]] ViewerStatus& status() { return status_; }
  [[nodiscard]] PlaybackClock& clock() { return clock_; }
  [[nodiscard]] PanelFocus& focus() { return focus_; }
  [[nodiscard]] const PanelLayout& layout() const { return layout_; }
  [[nodiscard]] float em() const { return em_; }

 private:
  static PlaybackClock::Options clock_options() {
    PlaybackClock::Options options;
    options.first = time(100);
    options.last = time(110);
    options.playing = false;
    return options;
  }
  static ViewerControl::Options control_options(PipelineKind pipeline) {
    ViewerControl::Options options;
    for (int i = 0; i <= 20; ++i) options.steps.push_back(time(100 + 0.5 * i));
    options.link.delay = Duration::from_seconds(0.5);
    options.pipeline = pipeline;
    options.camera.width = 400;
    options.camera.height = 300;
    options.camera.focal_length = {300, 300};
    options.camera.principal_point = {200, 150};
    options.surroundings = {{0, 0, 0}, 2, {0, 0, 1}};
    return options;
  }

  Timestamp real_;
  PlaybackClock clock_;
  ViewerControl control_;
  ViewerStatus status_;
  PanelFocus focus_;
  PanelLayout layout_;
  ImGuiContext* context_ = nullptr;
  float em_ = 0;
};

}  // namespace foreview::test
