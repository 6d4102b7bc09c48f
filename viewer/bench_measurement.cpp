#include "foreview/viewer/bench_measurement.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "foreview/gpu/timer_queries.h"
#include "foreview/scene/errors.h"

namespace foreview {
namespace {

constexpr double kLongWarmUp = 5000;  // milliseconds

/// Passes the pictures that are not damaged to `take(index, frame)`; returns how many are.
template <typename Take>
std::size_t for_each_picture(BenchPictures& pictures, double seconds, const std::function<void()>& tick, Take&& take) {
  const double begun = bench_clock_ms();
  std::size_t damaged = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (i > 0 && seconds > 0 && bench_clock_ms() - begun > 1e3 * seconds) break;
    if (tick) tick();
    const CameraFrame* frame = pictures.get(i);
    if (frame != nullptr) {
      take(i, *frame);
    } else {
      ++damaged;
    }
  }
  return damaged;
}

/// Shaders are compiled, textures placed, caches filled: none of this is what a picture costs.
void warm_up(ExtractionPipeline& pipeline, BenchPictures& pictures, std::size_t count,
             const std::function<void()>& tick) {
  std::size_t done = 0;
  const double begun = bench_clock_ms();
  for (std::size_t i = 0; i < pictures.size() && done < count; ++i) {
    // What is so slow that it is measured with few pictures is warm after one.
    if (done > 0 && bench_clock_ms() - begun > kLongWarmUp) break;
    if (tick) tick();
    if (const CameraFrame* frame = pictures.get(i)) {
      static_cast<void>(pipeline.extract(*frame));
      glFinish();
      ++done;
    }
  }
  pipeline.clear();
  glFinish();
}

void measure_totals(ExtractionPipeline& pipeline, BenchPictures& pictures, BenchRun& run,
                    const std::function<void()>& tick) {
  run.counters.pictures_damaged =
      for_each_picture(pictures, run.request.seconds, tick, [&](std::size_t i, const CameraFrame& frame) {
        glFinish();
        PictureCost cost;
        cost.picture = i;
        cost.decode_ms = pictures.decode_ms(i);
        cost.start_ms = bench_clock_ms();
        cost.statistics = pipeline.extract(frame);
        cost.cpu_ms = bench_clock_ms() - cost.start_ms;
        glFinish();
        cost.total_ms = bench_clock_ms() - cost.start_ms;
        run.counters.sum += cost.statistics;
        ++run.counters.pictures_extracted;
        run.totals.push_back(std::move(cost));
      });
}

void measure_steps(ExtractionPipeline& pipeline, BenchPictures& pictures, BenchRun& run,
                   const std::function<void()>& tick) {
  const bool are_counted = run.request.totals;
  pipeline.set_timing(run.step_timing);
  run.counters.pictures_damaged =
      for_each_picture(pictures, run.request.seconds, tick, [&](std::size_t i, const CameraFrame& frame) {
        glFinish();
        SteppedCost cost;
        cost.picture = i;
        cost.start_ms = bench_clock_ms();
        cost.statistics = pipeline.extract(frame);
        glFinish();
        if (!are_counted) {
          run.counters.sum += cost.statistics;
          ++run.counters.pictures_extracted;
        }
        if (!run.request.keep_spans) {
          cost.statistics.spans.clear();
          cost.statistics.spans.shrink_to_fit();
        }
        run.stepped.push_back(std::move(cost));
      });
  pipeline.set_timing(ExtractionTiming::off);
}

void count_observed(ExtractionPipeline& pipeline, BenchPictures& pictures, BenchRun& run,
                    const std::function<void()>& tick) {
  pipeline.set_counting(true);
  std::size_t observed = 0;
  static_cast<void>(for_each_picture(pictures, run.request.seconds, tick, [&](std::size_t, const CameraFrame& frame) {
    observed += pipeline.extract(frame).texels_observed;
  }));
  pipeline.set_counting(false);
  run.counters.sum.texels_observed = observed;
  run.counters.observed_counted = true;
}

}  // namespace

std::vector<double> BenchRun::total_ms() const {
  std::vector<double> result;
  for (const PictureCost& cost : totals) result.push_back(cost.total_ms);
  return result;
}

std::vector<double> BenchRun::step_ms(ExtractionStep step) const {
  std::vector<double> result;
  for (const SteppedCost& cost : stepped) result.push_back(cost.statistics.ms(step));
  return result;
}

std::vector<double> BenchRun::stepped_total_ms() const {
  std::vector<double> result;
  for (const SteppedCost& cost : stepped) result.push_back(cost.statistics.total_ms);
  return result;
}

std::vector<double> BenchRun::ms_per_million_texels() const {
  std::vector<double> result;
  for (const PictureCost& cost : totals) {
    if (cost.statistics.texels_written == 0) continue;
    result.push_back(cost.total_ms / (1e-6 * static_cast<double>(cost.statistics.texels_written)));
  }
  return result;
}

void measure(const BenchRequest& request, TextureStore& store, BenchPictures& pictures, BenchRun& run,
             const std::function<void()>& tick) {
  run.request = request;
  run.counters.describe(store);
  std::unique_ptr<ExtractionPipeline> pipeline;
  try {
    pipeline = make_extraction_pipeline(request.pipeline, store, request.charts, request.extraction);
  } catch (const InputError& error) {
    run.unsupported = error.what();
    run.complete = true;
    return;
  }
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    run.pictures.push_back(pictures.name(i));
    if (run.width > 0) continue;
    if (const CameraFrame* frame = pictures.get(i)) {
      run.camera = frame->camera.name;
      run.width = frame->camera.width;
      run.height = frame->camera.height;
    }
  }
  pipeline->clear();
  warm_up(*pipeline, pictures, request.warm_up, tick);
  if (request.totals) {
    measure_totals(*pipeline, pictures, run, tick);
    pipeline->clear();
  }
  if (request.steps) {
    run.step_timing = timer_queries_are_truthful() ? ExtractionTiming::queries : ExtractionTiming::finish;
    measure_steps(*pipeline, pictures, run, tick);
    pipeline->clear();
  }
  if (request.counting) count_observed(*pipeline, pictures, run, tick);
  run.complete = true;
}

std::unique_ptr<TextureStore> make_store(const PolygonModel& model, const BenchRequest& request) {
  ChartOptions charts = request.charts;
  charts.memory_budget /= set_count(request.publishing);
  return std::make_unique<TextureStore>(model, lay_out_charts(model, charts), request.publishing);
}

std::size_t pictures_to_extract(const BenchRequest& request, std::size_t pictures) {
  const std::size_t runs = (request.totals ? 1U : 0U) + (request.steps ? 1U : 0U) + (request.counting ? 1U : 0U);
  return std::min(pictures, request.warm_up) + runs * pictures;
}

ChartOptions charts_for(PipelineKind pipeline, ChartOptions charts) {
  charts.group_polygons = pipeline == PipelineKind::batched;
  return charts;
}

double bench_clock_ms() {
  static const auto start = std::chrono::steady_clock::now();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace foreview
