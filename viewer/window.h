#pragma once
#include <epoxy/gl.h>

#include <bitset>
#include <string>
#include <vector>

#include "foreview/scene/errors.h"
#include "foreview/viewer/key_map.h"

struct GLFWwindow;

namespace foreview {

/// The window is gone: nothing can be drawn any more, but what else the process holds is whole. (Where the display
/// server is gone, see display_errors.h.)
class WindowLost : public GraphicsError {
 public:
  using GraphicsError::GraphicsError;
};

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

  /// Takes in what has happened; `wait_seconds` > 0 waits that long for something to happen. Throws WindowLost.
  void poll_events(double wait_seconds = 0);
  struct Key {
    KeyChord chord;
    bool repeated = false;  ///< it is being held down
  };
  /// Keys pressed since the last call, in order.
  [[nodiscard]] std::vector<Key> take_keys();
  /// Keys held down that move the operator's camera.
  [[nodiscard]] std::bitset<kMoveKeys> held_moves() const;
  [[nodiscard]] bool close_requested() const;
  /// As the constructor's width and height.
  void resize(int width, int height);
  void set_title(const std::string& title);
  /// The monitor's whole area, or back to where and as large as it was.
  void set_full_screen(bool on);
  void copy_to_clipboard(const std::string& text);

  [[nodiscard]] int width() const { return width_; }    ///< pixels; 0 while minimised, on some systems
  [[nodiscard]] int height() const { return height_; }  ///< pixels
  /// Nothing of it is to be seen: drawing would be in vain.
  [[nodiscard]] bool minimised() const;
  /// Pixels per pixel of an ordinary screen (96 dots per inch), as the user has set it.
  [[nodiscard]] float content_scale() const { return content_scale_; }
  /// Where the window system counts in points of several pixels each, as on some other systems than X11; else 1.
  [[nodiscard]] float pixels_per_point() const {
    return points_ > 0 && width_ > 0 ? static_cast<float>(width_) / static_cast<float>(points_) : 1;
  }
  /// Of the monitor it is on, in hertz; 0 where unknown.
  [[nodiscard]] int refresh_rate() const;

  [[nodiscard]] GLFWwindow* handle() const { return window_; }
  void make_current();
  [[nodiscard]] void* egl_display() const;  ///< EGLDisplay, for OffscreenContext::Options
  [[nodiscard]] void* egl_context() const;  ///< EGLContext

  struct Area {
    int x = 0, y = 0, width = 0, height = 0;  ///< pixels, (0, 0) is the upper left corner
  };
  /// Draws a framebuffer (one sample a pixel, row 0 its top) into the middle of the area, the rest of the window black.
  void draw(GLuint framebuffer, int frame_width, int frame_height, const Area& area);
  /// swap() waits for so many of the monitor's frames; to begin with, 1.
  void set_swap_interval(int frames);
  /// Shows what was drawn. Throws WindowLost.
  void swap();

 private:
  void on_key(int key, int scancode, int action, int modifiers);
  void check_alive() const;

  GLFWwindow* window_ = nullptr;
  int width_ = 0, height_ = 0;
  int points_ = 0;  ///< width in screen coordinates, of the same moment
  float content_scale_ = 1;
  std::string title_;
  std::vector<Key> keys_;
  bool full_screen_ = false;
  Area before_full_screen_;
};

}  // namespace foreview
