#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "foreview/gpu/offscreen_context.h"
#include "foreview/recordings/builtin.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/output_file.h"
#include "foreview/viewer/bench_2005.h"
#include "foreview/viewer/bench_display.h"
#include "foreview/viewer/bench_html.h"
#include "foreview/viewer/bench_recording.h"
#include "foreview/viewer/bench_report.h"
#include "foreview/viewer/bench_scaling.h"
#include "foreview/viewer/bench_tables.h"
#include "foreview/viewer/bench_trace.h"
#include "foreview/viewer/commands.h"
#include "foreview/viewer/extraction_names.h"
#include "foreview/viewer/gl_debug.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/progress.h"
#include "foreview/viewer/replay_input.h"
#include "foreview/viewer/replay_options_cli.h"

namespace foreview {
namespace {

/// What all three benchmarks take.
struct BenchOutput {
  std::string pipeline = "batched";
  std::size_t pictures = 0;
  bool stats = false;
  bool buffered = false;
  std::filesystem::path json, html, trace;
};

struct BenchCommand {
  BenchOutput output;
  ReplayOptions replay;  ///< of one's own recording
  bool quick = false;
  ScalingOptions scaling;
  std::vector<std::pair<std::string, std::string>> given;
};

std::vector<PipelineKind> pipelines_of(const std::string& text) {
  if (text == "both") return {PipelineKind::batched, PipelineKind::per_polygon};
  if (text == "batched") return {PipelineKind::batched};
  if (text == "per-polygon") return {PipelineKind::per_polygon};
  throw InputError("--pipeline", "'" + text + "' is none of its values: batched, per-polygon, both");
}

Publishing publishing_of(const BenchOutput& output) {
  return output.buffered ? Publishing::buffered : Publishing::direct;
}

/// A graphics context, a benchmark in it, and what comes of it on the terminal and in files, also after Ctrl-C.
void run_and_report(const BenchOutput& output, BenchReport& report,
                    const std::function<void(OffscreenContext&)>& work) {
  check_output_file(output.json, "--json");
  check_output_file(output.html, "--html");
  check_output_file(output.trace, "--trace");
  const GlDebug debug = gl_debug_from_environment();
  OffscreenContext::Options context_options;
  context_options.debug = debug != GlDebug::off;
  OffscreenContext context(context_options);
  context.make_current();
  if (debug != GlDebug::off) install_debug_callback(debug == GlDebug::fatal);

  report.with_counters = output.stats;
  report.options.emplace_back("pipeline", output.pipeline);
  report.options.emplace_back("publishing", output.buffered ? "buffered" : "direct");
  report.machine = describe_machine();
  std::fputs((machine_text(report.machine) + "\n").c_str(), stdout);
  std::fflush(stdout);
  bool was_interrupted = false;
  try {
    work(context);
    report.complete = true;
  } catch (const Interrupted&) {
    was_interrupted = true;
  }
  if (was_interrupted) std::fputs("interrupted: only what was measured so far\n\n", stdout);
  std::fputs(report_text(report).c_str(), stdout);
  std::fflush(stdout);
  if (!output.json.empty()) write_file_whole(output.json, report_json(report));
  if (!output.html.empty()) write_file_whole(output.html, report_html(report));
  if (!output.trace.empty()) write_file_whole(output.trace, report_trace(report));
  if (was_interrupted) throw Interrupted();
}

/// A built-in recording as a table's subject. With `quick` a few small pictures of it.
class BuiltinSubject {
 public:
  BuiltinSubject(const std::string& name, bool quick) : input_(options_for(name, quick)) {
    // The backdrop would outweigh the few polygons of the object and the cube, and 2005 had none.
    ImportOptions import = input_.recording.import_options();
    import.backdrop = false;
    model_ = import_model(input_.recording.scene_file().value(), import);
    subject.name = name;
    subject.model = &model_;
    subject.charts = input_.charts;
    subject.pictures = [this](std::size_t count) {
      return pictures_of(input_.recording, model_, input_.camera, input_.recording.first_stamp(input_.camera),
                         input_.recording.last_stamp(input_.camera), count);
    };
  }
  [[nodiscard]] const ReplayInput& input() const { return input_; }
  BenchSubject subject;

 private:
  static ReplayOptions options_for(const std::string& name, bool quick) {
    GenerateOptions generate;
    generate.name = name;
    if (quick) {
      generate.pictures = 4;
      generate.scale = 0.2;
    }
    std::unique_ptr<ProgressBar> bar;
    ReplayOptions options;
    options.recording = cached_recording(generate, [&](std::size_t done, std::size_t todo) {
      throw_if_interrupted();
      if (!bar) bar = std::make_unique<ProgressBar>("generating " + name, todo);
      bar->update(done);
    });
    options.density = 500;
    options.max_texels = 256;
    return options;
  }
  ReplayInput input_;
  PolygonModel model_;
};

/// Table 7.5.
void measure_beside_display(const BuiltinSubject& subject, const BenchCommand& command, OffscreenContext& context,
                            BenchReport& report) {
  const std::vector<PipelineKind> pipelines = pipelines_of(command.output.pipeline);
  if (std::find(pipelines.begin(), pipelines.end(), PipelineKind::batched) == pipelines.end()) return;
  Recording recording = subject.input().recording;
  DisplayBenchOptions options;
  options.camera = subject.input().camera;
  options.charts = charts_for(PipelineKind::batched, subject.input().charts);
  options.charts.texels_per_metre = kDensity2005;
  options.charts.max_texels = kMaxTexels2005;
  if (command.quick) {
    options.charts.texels_per_metre *= 0.1;
    options.charts.max_texels /= 10;
    options.seconds = 0.5;
    options.width = 160;
    options.height = 120;
  }
  std::unique_ptr<ProgressBar> progress;
  measure_display_table(recording, *subject.subject.model, context, options, report,
                        [&](std::size_t done, std::size_t todo) {
                          throw_if_interrupted();
                          if (!progress) progress = std::make_unique<ProgressBar>("beside a display", todo);
                          progress->update(done);
                        });
}

void run_tables(const BenchCommand& command) {
  TablesOptions options;
  options.pipelines = pipelines_of(command.output.pipeline);
  options.pictures = command.output.pictures > 0 ? command.output.pictures : command.quick ? 3 : 0;
  if (command.quick) options.density = 0.1;
  options.keep_spans = !command.output.trace.empty();
  options.counting = command.output.stats;
  options.publishing = publishing_of(command.output);
  BenchReport report;
  report.kind = "tables";
  report.title = command.quick ? "Tables 7.1-7.5, a quick trial with small pictures: not comparable with 2005"
                               : "Tables 7.1-7.5 on the built-in recordings";
  report.options.emplace_back("pictures", std::to_string(options.pictures));
  report.options.emplace_back("quick", command.quick ? "true" : "false");
  run_and_report(command.output, report, [&](OffscreenContext& context) {
    const BuiltinSubject workcell("workcell", command.quick), object("object", command.quick),
        cube("cube", command.quick);
    if (command.quick) std::puts("a quick trial with small pictures: not comparable with 2005\n");
    std::unique_ptr<ProgressBar> progress;
    measure_tables(workcell.subject, object.subject, cube.subject, options, report,
                   [&](std::size_t done, std::size_t todo) {
                     throw_if_interrupted();
                     if (!progress) progress = std::make_unique<ProgressBar>("measuring", todo);
                     progress->update(done);
                   });
    measure_beside_display(workcell, command, context, report);
  });
}

void run_scaling(const BenchCommand& command) {
  ScalingOptions options = command.scaling;
  options.pipelines = pipelines_of(command.output.pipeline);
  options.pictures = command.output.pictures;
  options.keep_spans = !command.output.trace.empty();
  options.counting = command.output.stats;
  options.publishing = publishing_of(command.output);
  BenchReport report;
  report.kind = "scaling";
  report.title = "How the cost of a picture grows";
  report.options.emplace_back("pictures", std::to_string(options.pictures));
  report.options.emplace_back("most_polygons", std::to_string(options.most_polygons));
  report.options.emplace_back("most_megapixels", std::to_string(options.most_megapixels));
  run_and_report(command.output, report, [&](OffscreenContext&) {
    ProgressBar progress("measuring", 0);
    std::size_t done = 0;
    measure_scaling(options, report, [&](const std::string&) {
      throw_if_interrupted();
      progress.update(++done);
    });
  });
}

void run_recording(const BenchCommand& command) {
  if (command.replay.recording.empty()) {
    throw InputError("bench", "expected tables, scaling or a RECORDING (see foreview bench --help)");
  }
  BenchReport report;
  report.kind = "recording";
  report.title = "Extraction on " + command.replay.recording.string();
  RecordingBenchOptions options;
  options.replay = command.replay;
  options.pipelines = pipelines_of(command.output.pipeline);
  options.pictures = command.output.pictures;
  options.keep_spans = !command.output.trace.empty();
  options.counting = command.output.stats;
  options.publishing = publishing_of(command.output);
  report.options.emplace_back("recording", command.replay.recording.string());
  report.options.emplace_back("from", command.replay.from);
  report.options.emplace_back("to", command.replay.to);
  report.options.emplace_back("pictures", std::to_string(options.pictures));
  run_and_report(command.output, report, [&](OffscreenContext&) {
    std::unique_ptr<ProgressBar> bar;
    measure_recording(options, report, [&](std::size_t done, std::size_t todo) {
      throw_if_interrupted();
      if (!bar) bar = std::make_unique<ProgressBar>("measuring", todo);
      bar->update(done);
    });
  });
}

/// The same on each of the three: only one of them is parsed.
void add_output_options(CLI::App& app, BenchOutput& output) {
  app.add_option_function<std::string>(
         "--pipeline",
         [&output](const std::string& text) {
           static_cast<void>(pipelines_of(text));
           output.pipeline = text;
         },
         "batched, per-polygon (the method of 2005) or both, side by side (default: batched)")
      ->type_name("KIND");
  app.add_option_function<std::string>(
         "--pictures", [&output](const std::string& text) { output.pictures = parse_count(text, "--pictures"); },
         "Measure with so many pictures, spread evenly, instead of the usual number")
      ->type_name("N");
  app.add_option("--json", output.json, "Write all figures, of every picture too, to this file")->type_name("FILE");
  app.add_option("--html", output.html, "Write one page with tables and plots, which needs nothing else")
      ->type_name("FILE");
  app.add_option("--trace", output.trace,
                 "Write CPU and GPU spans of every picture in Chrome's trace-event format; opens in ui.perfetto.dev")
      ->type_name("FILE");
  app.add_flag("--buffered", output.buffered,
               "Keep three sets of textures, as a live display needs, so that handing them over is measured, too");
  app.add_flag("--stats", output.stats,
               "Print the counters of each run, too; observed texels are counted in one more run over the pictures");
}

}  // namespace

void add_bench_command(CLI::App& app) {
  CLI::App& bench = *app.add_subcommand(
      "bench",
      "How fast are textures extracted here? On a recording of one's own by step; 'tables': the tables of 2005 on the "
      "built-in recordings; 'scaling': how the cost grows with polygons, pixels and texels.");
  const auto command = std::make_shared<BenchCommand>();
  add_replay_options(bench, command->replay);
  bench.get_option("RECORDING")->required(false);
  for (const char* of_the_view : {"--delay", "--history", "--load-textures", "--save-textures"}) {
    bench.remove_option(bench.get_option(of_the_view));
  }
  bench.get_option("--camera")->description("Whose pictures are measured (default: the recording's first camera)");
  std::vector<const CLI::Option*> only_for_recordings;
  for (const CLI::Option* option : bench.get_options()) {
    if (option->get_positional()) continue;
    if (option != bench.get_help_ptr()) only_for_recordings.push_back(option);
  }
  add_output_options(bench, command->output);
  bench.require_subcommand(0, 1);
  bench.footer(
      "Examples:\n"
      "  foreview bench my-recording --html bench.html\n"
      "  foreview bench tables --pipeline both --json tables.json\n"
      "  foreview bench scaling --html scaling.html");

  CLI::App* tables = bench.add_subcommand(
      "tables",
      "Tables 7.1-7.5 of 2005 on the built-in recordings workcell, object and cube, the figures of 2005 beside ours");
  add_output_options(*tables, command->output);
  tables->add_flag("--quick", command->quick, "A trial with a few small pictures: not comparable with 2005");
  tables->footer("Example: foreview bench tables --pipeline both --html tables.html");

  CLI::App* scaling = bench.add_subcommand(
      "scaling", "How the cost of a picture grows with polygons, pixels and texels, in a generated room");
  add_output_options(*scaling, command->output);
  scaling
      ->add_option_function<std::string>(
          "--most-polygons",
          [command](const std::string& text) { command->scaling.most_polygons = parse_count(text, "--most-polygons"); },
          "Largest number of polygons (default: 100000)")
      ->type_name("N");
  scaling->add_option("--most-megapixels", command->scaling.most_megapixels, "Largest pictures (default: 8.3)")
      ->type_name("MP")
      ->check([](const std::string& text) {
        try {
          const double value = std::stod(text);
          if (value >= 0.01 && value <= 100) return std::string();
        } catch (const std::exception&) {
        }
        return "'" + text + "' cannot be; expected 0.01 to 100";
      });
  scaling->footer("Example: foreview bench scaling --most-polygons 10000 --html scaling.html");

  bench.callback([command, only_for_recordings, tables, scaling] {
    const bool is_recording = !tables->parsed() && !scaling->parsed();
    if (!is_recording && !command->replay.recording.empty()) {
      throw InputError("bench", "expected either tables, scaling or a RECORDING, not two of them");
    }
    for (const CLI::Option* option : only_for_recordings) {
      if (!is_recording && option->count() > 0) {
        throw InputError(option->get_name(), "is only for bench RECORDING, not for bench tables or scaling");
      }
    }
    if (tables->parsed()) {
      run_tables(*command);
    } else if (scaling->parsed()) {
      run_scaling(*command);
    } else {
      run_recording(*command);
    }
  });
}

}  // namespace foreview
