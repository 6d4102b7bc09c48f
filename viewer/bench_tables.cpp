#include "foreview/viewer/bench_tables.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>

#include "foreview/viewer/bench_2005.h"
#include "foreview/viewer/extraction_names.h"

namespace foreview {
namespace {

/// One measurement that tables are made of; several tables may need the same one.
struct Case {
  const BenchSubject* subject;
  BenchRequest request;
  std::size_t pictures;
  std::size_t run = 0;  ///< index into the report's runs
  bool begun = false;
};

struct Plan {
  std::vector<Case> cases;
  Case& find_or_add(const BenchSubject& subject, const BenchRequest& request, std::size_t pictures) {
    for (Case& known : cases) {
      const BenchRequest& r = known.request;
      if (known.subject == &subject && r.pipeline == request.pipeline &&
          r.extraction.artefacts == request.extraction.artefacts && r.extraction.passes == request.extraction.passes &&
          r.extraction.fill == request.extraction.fill &&
          r.extraction.occlusion_query == request.extraction.occlusion_query &&
          r.charts.texels_per_metre == request.charts.texels_per_metre &&
          r.charts.max_texels == request.charts.max_texels && known.pictures == pictures) {
        known.request.totals |= request.totals;
        known.request.steps |= request.steps;
        return known;
      }
    }
    return cases.emplace_back(Case{&subject, request, pictures});
  }
};

void set_size(BenchRequest& request, double density, int max_texels, double scale) {
  request.charts.texels_per_metre = density * scale;
  request.charts.max_texels = std::max(8, static_cast<int>(max_texels * scale));
}

BenchRequest basic_request(const BenchSubject& subject, PipelineKind pipeline, const TablesOptions& options) {
  BenchRequest request;
  request.subject = subject.name;
  request.pipeline = pipeline;
  request.charts = charts_for(pipeline, subject.charts);
  set_size(request, kDensity2005, kMaxTexels2005, options.density);
  request.publishing = options.publishing;
  request.seconds = kSecondsPerRun;
  request.totals = request.steps = false;
  return request;
}

BenchRequest suppressing(BenchRequest request, ArtefactSuppression rule, int passes) {
  request.extraction.artefacts = passes == 0 ? ArtefactSuppression::none : rule;
  request.extraction.passes = passes;
  request.steps = true;
  return request;
}

/// What is measured for the tables, and where each figure is found afterwards.
class Tables {
 public:
  Tables(const BenchSubject& complex, const BenchSubject& object, const BenchSubject& cube,
         const TablesOptions& options, BenchReport& report)
      : subjects_{&complex, &object, &cube}, options_(options), report_(report) {
    for (const PipelineKind pipeline : options.pipelines) plan_for(pipeline);
  }

  void measure_all(const std::function<void(std::size_t, std::size_t)>& progress) {
    std::size_t todo = 0, done = 0;
    for (const Case& one : plan_.cases) todo += pictures_to_extract(one.request, one.pictures);
    const auto tick = [&] {
      if (progress) progress(done, todo);
      ++done;
    };
    std::map<std::pair<const BenchSubject*, std::size_t>, BenchPictures> pictures;
    std::unique_ptr<TextureStore> store;
    const Case* stored_for = nullptr;
    for (Case& one : plan_.cases) {
      const std::size_t done_before = done;
      const auto key = std::pair(one.subject, one.pictures);
      if (!pictures.contains(key)) pictures.emplace(key, one.subject->pictures(one.pictures));
      if (stored_for == nullptr || !same_store(*stored_for, one)) {
        store.reset();
        store = make_store(*one.subject->model, one.request);
      }
      stored_for = &one;
      one.run = report_.runs.size();
      one.begun = true;
      measure(one.request, *store, pictures.at(key), report_.runs.emplace_back(), tick);
      done = done_before + pictures_to_extract(one.request, one.pictures);
    }
    if (progress) progress(todo, todo);
  }

  void write_tables() { report_.tables = {steps_table(), suppression_table(), filling_table(), sizes_table()}; }

 private:
  static bool same_store(const Case& a, const Case& b) {
    return a.subject == b.subject && a.request.pipeline == b.request.pipeline &&
           a.request.charts.texels_per_metre == b.request.charts.texels_per_metre &&
           a.request.charts.max_texels == b.request.charts.max_texels;
  }
  [[nodiscard]] std::size_t pictures_for(PipelineKind pipeline, HoleFilling fill = HoleFilling::pyramid) const {
    const std::size_t count = options_.pictures > 0 ? options_.pictures : default_table_pictures(pipeline);
    return fill == HoleFilling::iterative ? std::min(count, kIterativePictures) : count;
  }
  BenchRequest filling_request(std::size_t subject, PipelineKind pipeline, const Filling2005& filling) const {
    BenchRequest request = basic_request(*subjects_[subject], pipeline, options_);
    request.extraction.fill = filling.fill;
    request.extraction.occlusion_query = filling.query;
    request.steps = true;
    // Minutes per picture on a software rasteriser: what compiling shaders adds does not show.
    if (filling.fill == HoleFilling::iterative && subject == 0) request.warm_up = 0;
    return request;
  }
  BenchRequest size_request(PipelineKind pipeline, const Size2005& size) const {
    BenchRequest request = basic_request(*subjects_[0], pipeline, options_);
    set_size(request, size.density, size.max_texels, options_.density);
    request.totals = true;
    return request;
  }

  void plan_for(PipelineKind pipeline) {
    const std::size_t count = pictures_for(pipeline);
    // First what several tables use; cases with the same textures one after the other.
    BenchRequest base = basic_request(*subjects_[0], pipeline, options_);
    base.totals = base.steps = true;
    base.keep_spans = options_.keep_spans;
    base.counting = options_.counting;
    plan_.find_or_add(*subjects_[0], base, count);
    plan_.find_or_add(*subjects_[0], suppressing(base_without_spans(base), ArtefactSuppression::none, 0), count);
    for (const ArtefactSuppression rule : {ArtefactSuppression::alternating, ArtefactSuppression::diamond}) {
      for (const int passes : kPasses2005) {
        plan_.find_or_add(*subjects_[0], suppressing(base_without_spans(base), rule, passes), count);
      }
    }
    for (std::size_t subject = 0; subject < subjects_.size(); ++subject) {
      for (const Filling2005& filling : kFillings2005) {
        plan_.find_or_add(*subjects_[subject], filling_request(subject, pipeline, filling),
                          pictures_for(pipeline, filling.fill));
      }
    }
    for (const Size2005& size : kSizes2005) plan_.find_or_add(*subjects_[0], size_request(pipeline, size), count);
  }
  static BenchRequest base_without_spans(BenchRequest request) {
    request.totals = request.keep_spans = request.counting = false;
    return request;
  }

  /// The run measured for a request; null where it has not begun or the pipeline refuses it.
  const BenchRun* run_of(std::size_t subject, const BenchRequest& request, std::size_t pictures) {
    const Case& one = plan_.find_or_add(*subjects_[subject], request, pictures);
    if (!one.begun) return nullptr;
    const BenchRun& run = report_.runs[one.run];
    return run.unsupported.empty() ? &run : nullptr;
  }
  const BenchRun* base_run(PipelineKind pipeline) {
    return run_of(0, basic_request(*subjects_[0], pipeline, options_), pictures_for(pipeline));
  }
  /// Says how many pictures are behind it where that is not the usual number.
  static BenchCell counted(BenchCell cell, std::size_t usual) {
    cell.shows_count = cell.count > 0 && cell.count != usual;
    return cell;
  }
  std::string count_note() const {
    std::string note = "pictures per figure:";
    for (const PipelineKind pipeline : options_.pipelines) {
      note += std::string(" ") + to_string(pipeline) + " " + std::to_string(pictures_for(pipeline));
    }
    return note + ", after " + std::to_string(kWarmUpPictures) + " not counted; medians [quartiles]";
  }

  BenchTable steps_table();
  BenchTable suppression_table();
  BenchTable filling_table();
  BenchTable sizes_table();

  std::array<const BenchSubject*, 3> subjects_;
  TablesOptions options_;
  BenchReport& report_;
  Plan plan_;
};

std::string shortened(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

BenchTable Tables::steps_table() {
  BenchTable table;
  table.id = "7.1";
  table.title = "Steps of the extraction, " + subjects_[0]->name + ", d 500, r_max 256, 3 diamond passes, pyramid";
  if (options_.density != 1) table.title += ", densities and r_max of all tables times " + shortened(options_.density);
  table.unit = "ms per picture";
  table.columns = {"step", "2005", "%"};
  std::vector<const BenchRun*> runs;
  for (const PipelineKind pipeline : options_.pipelines) {
    table.columns.insert(table.columns.end(), {to_string(pipeline), "%"});
    runs.push_back(base_run(pipeline));
  }
  for (const StepRow2005& row : step_rows_2005()) {
    BenchTable::Row& line = table.rows.emplace_back();
    line.label = row.label;
    line.cells = {BenchCell::printed(row.ms), BenchCell::single(100 * row.ms / kTotal2005)};
    for (const BenchRun* run : runs) {
      std::vector<double> figures;
      double sum = 0, all = 0;
      for (const SteppedCost& cost : run != nullptr ? run->stepped : std::vector<SteppedCost>{}) {
        double ms = 0;
        for (const ExtractionStep step : row.steps) ms += cost.statistics.ms(step);
        figures.push_back(ms);
        sum += ms;
        all += cost.statistics.total_ms;
      }
      // A step that never took any time is not one of this pipeline's: it happens within another.
      if (sum == 0) {
        line.cells.insert(line.cells.end(), {BenchCell::note("-"), BenchCell::note("-")});
        continue;
      }
      line.cells.push_back(counted(BenchCell::measured(quantiles_of(figures), 2), pictures_for(run->request.pipeline)));
      line.cells.push_back(BenchCell::single(100 * sum / all));
    }
  }
  const auto add = [&](const char* label, const BenchCell& printed, auto&& figures, int decimals, bool is_sum) {
    BenchTable::Row& line = table.rows.emplace_back();
    line.label = label;
    line.is_sum = is_sum;
    line.cells = {printed, BenchCell::note("")};
    for (const BenchRun* run : runs) {
      line.cells.push_back(run == nullptr ? BenchCell::note("-")
                                          : BenchCell::measured(quantiles_of(figures(*run)), decimals));
      line.cells.push_back(BenchCell::note(""));
    }
  };
  add(
      "sum of the steps", BenchCell::printed(kTotal2005), [](const BenchRun& run) { return run.stepped_total_ms(); }, 2,
      true);
  add(
      "total, nothing waiting between", BenchCell::note(""), [](const BenchRun& run) { return run.total_ms(); }, 2,
      true);
  add(
      "... per million texels written", BenchCell::note(""),
      [](const BenchRun& run) { return run.ms_per_million_texels(); }, 2, true);
  add(
      "million texels written", BenchCell::note(""),
      [](const BenchRun& run) {
        std::vector<double> figures;
        for (const PictureCost& cost : run.totals) {
          figures.push_back(1e-6 * static_cast<double>(cost.statistics.texels_written));
        }
        return figures;
      },
      3, true);
  table.notes = {count_note(),
                 "% is of all pictures together. Medians of steps need not add up to the median of their sums.",
                 "Steps were timed in a run of their own; a step booked under another shows '-' (2005's table: "
                 "normalisation with fusion)."};
  return table;
}

BenchTable Tables::suppression_table() {
  BenchTable table;
  table.id = "7.2";
  table.title = "Artefact suppression by number of passes, " + subjects_[0]->name;
  table.unit = "ms more per picture than without";
  table.columns = {"passes"};
  table.rows.resize(kPasses2005.size() + 1);
  table.rows[0].label = "0";
  for (std::size_t i = 0; i < kPasses2005.size(); ++i) table.rows[i + 1].label = std::to_string(kPasses2005[i]);
  const auto add = [&](const char* name, ArtefactSuppression rule, const std::array<double, 6>& printed) {
    table.columns.push_back(std::string(name) + ", 2005");
    for (std::size_t i = 0; i < printed.size(); ++i) table.rows[i].cells.push_back(BenchCell::printed(printed[i]));
    for (const PipelineKind pipeline : options_.pipelines) {
      table.columns.emplace_back(to_string(pipeline));
      const BenchRequest base = basic_request(*subjects_[0], pipeline, options_);
      const BenchRun* without = run_of(0, suppressing(base, rule, 0), pictures_for(pipeline));
      table.rows[0].cells.push_back(without == nullptr ? BenchCell::note("-") : BenchCell::single(0));
      for (std::size_t i = 0; i < kPasses2005.size(); ++i) {
        const BenchRun* with = run_of(0, suppressing(base, rule, kPasses2005[i]), pictures_for(pipeline));
        std::vector<double> more;
        if (with != nullptr && without != nullptr) {
          const std::vector<double> ms = with->step_ms(ExtractionStep::suppression),
                                    base_ms = without->step_ms(ExtractionStep::suppression);
          for (std::size_t k = 0; k < std::min(ms.size(), base_ms.size()); ++k) more.push_back(ms[k] - base_ms[k]);
        }
        table.rows[i + 1].cells.push_back(counted(BenchCell::measured(quantiles_of(more)), pictures_for(pipeline)));
      }
    }
  };
  add("bilinear (alternating)", ArtefactSuppression::alternating, kBilinear2005);
  add("diamond", ArtefactSuppression::diamond, kDiamond2005);
  table.notes = {count_note(), "Time of this step, less what it takes the same picture without suppression."};
  return table;
}

BenchTable Tables::filling_table() {
  BenchTable table;
  table.id = "7.3";
  table.title = "Hole filling";
  table.unit = "ms of this step per picture";
  table.columns = {"scene and filling", "2005"};
  for (const PipelineKind pipeline : options_.pipelines) table.columns.emplace_back(to_string(pipeline));
  for (std::size_t subject = 0; subject < subjects_.size(); ++subject) {
    for (const Filling2005& filling : kFillings2005) {
      BenchTable::Row& row = table.rows.emplace_back();
      row.label = subjects_[subject]->name + ", " + filling.name;
      row.cells.push_back(BenchCell::printed(filling.ms[subject]));
      for (const PipelineKind pipeline : options_.pipelines) {
        const BenchRun* run =
            run_of(subject, filling_request(subject, pipeline, filling), pictures_for(pipeline, filling.fill));
        row.cells.push_back(run == nullptr
                                ? BenchCell::note("-")
                                : counted(BenchCell::measured(quantiles_of(run->step_ms(ExtractionStep::filling)), 2),
                                          pictures_for(pipeline)));
      }
    }
  }
  table.notes = {count_note() + "; iterative: at most " + std::to_string(kIterativePictures) + ", on " +
                     subjects_[0]->name + " without warm-up",
                 "2005's scenes: a complex one, a partly textured object, an almost fully textured cube."};
  return table;
}

BenchTable Tables::sizes_table() {
  BenchTable table;
  table.id = "7.4";
  table.title = "Density d and largest texture r_max, " + subjects_[0]->name;
  table.unit = "ms per picture, nothing waiting between the steps";
  table.columns = {"d, r_max", "2005"};
  for (const PipelineKind pipeline : options_.pipelines) {
    table.columns.insert(table.columns.end(), {to_string(pipeline), "per M texels", "M texels"});
  }
  for (const Size2005& size : kSizes2005) {
    BenchTable::Row& row = table.rows.emplace_back();
    char label[40];
    std::snprintf(label, sizeof label, "%g, %d", size.density, size.max_texels);
    row.label = label;
    row.cells = {BenchCell::printed(size.ms)};
    for (const PipelineKind pipeline : options_.pipelines) {
      const BenchRun* run = run_of(0, size_request(pipeline, size), pictures_for(pipeline));
      if (run == nullptr || run->totals.empty()) {
        row.cells.insert(row.cells.end(), 3, BenchCell::note("-"));
        continue;
      }
      row.cells.push_back(counted(BenchCell::measured(quantiles_of(run->total_ms())), pictures_for(pipeline)));
      row.cells.push_back(BenchCell::measured(quantiles_of(run->ms_per_million_texels()), 2));
      row.cells.push_back(BenchCell::single(
          1e-6 * static_cast<double>(run->counters.sum.texels_written) / static_cast<double>(run->totals.size()), 2));
    }
  }
  table.notes = {count_note(), "2005's 464.7 ms for 500, 512: textures were swapped out of its graphics memory."};
  return table;
}

}  // namespace

std::size_t default_table_pictures(PipelineKind pipeline) {
  return pipeline == PipelineKind::batched ? 40 : 8;
}

void measure_tables(const BenchSubject& complex, const BenchSubject& object, const BenchSubject& cube,
                    const TablesOptions& options, BenchReport& report,
                    const std::function<void(std::size_t, std::size_t)>& progress) {
  Tables tables(complex, object, cube, options, report);
  try {
    tables.measure_all(progress);
  } catch (...) {
    tables.write_tables();
    throw;
  }
  tables.write_tables();
}

}  // namespace foreview
