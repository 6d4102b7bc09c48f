#include "foreview/viewer/picture_reader.h"

#include <spdlog/spdlog.h>

#include <condition_variable>
#include <mutex>
#include <thread>

#include "foreview/recordings/recording.h"
#include "foreview/scene/errors.h"
#include "foreview/server/thread_priority.h"

namespace foreview {

struct PictureReader::State {
  State(const Recording& of, std::size_t of_camera) : recording(of), camera(of_camera) {}

  void run() {
    lower_thread_priority();
    std::unique_lock lock(mutex);
    while (true) {
      wishes.wait(lock, [&] { return end || (wished && (!read || read->index != *wished)); });
      if (end) return;
      Read next{*wished, {}};
      lock.unlock();
      try {
        next.picture = recording.read_picture(camera, next.index);
      } catch (const std::exception& error) {  // InputError, or no memory: shown as nothing
        spdlog::debug("{}", error.what());
      }
      lock.lock();
      read = std::move(next);
    }
  }

  const Recording& recording;
  const std::size_t camera;
  std::mutex mutex;
  std::condition_variable wishes;
  std::optional<std::size_t> wished;
  std::optional<Read> read;
  bool end = false;
  std::thread thread{[this] { run(); }};
};

PictureReader::PictureReader(const Recording& recording, std::size_t camera)
    : state_(std::make_unique<State>(recording, camera)) {}

PictureReader::~PictureReader() {
  {
    const std::scoped_lock lock(state_->mutex);
    state_->end = true;
  }
  state_->wishes.notify_all();
  state_->thread.join();
}

std::optional<PictureReader::Read> PictureReader::wish(std::size_t index) {
  const std::scoped_lock lock(state_->mutex);
  if (state_->wished != index) {
    state_->wished = index;
    state_->wishes.notify_all();
  }
  return state_->read;
}

}  // namespace foreview
