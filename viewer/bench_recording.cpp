#include "foreview/viewer/bench_recording.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "foreview/scene/errors.h"
#include "foreview/viewer/extraction_names.h"
#include "foreview/viewer/replay_input.h"

namespace foreview {
namespace {

constexpr std::size_t kPerPolygonPictures = 20;

std::size_t usual_pictures(PipelineKind pipeline) {
  return pipeline == PipelineKind::batched ? std::size_t{1'000'000} : kPerPolygonPictures;
}

std::string rate_of(const BenchRun& run) {
  double extraction = 0, decoding = 0;
  for (const PictureCost& cost : run.totals) {
    extraction += cost.total_ms;
    decoding += cost.decode_ms;
  }
  if (extraction <= 0) return "";
  const double count = static_cast<double>(run.totals.size());
  char text[256];
  std::snprintf(text, sizeof text,
                "%s: %.1f pictures a second without decoding, %.1f with (decoding took %.2f ms each; the sum of both, "
                "one after the other)",
                to_string(run.request.pipeline), 1e3 * count / extraction, 1e3 * count / (extraction + decoding),
                decoding / count);
  return text;
}

}  // namespace

BenchTable steps_table_of(const std::vector<const BenchRun*>& runs, const std::string& title) {
  BenchTable table;
  table.title = title;
  table.unit = "ms per picture, medians [quartiles]";
  table.columns = {"step"};
  for (const BenchRun* run : runs) table.columns.insert(table.columns.end(), {to_string(run->request.pipeline), "%"});
  for (std::size_t i = 0; i < kExtractionSteps; ++i) {
    const auto step = static_cast<ExtractionStep>(i);
    BenchTable::Row& row = table.rows.emplace_back();
    row.label = to_string(step);
    for (const BenchRun* run : runs) {
      double sum = 0, all = 0;
      for (const SteppedCost& cost : run->stepped) {
        sum += cost.statistics.ms(step);
        all += cost.statistics.total_ms;
      }
      const bool is_there = sum > 0;
      row.cells.push_back(is_there ? BenchCell::measured(quantiles_of(run->step_ms(step)), 2) : BenchCell::note("-"));
      row.cells.push_back(is_there ? BenchCell::single(100 * sum / all) : BenchCell::note("-"));
    }
  }
  const auto add = [&](const char* label, auto&& figures, int decimals) {
    BenchTable::Row& row = table.rows.emplace_back();
    row.label = label;
    row.is_sum = true;
    for (const BenchRun* run : runs) {
      row.cells.push_back(BenchCell::measured(quantiles_of(figures(*run)), decimals));
      row.cells.push_back(BenchCell::note(""));
    }
  };
  add(
      "sum of the steps", [](const BenchRun& run) { return run.stepped_total_ms(); }, 2);
  add(
      "total, nothing waiting between", [](const BenchRun& run) { return run.total_ms(); }, 2);
  add(
      "... per million texels written", [](const BenchRun& run) { return run.ms_per_million_texels(); }, 2);
  add(
      "million texels written",
      [](const BenchRun& run) {
        std::vector<double> figures;
        for (const PictureCost& cost : run.totals) {
          figures.push_back(1e-6 * static_cast<double>(cost.statistics.texels_written));
        }
        return figures;
      },
      3);
  add(
      "polygons visible",
      [](const BenchRun& run) {
        std::vector<double> figures;
        for (const PictureCost& cost : run.totals) {
          figures.push_back(static_cast<double>(cost.statistics.polygons_visible));
        }
        return figures;
      },
      0);
  std::string counts = "pictures:";
  for (const BenchRun* run : runs) {
    counts += std::string(" ") + to_string(run->request.pipeline) + " " + std::to_string(run->totals.size());
  }
  table.notes = {counts + ", after " + std::to_string(kWarmUpPictures) + " not counted",
                 "% is of all pictures together. Medians of steps need not add up to the median of their sums; steps "
                 "were timed in a run of their own."};
  return table;
}

void measure_recording(const RecordingBenchOptions& options, BenchReport& report,
                       const std::function<void(std::size_t, std::size_t)>& progress) {
  ReplayInput input(options.replay);
  const Timestamp from = options.replay.from.empty()
                             ? input.recording.first_stamp(input.camera)
                             : input.recording.parse_position(options.replay.from, "--from", input.camera);
  const Timestamp to = options.replay.to.empty()
                           ? input.recording.last_stamp(input.camera)
                           : input.recording.parse_position(options.replay.to, "--to", input.camera);
  if (to < from) throw InputError("--to", "lies before --from; expected the same position or a later one");

  std::vector<BenchRequest> requests;
  std::vector<BenchPictures> pictures;
  std::size_t todo = 0, done = 0;
  for (const PipelineKind pipeline : options.pipelines) {
    BenchRequest& request = requests.emplace_back();
    request.subject = input.recording.name();
    request.pipeline = pipeline;
    request.extraction = options.replay.extraction;
    request.charts = charts_for(pipeline, input.charts);
    request.publishing = options.publishing;
    request.keep_spans = options.keep_spans;
    request.counting = options.counting;
    pictures.push_back(pictures_of(input.recording, input.model, input.camera, from, to,
                                   options.pictures > 0 ? options.pictures : usual_pictures(pipeline)));
    if (pictures.back().size() == 0)
      throw InputError(options.replay.recording.string(), "no picture from --from to --to");
    todo += pictures_to_extract(request, pictures.back().size());
  }
  const auto tick = [&] {
    if (progress) progress(done, todo);
    ++done;
  };
  std::vector<const BenchRun*> measured;
  const auto write = [&] {
    if (measured.empty()) return;
    const BenchRun& first = *measured.front();
    report.tables = {steps_table_of(measured, first.request.subject + ", " + std::to_string(first.width) + "x" +
                                                  std::to_string(first.height) + ", " +
                                                  std::to_string(input.model.polygons().size()) + " polygons")};
    for (const BenchRun* run : measured) {
      const std::string rate = rate_of(*run);
      if (!rate.empty()) report.findings.push_back(rate);
    }
  };
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const std::size_t done_before = done;
    BenchRun& run = report.runs.emplace_back();
    measured.push_back(&run);
    try {
      const std::unique_ptr<TextureStore> store = make_store(input.model, requests[i]);
      measure(requests[i], *store, pictures[i], run, tick);
    } catch (...) {
      write();
      throw;
    }
    if (!run.unsupported.empty()) {
      if (requests.size() == 1) throw InputError(to_string(requests[i].pipeline), run.unsupported);
      measured.pop_back();
    } else if (run.totals.empty()) {
      throw InputError(options.replay.recording.string(), "not one picture can be read");
    }
    done = done_before + pictures_to_extract(requests[i], pictures[i].size());
  }
  write();
}

}  // namespace foreview
