#pragma once
#include <atomic>
#include <exception>
#include <memory>
#include <optional>
#include <thread>

#include "foreview/gpu/extraction.h"
#include "foreview/gpu/offscreen_context.h"
#include "foreview/gpu/texture_store.h"
#include "foreview/scene/chart_layout.h"
#include "foreview/scene/polygon_model.h"
#include "foreview/viewer/loop_platform.h"

namespace foreview {

/// What a live display shows, and what gives it textures: the extraction's context, the textures in three sets, and the
/// pipeline. Everything of GL in here belongs to the extraction's context but TextureStore::acquire() and release().
/// Constructed, destroyed and called with the display's context current, which is current again afterwards.
class LiveScene {
 public:
  struct Options {
    PipelineKind pipeline = PipelineKind::batched;
    ExtractionOptions extraction;
    ChartOptions charts;  ///< memory_budget: of all three sets together
    /// Textures to begin with, and whether they must fit this model and density (else they are left out, with a
    /// warning).
    std::optional<std::filesystem::path> initial_textures;
    bool initial_textures_must_fit = true;
    bool debug = false;  ///< a debug context for extraction, too
    /// Constructed is only what shows that nothing has been seen; the rest is prepared in another thread, while the
    /// display goes on.
    bool beside_display = false;
  };
  /// `display`, `context`: EGLDisplay and EGLContext of the display's context; `make_display_current` makes it current.
  /// Throws as TextureStore, make_extraction_pipeline() and load_textures() do.
  LiveScene(const PolygonModel& model, const Options& options, void* display, void* context,
            std::function<void()> make_display_current);
  ~LiveScene();
  LiveScene(const LiveScene&) = delete;
  LiveScene& operator=(const LiveScene&) = delete;

  /// Whether all is prepared, as it always is unless Options::beside_display. Until then: no extraction(), of store()
  /// only what TextureStore says, and what platform() is to do in the extraction's context waits for it, and throws, as
  /// this does, what the constructor would have thrown.
  [[nodiscard]] bool is_ready();
  [[nodiscard]] LoopPlatform& platform() { return platform_; }
  [[nodiscard]] OffscreenContext& extraction_context() { return context_; }
  [[nodiscard]] TextureStore& store() { return *store_; }
  [[nodiscard]] ExtractionPipeline& extraction() { return *extraction_; }
  /// A pipeline with other options in the place of extraction(), which must not be in use any more: first
  /// DisplayLoop::set_extraction(nullptr). What textures hold stays; a picture that was begun is finished first. Waits
  /// for the GPU. InputError where the options cannot be; then the old one stays.
  void replace_extraction(const ExtractionOptions& options);
  /// As begun: nothing seen but the initial textures. For DisplayLoop::Callbacks::restart, in the extraction's context.
  void restart();

 private:
  /// Waits, before the extraction's context is used, until the other thread has done with it.
  class Platform final : public GlLoopPlatform {
   public:
    Platform(std::function<void()> make_display_current, LiveScene& scene)
        : GlLoopPlatform(std::move(make_display_current), scene.context_), scene_(scene) {}
    void in_extraction(const std::function<void()>& work) override;

   private:
    LiveScene& scene_;
  };
  void prepare();
  void load_initial_textures();
  void await();

  Options options_;
  OffscreenContext context_;
  Platform platform_;
  std::unique_ptr<TextureStore> store_;
  std::unique_ptr<ExtractionPipeline> extraction_;
  std::atomic<bool> prepared_ = false;
  std::exception_ptr failure_;  ///< of the other thread
  std::thread preparing_;
};

}  // namespace foreview
