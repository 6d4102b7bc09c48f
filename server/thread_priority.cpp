#include "foreview/server/thread_priority.h"

#include <sys/resource.h>
#include <unistd.h>

namespace foreview {

void lower_thread_priority() {
  constexpr int kNice = 10;
  // Linux: which = process with a thread's id is that thread alone.
  static_cast<void>(setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice));
}

}  // namespace foreview
