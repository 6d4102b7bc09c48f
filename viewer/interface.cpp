#include "foreview/viewer/interface.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>

#include "foreview/scene/errors.h"
#include "foreview/viewer/interface_theme.h"
#include "foreview/viewer/panel_focus.h"
#include "foreview/viewer/window.h"

namespace foreview {

struct Interface::State {
  explicit State(Window& shown_in) : window(shown_in) {}

  void set_scale() {
    // Where there are points of several pixels each, fonts are made in pixels and the rest in points.
    const float density = window.pixels_per_point();
    if (window.content_scale() == scale && density == pixels_per_point) return;
    const bool first = scale == 0;
    scale = window.content_scale();
    pixels_per_point = density;
    apply_interface_theme(scale / pixels_per_point);
    ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
    if (!first) ImGui_ImplOpenGL3_DestroyFontsTexture();
    atlas.Clear();
    em = load_interface_font(atlas, scale) / pixels_per_point;
    ImGui::GetIO().FontGlobalScale = 1 / pixels_per_point;
    if (!first) ImGui_ImplOpenGL3_CreateFontsTexture();
  }

  Window& window;
  float scale = 0, pixels_per_point = 1, em = 0;
  PanelFocus focus;
};

Interface::Interface(Window& window) : state_(std::make_unique<State>(window)) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // panels have their places; nothing is written where the user happens to be
  io.LogFilename = nullptr;
  io.ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
  io.ConfigInputTextCursorBlink = false;
  if (!ImGui_ImplGlfw_InitForOpenGL(window.handle(), true) || !ImGui_ImplOpenGL3_Init("#version 450 core")) {
    throw GraphicsError("the panels cannot be drawn: Dear ImGui finds no OpenGL");
  }
  state_->set_scale();
}

Interface::~Interface() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

void Interface::begin() {
  state_->set_scale();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  // What the backend asks the display for may be of another moment, or nonsense when the window is gone.
  const float density = state_->window.pixels_per_point();
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(std::max(state_->window.width(), 0)) / density,
                    static_cast<float>(std::max(state_->window.height(), 0)) / density};
  io.DisplayFramebufferScale = {density, density};
  ImGui::NewFrame();
  state_->focus.begin();
}

void Interface::end() {
  state_->focus.end();
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Interface::enter() {
  state_->focus.enter();
}

void Interface::leave() {
  state_->focus.leave();
}

bool Interface::wants_keys() const {
  return state_->focus.wants_keys();
}

bool Interface::is_editing() const {
  return ImGui::IsAnyItemActive();
}

PointerState Interface::pointer() const {
  const ImGuiIO& io = ImGui::GetIO();
  PointerState pointer;
  const ImVec2 scale = io.DisplayFramebufferScale;
  pointer.position = {static_cast<double>(io.MousePos.x * scale.x), static_cast<double>(io.MousePos.y * scale.y)};
  pointer.over_view = ImGui::IsMousePosValid() && !io.WantCaptureMouse && io.MousePos.x >= 0 && io.MousePos.y >= 0 &&
                      io.MousePos.x < io.DisplaySize.x && io.MousePos.y < io.DisplaySize.y;
  pointer.left = io.MouseDown[0];
  pointer.right = io.MouseDown[1];
  pointer.middle = io.MouseDown[2];
  pointer.left_pressed = pointer.over_view && ImGui::IsMouseClicked(0);
  pointer.right_pressed = pointer.over_view && ImGui::IsMouseClicked(1);
  pointer.shift = io.KeyShift;
  pointer.control = io.KeyCtrl;
  pointer.wheel = pointer.over_view ? static_cast<double>(io.MouseWheel) : 0;
  return pointer;
}

float Interface::em() const {
  return state_->em;
}

}  // namespace foreview
