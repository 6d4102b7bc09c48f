#pragma once
#include <sys/types.h>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>

namespace foreview::test {

/// An X server without a screen (Xvfb), as long as this lives, and what a person in front of it would do.
class VirtualDisplay {
 public:
  /// Whether the program Xvfb is installed at all.
  [[nodiscard]] static bool installed();
  /// Starts the server with one screen of this size. Throws std::runtime_error where it does not come up.
  VirtualDisplay(int width, int height);
  ~VirtualDisplay();
  VirtualDisplay(const VirtualDisplay&) = delete;
  VirtualDisplay& operator=(const VirtualDisplay&) = delete;

  /// For the environment variable DISPLAY, ":99".
  [[nodiscard]] const std::string& name() const { return name_; }

  /// Title of the first window whose title begins with `beginning`, or none.
  [[nodiscard]] std::optional<std::string> title(const std::string& beginning) const;
  /// Waits until the window's title contains `part`; the last title if it does not within that time.
  [[nodiscard]] std::string wait_for_title(const std::string& beginning, const std::string& part, double seconds) const;
  /// Presses and releases a key, named as X does ("Tab", "space", "m").
  void press(const std::string& beginning, const std::string& key, unsigned modifiers = 0) const;
  void resize(const std::string& beginning, int width, int height) const;
  /// What the window shows, CV_8UC3 BGR; empty without the window.
  [[nodiscard]] cv::Mat screenshot(const std::string& beginning) const;
  /// Asks the window to close, as its frame's button does.
  void close(const std::string& beginning) const;

  /// Moves the mouse to a place in the window.
  void move_mouse(const std::string& beginning, int x, int y) const;
  /// Presses or releases a mouse button where the mouse is: 1 left, 3 right; 4 and 5 are the wheel's steps.
  void mouse_button(const std::string& beginning, int button, bool down) const;
  /// Press, move in a few steps, release; with pauses, so that every step is seen.
  void drag_mouse(const std::string& beginning, int button, cv::Point from, cv::Point to) const;
  /// What a window manager does when the window is minimised and brought back.
  void set_minimised(const std::string& beginning, bool minimised) const;
  /// As another program would.
  void destroy_window(const std::string& beginning) const;
  /// What programs started from now on take for the screen's density; 96 to begin with.
  void set_dots_per_inch(int dots) const;
  /// Ends the server as if it had crashed. Nothing else can be asked of this afterwards.
  void kill_server();

 private:
  struct Connection;
  Connection* connection_ = nullptr;
  pid_t server_ = -1;
  std::string name_;
};

}  // namespace foreview::test
