#pragma once
#include <unistd.h>

namespace foreview::test {

/// A DDS domain of this process's own, so that tests that run at the same time do not hear each other.
inline int dds_domain() {
  return 10 + static_cast<int>(getpid() % 100);  // and a few more, by test; 232 is the last
}

}  // namespace foreview::test
