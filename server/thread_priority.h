#pragma once

namespace foreview {

/// Lets the calling thread give way to the others of the process and the machine (Linux: a nice value of 10 for this
/// thread alone). Does nothing where the system refuses.
void lower_thread_priority();

}  // namespace foreview
