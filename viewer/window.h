#pragma once
#include <epoxy/gl.h>

#include <string>
#include <vector>

#include "foreview/viewer/key_map.h"

struct GLFWwindow;

namespace foreview {

/// The window, its OpenGL 4.5 context (made by GLFW through EGL, current from construction on, in the state that
/// set_up_context_state() gives) and its keys. One at a time, in the main thread.
class Window {
 public:
  /// Width and height in screen coordinates, lowered to what the monitor has. Throws GraphicsError where there is no
  /// display or no such context.
  Window(const std::string& title, int width, int height);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Takes in what has happened; `wait_seconds` > 0 waits that long for something to happen.
  void poll_events(double wait_seconds = 0);
  struct Key {
    KeyChord chord;
    bool repeated = false;  ///< it is being held down
  };
  /// Keys pressed since the last call, in order.
  [[nodiscard]] std::vector<Key> take_keys();
  [[nodiscard]] bool close_requested() const;
  /// As the constructor's width and height.
  void resize(int width, int height);
  void set_title(const std::string& title);

  [[nodiscard]] int width() const { return width_; }    ///< pixels
  [[nodiscard]] int height() const { return height_; }  ///< pixels
  /// Shows a framebuffer (one sample a pixel, row 0 its top) in the middle of the window, black around it.
  void present(GLuint framebuffer, int frame_width, int frame_height);

 private:
  void on_key(int key, int scancode, int action, int modifiers);

  GLFWwindow* window_ = nullptr;
  int width_ = 0, height_ = 0;
  std::string title_;
  std::vector<Key> keys_;
};

}  // namespace foreview
