#pragma once
#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

namespace foreview {

/// Room for one item between threads, without locks: the newest wins, and what it displaces unread is counted, because
/// a queue would only make the display older (spec 11). Neither side ever waits for the other. `Newer(a, b)`: whether a
/// is at least as new as b; by default what is put later is newer. Any number of writers, any number of readers.
struct PutLaterIsNewer {
  template <class T>
  bool operator()(const T&, const T&) const {
    return true;
  }
};

template <class T, class Newer = PutLaterIsNewer>
class Mailbox {
 public:
  Mailbox() = default;
  ~Mailbox() { delete slot_.load(); }
  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;

  /// Puts an item in; of it and an unread one the newer stays, the other is counted and dropped.
  void put(T item) {
    auto candidate = std::make_unique<T>(std::move(item));
    T* empty = nullptr;
    do {
      // Taken out to be looked at: a reader may take, and free, what is in the slot at any moment.
      const std::unique_ptr<T> unread(slot_.exchange(nullptr));
      if (unread) {
        overwritten_.fetch_add(1, std::memory_order_relaxed);
        if (!Newer()(*candidate, *unread)) *candidate = std::move(*unread);
      }
      empty = nullptr;
    } while (!slot_.compare_exchange_strong(empty, candidate.get()));
    static_cast<void>(candidate.release());
  }

  /// The unread item, if any. None also for the instant in which a writer compares an unread one with its own.
  [[nodiscard]] std::optional<T> take() {
    const std::unique_ptr<T> item(slot_.exchange(nullptr));
    if (!item) return std::nullopt;
    return std::move(*item);
  }

  /// Drops what is unread, uncounted.
  void clear() { delete slot_.exchange(nullptr); }
  [[nodiscard]] bool has_unread() const { return slot_.load() != nullptr; }
  /// Items displaced unread so far.
  [[nodiscard]] std::size_t overwritten() const { return overwritten_.load(std::memory_order_relaxed); }

 private:
  std::atomic<T*> slot_{nullptr};
  std::atomic<std::size_t> overwritten_{0};
};

}  // namespace foreview
