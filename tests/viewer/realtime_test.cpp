#include "foreview/viewer/realtime.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <thread>

namespace foreview {
namespace {

int policy() {
  return sched_getscheduler(0);  // of the calling thread
}
int policy_of_a_new_thread() {
  int result = -1;
  std::thread([&] { result = policy(); }).join();
  return result;
}

/// In a thread of its own, so that the other tests stay ordinary. False where the system refuses.
template <class Check>
bool in_realtime(const Check& check) {
  bool allowed = false;
  std::thread([&] {
    const auto refusal = enter_realtime();
    allowed = !refusal;
    if (refusal) {
      EXPECT_FALSE(refusal->empty());
      EXPECT_EQ(policy(), SCHED_OTHER);
      return;
    }
    check();
  }).join();
  return allowed;
}

TEST(Realtime, HoldsForThreadsMadeLater) {
  if (!in_realtime([] {
        EXPECT_EQ(policy(), SCHED_RR);
        EXPECT_EQ(policy_of_a_new_thread(), SCHED_RR);
      })) {
    GTEST_SKIP() << "the system does not allow real-time priority";
  }
  EXPECT_EQ(policy(), SCHED_OTHER) << "of other threads";
}

TEST(Realtime, OrdinaryPriorityHoldsAsLongAsItLives) {
  if (!in_realtime([] {
        {
          const OrdinaryPriority ordinary;
          EXPECT_EQ(policy(), SCHED_OTHER);
          EXPECT_EQ(policy_of_a_new_thread(), SCHED_OTHER);
          const OrdinaryPriority within;
        }
        EXPECT_EQ(policy(), SCHED_RR);
      })) {
    GTEST_SKIP() << "the system does not allow real-time priority";
  }
}

TEST(Realtime, OrdinaryPriorityChangesNothingForAnOrdinaryThread) {
  {
    const OrdinaryPriority ordinary;
    EXPECT_EQ(policy(), SCHED_OTHER);
  }
  EXPECT_EQ(policy(), SCHED_OTHER);
}

}  // namespace
}  // namespace foreview
