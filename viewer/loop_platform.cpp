#include "foreview/viewer/loop_platform.h"

#include <epoxy/gl.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <string>
#include <thread>
#include <utility>

namespace foreview {
namespace {

using Clock = std::chrono::steady_clock;

/// Why the current context is of no more use; empty if it is.
std::string loss_of_context() {
  switch (glGetGraphicsResetStatus()) {
    case GL_NO_ERROR:
      return {};
    case GL_GUILTY_CONTEXT_RESET:
      return "the graphics driver was reset because of what foreview drew";
    case GL_INNOCENT_CONTEXT_RESET:
      return "the graphics driver was reset because of another program";
    default:
      return "the graphics driver was reset";
  }
}

}  // namespace

GlLoopPlatform::GlLoopPlatform(std::function<void()> make_display_current, OffscreenContext& extraction)
    : make_display_current_(std::move(make_display_current)), extraction_(extraction) {}

void GlLoopPlatform::use_display_context() {
  if (!extraction_is_current_) return;
  make_display_current_();
  extraction_is_current_ = false;
}

void GlLoopPlatform::in_extraction(const std::function<void()>& work) {
  if (!extraction_is_current_) extraction_.make_current();
  extraction_is_current_ = true;
  work();
}

void GlLoopPlatform::sleep_until(Timestamp when) {
  std::this_thread::sleep_until(Clock::time_point(std::chrono::nanoseconds(when.nanoseconds)));
}

void GlLoopPlatform::finish(const char* what) {
  constexpr GLuint64 kTenthOfASecond = 100'000'000;
  const Timestamp given_up = now() + kPatience;
  const GLsync fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  // Waiting leaves the cores to the software rasteriser's threads; asking again and again would take one from them.
  GLenum result = fence == nullptr ? GL_WAIT_FAILED : GL_TIMEOUT_EXPIRED;
  while (result == GL_TIMEOUT_EXPIRED && now() < given_up && loss_of_context().empty()) {
    result = glClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, kTenthOfASecond);
  }
  glDeleteSync(fence);
  if (const std::string loss = loss_of_context(); !loss.empty()) throw ContextLost(loss);
  if (result == GL_TIMEOUT_EXPIRED) {
    throw ContextLost(std::string("the GPU has not finished ") + what + " for " +
                      std::to_string(kPatience.nanoseconds / 1'000'000'000) + " s");
  }
  if (result == GL_WAIT_FAILED) throw ContextLost(std::string("the graphics driver lost ") + what);
}

void in_extraction_context(LoopPlatform& platform, const std::function<void()>& work) {
  try {
    platform.in_extraction(work);
  } catch (...) {
    try {
      platform.use_display_context();
    } catch (const std::exception& error) {
      spdlog::debug("{}", error.what());  // the first error is the one to tell
    }
    throw;
  }
  platform.use_display_context();
}

}  // namespace foreview
