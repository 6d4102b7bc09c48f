#pragma once

namespace foreview {

/// Ctrl-C (SIGINT) and SIGTERM set a flag that long work asks for; a second Ctrl-C ends the process at once.
void install_interrupt_handler();
[[nodiscard]] bool interrupted();
/// Throws Interrupted if the user asked for the end.
void throw_if_interrupted();

}  // namespace foreview
