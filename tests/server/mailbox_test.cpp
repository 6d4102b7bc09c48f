#include "foreview/server/mailbox.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace foreview {
namespace {

struct LargerIsNewer {
  bool operator()(const std::vector<int>& a, const std::vector<int>& b) const { return a[0] >= b[0]; }
};

TEST(Mailbox, NewestWinsAndUnreadIsCounted) {
  Mailbox<int> box;
  EXPECT_FALSE(box.take());
  box.put(1);
  box.put(2);
  box.put(3);
  EXPECT_TRUE(box.has_unread());
  EXPECT_EQ(box.overwritten(), 2U);
  EXPECT_EQ(box.take(), 3);
  EXPECT_FALSE(box.take());
  box.put(4);
  box.clear();
  EXPECT_FALSE(box.has_unread());
  EXPECT_EQ(box.overwritten(), 2U);
}

TEST(Mailbox, OlderItemDoesNotDisplaceANewerUnreadOne) {
  Mailbox<std::vector<int>, LargerIsNewer> box;
  box.put({5});
  box.put({3});
  EXPECT_EQ(box.take(), std::vector<int>{5});
  EXPECT_EQ(box.overwritten(), 1U);
  box.put({3});  // late, but nothing newer is unread
  EXPECT_EQ(box.take(), std::vector<int>{3});
}

TEST(Mailbox, NothingIsLostOrDoubledBetweenThreads) {
  constexpr int kEach = 20000;
  Mailbox<std::vector<int>> box;
  std::atomic<int> writing{2};
  std::vector<std::thread> writers;
  for (int w = 0; w < 2; ++w) {
    writers.emplace_back([&, w] {
      for (int i = 0; i < kEach; ++i) box.put({w, i});
      --writing;
    });
  }
  std::size_t taken = 0;
  std::vector<int> last(2, -1);
  bool ends = false;
  while (!ends) {
    ends = writing == 0;  // before the last look
    while (const auto item = box.take()) {
      ++taken;
      int& before = last[static_cast<std::size_t>((*item)[0])];
      EXPECT_LT(before, (*item)[1]);
      before = (*item)[1];
    }
  }
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(taken + box.overwritten(), 2U * kEach);
}

}  // namespace
}  // namespace foreview
