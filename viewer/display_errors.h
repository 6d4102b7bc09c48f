#pragma once
#include <functional>

namespace foreview {

/// Makes Xlib report here instead of ending the process in its own way. Does nothing where the window system is another
/// one. Call it again after calls that may have put Xlib's own handlers back (GLFW does so): it costs nothing.
void watch_display();

/// Whether another program has destroyed the window.
[[nodiscard]] bool window_is_gone();

/// When the connection to the X server breaks, Xlib cannot go on: whatever is called of it next may crash, so there is
/// no way back to the caller. Then `action` (may be empty) is run, in which nothing may be asked of the display, one
/// line is printed, and the process ends with the exit status of a graphics error, 3.
void set_display_lost_action(std::function<void()> action);

}  // namespace foreview
