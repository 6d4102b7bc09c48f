#pragma once
#include <optional>
#include <string>

namespace foreview {

/// From now on the calling thread, and threads it creates, run ahead of ordinary programs' (SCHED_RR at its least
/// priority): what else wakes up on the machine does not delay a frame. To be called before a graphics context is made,
/// so that a software rasteriser's threads are included. Says why where the system refuses: it takes CAP_SYS_NICE or a
/// limit for real-time priority (`ulimit -r`) of at least 1.
[[nodiscard]] std::optional<std::string> enter_realtime();

/// While it lives, the calling thread and the threads it creates are ordinary ones: for what reads and decodes beside
/// the display. Puts back what was.
class OrdinaryPriority {
 public:
  OrdinaryPriority();
  ~OrdinaryPriority();
  OrdinaryPriority(const OrdinaryPriority&) = delete;
  OrdinaryPriority& operator=(const OrdinaryPriority&) = delete;

 private:
  int policy_, priority_;
};

}  // namespace foreview
