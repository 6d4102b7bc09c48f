#pragma once
#include <array>
#include <vector>

namespace foreview {

/// Whether keys belong to the panels or to the view. They are the view's, whatever was clicked last; the panels have
/// them between enter() (or Dear ImGui's Ctrl+Tab) and leave(), while text is being typed, and while a list is open.
/// Every member needs Dear ImGui's context.
class PanelFocus {
 public:
  /// After ImGui::NewFrame().
  void begin();
  /// After the panels, before ImGui::Render().
  void end();
  /// Into the panel that had the keyboard last, to the control that had it; where it is in one already, into the next.
  void enter() { entering_ = true; }
  /// Escape was pressed: back to the view, unless an open list or a figure being typed closes first.
  void leave();
  [[nodiscard]] bool wants_keys() const;

 private:
  /// The control of a panel that had the keyboard last, and where it is in the panel.
  struct Place {
    unsigned panel = 0, control = 0;
    std::array<float, 4> area{};
  };
  void remember();

  std::vector<Place> places_;
  bool entered_ = false, entering_ = false;
};

}  // namespace foreview
