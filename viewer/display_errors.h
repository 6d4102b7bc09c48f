#pragma once

namespace foreview {

/// What became of the connection to the X server.
enum class DisplayState {
  well,
  window_gone,  ///< someone else destroyed the window
  server_gone,  ///< the connection is broken; nothing may be asked of the display any more
};

/// Makes Xlib report such faults here instead of ending the process. Does nothing where the window system is another
/// one. `native_display`: Xlib's Display, or null. Call it again after calls that may have put Xlib's own handlers back
/// (GLFW does so): it costs nothing.
void watch_display(void* native_display);
[[nodiscard]] DisplayState display_state();

}  // namespace foreview
