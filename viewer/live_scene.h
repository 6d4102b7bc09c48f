#pragma once
#include <memory>
#include <optional>

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
  };
  /// `display`, `context`: EGLDisplay and EGLContext of the display's context; `make_display_current` makes it current.
  /// Throws as TextureStore, make_extraction_pipeline() and load_textures() do.
  LiveScene(const PolygonModel& model, const Options& options, void* display, void* context,
            std::function<void()> make_display_current);
  ~LiveScene();
  LiveScene(const LiveScene&) = delete;
  LiveScene& operator=(const LiveScene&) = delete;

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
  Options options_;
  OffscreenContext context_;
  GlLoopPlatform platform_;
  std::unique_ptr<TextureStore> store_;
  std::unique_ptr<ExtractionPipeline> extraction_;
};

}  // namespace foreview
