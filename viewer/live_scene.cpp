#include "foreview/viewer/live_scene.h"

#include <epoxy/gl.h>
#include <spdlog/spdlog.h>

#include <string>
#include <utility>

#include "foreview/scene/errors.h"
#include "foreview/viewer/display_loop.h"

namespace foreview {

LiveScene::LiveScene(const PolygonModel& model, const Options& options, void* display, void* context,
                     std::function<void()> make_display_current)
    : options_(options),
      context_({.debug = options.debug, .share_display = display, .share_context = context}),
      platform_(std::move(make_display_current), *this) {
  in_extraction_context(platform_, [&] {
    ChartOptions charts = options_.charts;
    charts.memory_budget /= set_count(Publishing::buffered);
    ChartLayout layout = lay_out_charts(model, charts);
    for (const std::string& note : layout.notes) spdlog::info("textures: {}", note);
    store_ = std::make_unique<TextureStore>(model, std::move(layout), Publishing::buffered,
                                            options_.beside_display ? Making::in_part : Making::whole);
    if (!options_.beside_display) prepare();
  });
  if (!options_.beside_display) return;
  preparing_ = std::thread([this] {
    try {
      context_.make_current();
      prepare();
      glFinish();
    } catch (...) {
      failure_ = std::current_exception();
    }
    context_.release_current();
    prepared_ = true;
  });
}

void LiveScene::prepare() {
  store_->make_rest();
  extraction_ = make_extraction_pipeline(options_.pipeline, *store_, options_.charts, options_.extraction);
  if (options_.initial_textures) load_initial_textures();
}

bool LiveScene::is_ready() {
  if (preparing_.joinable() && !prepared_) return false;
  await();
  return true;
}

void LiveScene::await() {
  if (preparing_.joinable()) preparing_.join();
  if (failure_) std::rethrow_exception(failure_);
}

void LiveScene::Platform::in_extraction(const std::function<void()>& work) {
  scene_.await();
  GlLoopPlatform::in_extraction(work);
}

LiveScene::~LiveScene() {
  if (preparing_.joinable()) preparing_.join();
  failure_ = nullptr;  // so that what has been made is given back in its context
  const auto destroy = [&] {
    extraction_.reset();
    store_.reset();
  };
  try {
    in_extraction_context(platform_, destroy);
  } catch (const std::exception& error) {
    spdlog::debug("{}", error.what());
    destroy();
  }
}

void LiveScene::replace_extraction(const ExtractionOptions& options) {
  in_extraction_context(platform_, [&] {
    auto made = make_extraction_pipeline(options_.pipeline, *store_, options_.charts, options);
    // What was begun would be written by two; and to abandon it would forget what is shown.
    while (extraction_->is_busy()) {
      if (const auto slice = extraction_->pending_slice()) {
        static_cast<void>(extraction_->run_slice(slice->size));
        platform_.finish("extracting textures");
      } else {
        store_->wait_for_free_set();
      }
    }
    made->adopt_store();
    extraction_ = std::move(made);
    options_.extraction = options;
  });
}

void LiveScene::load_initial_textures() {
  try {
    load_textures(*store_, *options_.initial_textures);
    extraction_->adopt_store();
  } catch (const InputError& error) {
    if (options_.initial_textures_must_fit) throw;
    spdlog::warn("beginning without the recording's textures: {}", error.what());
    options_.initial_textures.reset();
    store_->clear();
  }
  store_->spread_to_never_seen();
}

void LiveScene::restart() {
  extraction_->clear();
  store_->clear();
  if (options_.initial_textures) {
    load_initial_textures();
  } else {
    store_->spread_to_never_seen();
  }
}

}  // namespace foreview
