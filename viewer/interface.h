#pragma once
#include <glm/vec2.hpp>
#include <memory>

namespace foreview {

class Window;

/// Where the mouse is and what its buttons do, in the window's framebuffer pixels, y down. Outside panels only.
struct PointerState {
  glm::dvec2 position{0};
  bool over_view = false;  ///< not over a panel, nor outside the window
  bool left = false, right = false, middle = false;
  bool left_pressed = false, right_pressed = false;  ///< went down in this frame, over the view
  bool shift = false, control = false;
  double wheel = 0;  ///< steps away from the operator
};

/// Dear ImGui in a Window: fonts and spacing for the screen's pixel density, theme, and who gets keys and mouse. One at
/// a time; every member needs the window's context. What is shown is up to the panels (panels.h) that are called
/// between begin() and end().
class Interface {
 public:
  explicit Interface(Window& window);
  ~Interface();
  Interface(const Interface&) = delete;
  Interface& operator=(const Interface&) = delete;

  /// Begins a frame with the events taken in since the last one.
  void begin();
  /// Draws what the panels gave since begin() into the window's framebuffer, leaving GL's state as it was.
  void end();

  // As PanelFocus.
  void enter();
  void leave();
  [[nodiscard]] bool wants_keys() const;
  /// A slider is being dragged, or a figure typed: what it changes is not final.
  [[nodiscard]] bool is_editing() const;
  /// Between begin() and end().
  [[nodiscard]] PointerState pointer() const;
  /// Height of text in the interface's own units, which panels are laid out in.
  [[nodiscard]] float em() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
