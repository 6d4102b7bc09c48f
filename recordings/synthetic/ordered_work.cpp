#include "foreview/recordings/synthetic/ordered_work.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

namespace foreview::synthetic {
namespace {

struct Shared {
  std::mutex mutex;
  std::condition_variable changed;
  std::map<std::size_t, cv::Mat> done;
  std::size_t next = 0, taken = 0;
  bool stopped = false;
  std::exception_ptr error;
};

void work(Shared& shared, std::size_t count, std::size_t ahead, const std::function<cv::Mat(std::size_t)>& make) {
  while (true) {
    std::size_t index = 0;
    {
      std::unique_lock lock(shared.mutex);
      shared.changed.wait(lock,
                          [&] { return shared.stopped || shared.next >= count || shared.next < shared.taken + ahead; });
      if (shared.stopped || shared.next >= count) return;
      index = shared.next++;
    }
    try {
      cv::Mat picture = make(index);
      const std::lock_guard lock(shared.mutex);
      shared.done.emplace(index, std::move(picture));
    } catch (...) {
      const std::lock_guard lock(shared.mutex);
      shared.error = std::current_exception();
      shared.stopped = true;
    }
    shared.changed.notify_all();
  }
}

/// Whatever happens, the threads end before what they refer to does.
class Crew {
 public:
  explicit Crew(Shared& shared) : shared_(shared) {}
  ~Crew() {
    {
      const std::lock_guard lock(shared_.mutex);
      shared_.stopped = true;
    }
    shared_.changed.notify_all();
    for (std::thread& thread : threads) thread.join();
  }
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;
  std::vector<std::thread> threads;

 private:
  Shared& shared_;
};

}  // namespace

void make_in_order(std::size_t count, const std::function<cv::Mat(std::size_t)>& make,
                   const std::function<void(std::size_t, const cv::Mat&)>& take) {
  const std::size_t threads = std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, 16);
  const std::size_t ahead = 2 * threads + 2;
  Shared shared;
  Crew crew(shared);
  for (std::size_t i = 0; i < std::min(threads, count); ++i) {
    crew.threads.emplace_back([&] { work(shared, count, ahead, make); });
  }
  for (std::size_t i = 0; i < count; ++i) {
    cv::Mat picture;
    {
      std::unique_lock lock(shared.mutex);
      shared.changed.wait(lock, [&] { return shared.stopped || shared.done.contains(i); });
      if (shared.error) std::rethrow_exception(shared.error);
      picture = shared.done.at(i);
      shared.done.erase(i);
      shared.taken = i + 1;
    }
    shared.changed.notify_all();
    take(i, picture);
  }
}

}  // namespace foreview::synthetic
