#pragma once
#include <functional>

#include "foreview/gpu/offscreen_context.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/timestamp.h"
#include "foreview/server/frame_source.h"

namespace foreview {

/// The graphics context is gone, with all that was in it: textures must be made and extracted anew, in new contexts.
class ContextLost : public GraphicsError {
 public:
  using GraphicsError::GraphicsError;
};

/// The world as DisplayLoop sees it: a clock, two contexts that share objects, and when the GPU has finished. Tests put
/// simulated time and faults in its place.
class LoopPlatform {
 public:
  virtual ~LoopPlatform() = default;
  LoopPlatform() = default;
  LoopPlatform(const LoopPlatform&) = delete;
  LoopPlatform& operator=(const LoopPlatform&) = delete;

  /// A clock that does not go back.
  [[nodiscard]] virtual Timestamp now() = 0;
  virtual void sleep_until(Timestamp when) = 0;
  /// Makes the display's context current in the calling thread, if it is not.
  virtual void use_display_context() = 0;
  /// Runs `work`, and returns when it has returned, with extraction's context current. Which one is current afterwards
  /// is not said: in one thread, going to and fro for each slice is saved.
  virtual void in_extraction(const std::function<void()>& work) = 0;
  /// Returns when the GPU has done all that was issued in the current context. ContextLost where it never will;
  /// `what` names the work in messages.
  virtual void finish(const char* what) = 0;
};

/// The real one: steady_now() and fences.
class GlLoopPlatform : public LoopPlatform {
 public:
  /// Work that the GPU has not done after so long is taken for lost.
  static constexpr Duration kPatience{20'000'000'000};

  /// `make_display_current`: makes the display's context current (an OffscreenContext's, or the window's). `extraction`
  /// must share objects with it, and outlive this.
  /// The display's context must be current.
  GlLoopPlatform(std::function<void()> make_display_current, OffscreenContext& extraction);

  [[nodiscard]] Timestamp now() override { return steady_now(); }
  void sleep_until(Timestamp when) override;
  void use_display_context() override;
  void in_extraction(const std::function<void()>& work) override;
  void finish(const char* what) override;

 private:
  bool extraction_is_current_ = false;
  std::function<void()> make_display_current_;
  OffscreenContext& extraction_;
};

/// Runs `work` with extraction's context current, and comes back to the display's, also after an exception.
void in_extraction_context(LoopPlatform& platform, const std::function<void()>& work);

}  // namespace foreview
