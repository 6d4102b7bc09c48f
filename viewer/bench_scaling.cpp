#include "foreview/viewer/bench_scaling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "foreview/viewer/bench_scene.h"
#include "foreview/viewer/extraction_names.h"

namespace foreview {
namespace {

constexpr std::array<std::size_t, 7> kPolygons{100, 300, 1000, 3000, 10'000, 30'000, 100'000};
constexpr std::array<double, 6> kMegapixels{0.3, 0.6, 1.2, 2.4, 4.8, 8.3};
constexpr std::array<double, 5> kDensities{50, 100, 200, 400, 800};
constexpr std::size_t kUsualPolygons = 2000;
constexpr double kUsualMegapixels = 0.5;
constexpr double kUsualDensity = 200;  // texels per metre
constexpr int kMaxTexels = 1024;
constexpr std::size_t kPairPolygons = 5000;  // and twice as many
constexpr int kPairTurns = 3;

ChartOptions room_charts(PipelineKind pipeline, double density) {
  ChartOptions charts = charts_for(pipeline, {});
  charts.texels_per_metre = density;
  charts.max_texels = kMaxTexels;
  return charts;
}

std::string text_of(const char* format, auto... values) {
  char text[320];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

double mean_texels(const BenchRun& run) {
  return run.totals.empty()
             ? 0
             : static_cast<double>(run.counters.sum.texels_written) / static_cast<double>(run.totals.size());
}

double mean_visible(const BenchRun& run) {
  return run.totals.empty()
             ? 0
             : static_cast<double>(run.counters.sum.polygons_visible) / static_cast<double>(run.totals.size());
}

class Scaling {
 public:
  Scaling(const ScalingOptions& options, PipelineKind pipeline, BenchReport& report,
          const std::function<void(const std::string&)>& tick)
      : options_(options), pipeline_(pipeline), report_(report), tick_(tick) {}

  void measure_all() {
    const double usual_megapixels = std::min(kUsualMegapixels, options_.most_megapixels);
    const PolygonModel usual = bumpy_room(std::min(kUsualPolygons, options_.most_polygons));
    layout_texels_ = lay_out_charts(usual, room_charts(pipeline_, kUsualDensity)).written_texels;
    usual_texels_ = texels_written(usual, kUsualDensity, usual_megapixels);
    if (usual_texels_ <= 0) {
      refuse(usual);
      return;
    }

    begin_curve("polygons", "polygons of the room, at equal texels", "polygons");
    for (const std::size_t polygons : kPolygons) {
      if (polygons > options_.most_polygons) break;
      const PolygonModel room = bumpy_room(polygons);
      const double density = equal_density(room, usual_megapixels);
      if (!add_point(polygons == kPolygons.back(), static_cast<double>(room.polygons().size()), room, density,
                     usual_megapixels))
        break;
    }
    end_curve();

    begin_curve("pixels", text_of("size of the picture, %zu polygons", usual.polygons().size()), "megapixels");
    for (const double megapixels : kMegapixels) {
      if (megapixels > options_.most_megapixels + 1e-9) break;
      const CameraModel camera = room_camera(megapixels);
      if (!add_point(megapixels == kMegapixels.back(), 1e-6 * camera.width * camera.height, usual, kUsualDensity,
                     megapixels))
        break;
    }
    end_curve();

    begin_curve("texels", text_of("texels written, by density, %zu polygons", usual.polygons().size()),
                "million texels written per picture");
    for (const double density : kDensities) {
      if (!add_point(density == kDensities.back(), std::nullopt, usual, density, usual_megapixels)) break;
    }
    end_curve();
    compare_pair(usual_megapixels);
  }

 private:
  /// Says in the report why this pipeline is not measured.
  void refuse(const PolygonModel& model) {
    const BenchRequest one = request("room", room_charts(pipeline_, kUsualDensity));
    BenchPictures none = room_pictures(room_camera(0.01), 0);
    measure(one, *make_store(model, one), none, report_.runs.emplace_back());
  }

  void begin_curve(const char* id, const std::string& title, const char* x_label) {
    ScalingCurve& curve = report_.curves.emplace_back();
    curve.id = id;
    curve.title = title;
    curve.x_label = x_label;
    curve.pipeline = pipeline_;
  }

  BenchRequest request(const std::string& subject, const ChartOptions& charts) const {
    BenchRequest result;
    result.subject = subject;
    result.pipeline = pipeline_;
    result.charts = charts;
    result.publishing = options_.publishing;
    result.steps = options_.keep_spans;
    result.keep_spans = options_.keep_spans;
    result.counting = options_.counting;
    return result;
  }
  [[nodiscard]] std::size_t pictures() const {
    return options_.pictures > 0 ? options_.pictures : default_scaling_pictures(pipeline_);
  }

  /// x is the texels written where not given. False where the curve ends before this point.
  bool add_point(bool is_last, std::optional<double> x, const PolygonModel& model, double density, double megapixels) {
    ScalingCurve& curve = report_.curves.back();
    const double begun = bench_clock_ms();
    const std::string name = text_of("%s %zu", curve.id.c_str(), curve.points.size() + 1);
    const BenchRequest point =
        request(text_of("room of %zu polygons", model.polygons().size()), room_charts(pipeline_, density));
    const std::unique_ptr<TextureStore> store = make_store(model, point);
    BenchPictures pictures = room_pictures(room_camera(megapixels), this->pictures());
    const std::size_t index = report_.runs.size();
    BenchRun& run = report_.runs.emplace_back();
    measure(point, *store, pictures, run, [&] { tick_(name); });
    if (!run.unsupported.empty()) return false;
    curve.points.push_back({x.value_or(1e-6 * mean_texels(run)), quantiles_of(run.total_ms()), index});
    // Steps of the sizes are of a factor of four or less.
    if (!is_last && 4e-3 * (bench_clock_ms() - begun) > options_.point_seconds) {
      report_.findings.push_back(text_of("%s, %s: no larger sizes, the next would take more than %.0f s",
                                         curve.id.c_str(), to_string(pipeline_), options_.point_seconds));
      return false;
    }
    return true;
  }

  void end_curve() {
    ScalingCurve& curve = report_.curves.back();
    if (curve.points.size() < 2) return;
    std::vector<double> x, t;
    for (const ScalingCurve::Point& point : curve.points) {
      x.push_back(point.x);
      t.push_back(point.ms.median);
    }
    curve.fit = fit_growth(x, t);
    report_.findings.push_back(finding_of(curve));
  }

  /// Texels that a picture is seen to write, mean of a few pictures.
  double texels_written(const PolygonModel& model, double density, double megapixels) {
    BenchRequest one = request("equal texels", room_charts(pipeline_, density));
    const std::unique_ptr<TextureStore> store = make_store(model, one);
    BenchPictures pictures = room_pictures(room_camera(megapixels), this->pictures());
    one.steps = one.keep_spans = one.counting = false;
    BenchRun run;
    measure(one, *store, pictures, run, [&] { tick_("equal texels"); });
    return mean_texels(run);
  }

  /// The density at which a picture of this room writes as many texels as one of the usual room: corrected by what
  /// pictures are seen to write, as far as sizes of textures allow, which may jump by powers of two.
  double equal_density(const PolygonModel& model, double megapixels) {
    double density = density_for_texels(model, room_charts(pipeline_, kUsualDensity), layout_texels_);
    double best = density, best_error = 1e300;
    for (int tries = 0; tries < 4; ++tries) {
      const double written = texels_written(model, density, megapixels);
      if (written <= 0) break;
      const double error = std::abs(std::log(written / usual_texels_));
      if (error < best_error) {
        best_error = error;
        best = density;
      }
      if (error < 0.02) break;
      density *= std::sqrt(usual_texels_ / written);
    }
    return best;
  }

  /// Twice the polygons at equal texels, measured in turn, so that what else happens on the machine meets both.
  void compare_pair(double megapixels) {
    const std::size_t count = std::min(kPairPolygons, options_.most_polygons / 2);
    if (count < 12) return;
    const std::array<PolygonModel, 2> rooms{bumpy_room(count), bumpy_room(2 * count)};
    const CameraModel camera = room_camera(megapixels);
    std::array<double, 2> densities{};
    std::array<std::unique_ptr<TextureStore>, 2> stores;
    std::array<double, 2> written{}, visible{};
    for (std::size_t i = 0; i < 2; ++i) {
      densities[i] = equal_density(rooms[i], megapixels);
      stores[i] = make_store(rooms[i], request("", room_charts(pipeline_, densities[i])));
    }
    std::array<std::vector<double>, 2> ms;
    for (int turn = 0; turn < kPairTurns; ++turn) {
      for (std::size_t i = 0; i < 2; ++i) {
        BenchPictures pictures = room_pictures(camera, this->pictures());
        BenchRun& run = report_.runs.emplace_back();
        measure(request(text_of("room of %zu polygons, pair", rooms[i].polygons().size()),
                        room_charts(pipeline_, densities[i])),
                *stores[i], pictures, run, [&] { tick_("pair"); });
        if (!run.unsupported.empty()) return;
        const std::vector<double> more = run.total_ms();
        ms[i].insert(ms[i].end(), more.begin(), more.end());
        written[i] = mean_texels(run);
        visible[i] = mean_visible(run);
      }
    }
    const double once = quantiles_of(ms[0]).median, twice = quantiles_of(ms[1]).median;
    report_.findings.push_back(
        text_of("twice the polygons at equal texels, %s: %.0f -> %.0f visible, %.3f -> %.3f M texels written, "
                "%.2f -> %.2f ms: %+.1f %%%s",
                to_string(pipeline_), visible[0], visible[1], 1e-6 * written[0], 1e-6 * written[1], once, twice,
                100 * (twice / once - 1), twice < 1.2 * once ? ", less than 20 % more" : ", NOT less than 20 % more"));
  }

  const ScalingOptions& options_;
  PipelineKind pipeline_;
  BenchReport& report_;
  const std::function<void(const std::string&)>& tick_;
  double layout_texels_ = 0, usual_texels_ = 0;  ///< of the usual room: to write in all, and seen written by a picture
};

BenchTable table_of(const ScalingCurve& curve, const BenchReport& report) {
  BenchTable table;
  table.title = "By " + curve.title + ", " + to_string(curve.pipeline);
  table.unit = "medians [quartiles]";
  table.columns = {curve.x_label, "ms per picture", "ms per M texels", "M texels", "visible", "picture"};
  for (const ScalingCurve::Point& point : curve.points) {
    const BenchRun& run = report.runs[point.run];
    BenchTable::Row& row = table.rows.emplace_back();
    row.label = text_of("%.6g", point.x);
    row.cells = {BenchCell::measured(point.ms, 2), BenchCell::measured(quantiles_of(run.ms_per_million_texels()), 2),
                 BenchCell::single(1e-6 * mean_texels(run), 3), BenchCell::single(mean_visible(run), 0),
                 BenchCell::note(text_of("%dx%d", run.width, run.height))};
  }
  return table;
}

}  // namespace

std::size_t default_scaling_pictures(PipelineKind pipeline) {
  return pipeline == PipelineKind::batched ? 16 : 4;
}

double density_for_texels(const PolygonModel& model, ChartOptions charts, double texels) {
  double low = 1, high = 4000, best = charts.texels_per_metre, best_error = 1e300;
  double density = charts.texels_per_metre;
  for (int i = 0; i < 8; ++i) {
    charts.texels_per_metre = density;
    const double written = lay_out_charts(model, charts).written_texels;
    const double error = std::abs(std::log(written / texels));
    if (error < best_error) {
      best_error = error;
      best = density;
    }
    if (error < 0.02) break;
    (written < texels ? low : high) = density;
    // Texels grow with the square of the density, less where gutters weigh; and never beyond what is known.
    density *= std::sqrt(texels / written);
    if (density <= low || density >= high) density = std::sqrt(low * high);
  }
  return best;
}

std::string finding_of(const ScalingCurve& curve) {
  const GrowthFit& fit = curve.fit;
  const double per = curve.id == "polygons" ? 1000 : 1;
  const char* unit = curve.id == "polygons" ? "1000 polygons" : curve.id == "pixels" ? "megapixel" : "million texels";
  return text_of("%s, %s: %.6g to %.6g, t = %.2f ms %+.3f ms per %s; t ~ x^%.2f, at the end x^%.2f: %s",
                 curve.id.c_str(), to_string(curve.pipeline), curve.points.front().x, curve.points.back().x,
                 fit.constant, fit.slope * per, unit, fit.exponent, fit.exponent_at_end,
                 fit.at_most_linear ? "at most linear" : "MORE than linear");
}

void measure_scaling(const ScalingOptions& options, BenchReport& report,
                     const std::function<void(const std::string&)>& tick) {
  const auto write_tables = [&] {
    report.tables.clear();
    for (const ScalingCurve& curve : report.curves) {
      if (!curve.points.empty()) report.tables.push_back(table_of(curve, report));
    }
  };
  try {
    for (const PipelineKind pipeline : options.pipelines) Scaling(options, pipeline, report, tick).measure_all();
  } catch (...) {
    write_tables();
    throw;
  }
  write_tables();
}

}  // namespace foreview
