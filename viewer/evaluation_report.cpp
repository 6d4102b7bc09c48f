#include "foreview/viewer/evaluation_report.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "foreview/viewer/extraction_names.h"
#include "foreview/viewer/registration_report.h"

namespace foreview {
namespace {

using Json = nlohmann::ordered_json;

/// Figures where more is better.
template <typename Figure>
MeanAndWorst mean_and_worst(const Evaluation& evaluation, Figure&& figure) {
  MeanAndWorst result;
  double sum = 0;
  for (const InstantScore& instant : evaluation.instants) {
    const std::optional<double> value = figure(instant);
    if (!value) continue;
    if (result.instants == 0 || *value < result.worst) {
      result.worst = *value;
      result.worst_stem = instant.stem;
    }
    sum += *value;
    ++result.instants;
  }
  if (result.instants > 0) result.mean = sum / static_cast<double>(result.instants);
  return result;
}

EvaluationSummary::View summarise_view(const Evaluation& evaluation, ViewScore InstantScore::*view) {
  return {mean_and_worst(evaluation, [&](const InstantScore& i) { return std::optional((i.*view).psnr); }),
          mean_and_worst(evaluation, [&](const InstantScore& i) { return (i.*view).ssim; })};
}

template <typename... Values>
std::string line(const char* format, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return std::string(text) + "\n";
}

std::string table_row(const char* name, const EvaluationSummary::View& view) {
  return line("  %-14s %9.2f %8.2f  %-14s %7.3f %8.3f", name, view.psnr.mean, view.psnr.worst,
              view.psnr.worst_stem.substr(0, 14).c_str(), view.ssim.mean, view.ssim.worst);
}

Json json_of(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json json_of(const MeanAndWorst& figure) {
  if (figure.instants == 0) return nullptr;
  return {{"mean", figure.mean}, {"worst", figure.worst}, {"worst_picture", figure.worst_stem}};
}

Json json_of(const EvaluationSummary::View& view) {
  return {{"psnr", json_of(view.psnr)}, {"ssim", json_of(view.ssim)}};
}

Json json_of(const ViewScore& score) {
  return {{"psnr", score.psnr}, {"ssim", json_of(score.ssim)}};
}

Json json_of(const PixelError& error) {
  Json result{{"pixels", error.pixels}};
  result["rms"] = error.pixels > 0 ? Json(error.rms()) : Json(nullptr);
  result["mean_absolute"] = error.pixels > 0 ? Json(error.mean_absolute) : Json(nullptr);
  result["psnr"] = json_of(error.psnr());
  return result;
}

Json json_of(const InstantScore& score) {
  return {{"picture", score.picture},
          {"stem", score.stem},
          {"seconds", score.seconds},
          {"delayed_picture", score.delayed_picture},
          {"age", score.age},
          {"predicted", json_of(score.predicted)},
          {"delayed", json_of(score.delayed)},
          {"rotation", json_of(score.rotation)},
          {"coverage", {{"seen", score.seen}, {"filled", score.filled}, {"never_seen", score.never_seen}}},
          {"over_seen", json_of(score.over_seen)},
          {"beyond_silhouettes", json_of(score.beyond_silhouettes)},
          {"ghosts", json_of(score.ghosts)}};
}

Json json_of(const EvaluationOptions& options) {
  const ReplayOptions& replay = options.replay;
  Json result;
  result["recording"] = replay.recording.string();
  result["scene"] = replay.scene ? Json(replay.scene->string()) : Json(nullptr);
  result["delay"] = replay.delay.seconds();
  result["from"] = replay.from;
  result["to"] = replay.to;
  result["every"] = options.every;
  result["history"] = replay.history ? Json(*replay.history) : Json(nullptr);
  result["artefacts"] = to_string(replay.extraction.artefacts);
  result["passes"] = replay.extraction.passes;
  result["alpha_c"] = replay.extraction.alpha_c;
  result["small_texture"] = replay.extraction.small_texture;
  result["fill"] = to_string(replay.extraction.fill);
  result["exposure"] = auto_or_off(replay.extraction.compensate_exposure);
  result["registration"] = auto_or_off(replay.registration);
  result["near"] = replay.extraction.near_plane;
  result["load_textures"] = replay.load_textures ? Json(replay.load_textures->string()) : Json(nullptr);
  return result;
}

Json json_of(const RecordingDamage& damage) {
  return {{"lines_malformed", damage.lines_malformed},
          {"stamps_out_of_order", damage.stamps_out_of_order},
          {"stamps_duplicated", damage.stamps_duplicated},
          {"poses_not_finite", damage.poses_not_finite},
          {"poses_not_unit", damage.poses_not_unit},
          {"pictures_missing", damage.pictures_missing},
          {"pictures_without_pose", damage.pictures_without_pose},
          {"pictures_unreadable", damage.pictures_unreadable}};
}

double milliseconds_per_picture(const Evaluation& evaluation) {
  if (evaluation.pictures_extracted == 0) return 0;
  return 1e3 * evaluation.extraction_seconds / static_cast<double>(evaluation.pictures_extracted);
}

/// Takes more pixels into a mean over all.
void pool(PixelError& all, const PixelError& more) {
  if (more.pixels == 0) return;
  const double share = static_cast<double>(more.pixels) / static_cast<double>(all.pixels + more.pixels);
  all.mean_squared += share * (more.mean_squared - all.mean_squared);
  all.mean_absolute += share * (more.mean_absolute - all.mean_absolute);
  all.pixels += more.pixels;
}

}  // namespace

EvaluationSummary summarise(const Evaluation& evaluation) {
  EvaluationSummary summary;
  summary.predicted = summarise_view(evaluation, &InstantScore::predicted);
  summary.delayed = summarise_view(evaluation, &InstantScore::delayed);
  summary.rotation = summarise_view(evaluation, &InstantScore::rotation);
  summary.psnr_over_seen = mean_and_worst(evaluation, [](const InstantScore& i) { return i.over_seen.psnr(); });
  const double count = static_cast<double>(evaluation.instants.size());
  for (const InstantScore& instant : evaluation.instants) {
    summary.seen += instant.seen / count;
    summary.filled += instant.filled / count;
    summary.never_seen += instant.never_seen / count;
    summary.age += instant.age / count;
    pool(summary.beyond_silhouettes, instant.beyond_silhouettes);
    pool(summary.ghosts, instant.ghosts);
  }
  return summary;
}

std::string evaluation_table(const Evaluation& evaluation, const EvaluationOptions& options) {
  const EvaluationSummary summary = summarise(evaluation);
  std::string text;
  text += line("%s%s%s, %dx%d, delay %.0f ms%s", evaluation.recording.c_str(), evaluation.camera.empty() ? "" : ", ",
               evaluation.camera.c_str(), evaluation.width, evaluation.height, 1e3 * options.replay.delay.seconds(),
               evaluation.complete ? "" : " (interrupted: only the instants so far)");
  text += line("%zu instants; left out: %zu before any picture arrived, %zu damaged", evaluation.instants.size(),
               evaluation.instants_without_picture, evaluation.instants_damaged);
  if (evaluation.instants.empty()) return text;
  text += "\n";
  text += line("  %-14s %9s %8s  %-14s %7s %8s", "against truth", "PSNR dB", "worst", "at", "SSIM", "worst");
  text += table_row("predicted", summary.predicted);
  text += table_row("delayed", summary.delayed);
  text += table_row("rotation only", summary.rotation);
  text += "\n";
  text += line("  pixels seen %.1f %%, filled %.1f %%, never seen %.1f %%", 100 * summary.seen, 100 * summary.filled,
               100 * summary.never_seen);
  if (summary.psnr_over_seen.instants > 0) {
    text += line("  over seen surface       %6.2f dB, worst %.2f dB at %s", summary.psnr_over_seen.mean,
                 summary.psnr_over_seen.worst, summary.psnr_over_seen.worst_stem.c_str());
  }
  const PixelError& beyond = summary.beyond_silhouettes;
  if (beyond.pixels > 0) {
    text += line("  beyond silhouettes      %6.2f dB, rms %.2f/255, mean %.2f/255, %zu pixels", *beyond.psnr(),
                 beyond.rms(), beyond.mean_absolute, beyond.pixels);
    text += line("    of that, ghosts                 rms %.2f/255, mean %.2f/255", summary.ghosts.rms(),
                 summary.ghosts.mean_absolute);
  } else {
    text += "  beyond silhouettes      no pixels\n";
  }
  text += "\n";
  text += line("  newest picture used is %.0f ms old; %zu extracted in %.1f ms each, %zu damaged", 1e3 * summary.age,
               evaluation.pictures_extracted, milliseconds_per_picture(evaluation), evaluation.pictures_damaged);
  if (evaluation.registration) {
    const RegistrationStatus& status = *evaluation.registration;
    text += line("  registration: landmarks are %.2f pixels off the record%s; found in %zu of %zu pictures",
                 status.error_recorded, status.is_correcting ? ", corrected" : ", which is left as it is",
                 status.registered, status.searched);
  }
  if (evaluation.damage.total() > evaluation.damage.pictures_unreadable) {
    text += line("  %zu items of the recording were damaged and dropped (see the log)", evaluation.damage.total());
  }
  text += line("  %zu polygons, %g texels/m, at most %d; GL: %s", evaluation.polygons, evaluation.texels_per_metre,
               evaluation.max_texels, evaluation.renderer.c_str());
  return text;
}

std::string evaluation_json(const Evaluation& evaluation, const EvaluationOptions& options) {
  const EvaluationSummary summary = summarise(evaluation);
  Json json;
  json["format"] = "foreview-evaluation";
  json["version"] = kEvaluationJsonVersion;
  json["complete"] = evaluation.complete;
  json["recording"] = {{"name", evaluation.recording},    {"camera", evaluation.camera},
                       {"width", evaluation.width},       {"height", evaluation.height},
                       {"polygons", evaluation.polygons}, {"damage", json_of(evaluation.damage)}};
  json["options"] = json_of(options);
  json["options"]["density"] = evaluation.texels_per_metre;
  json["options"]["max_texels"] = evaluation.max_texels;
  json["renderer"] = evaluation.renderer;
  json["summary"] = {
      {"instants", evaluation.instants.size()},
      {"instants_without_picture", evaluation.instants_without_picture},
      {"instants_damaged", evaluation.instants_damaged},
      {"age", summary.age},
      {"predicted", json_of(summary.predicted)},
      {"delayed", json_of(summary.delayed)},
      {"rotation", json_of(summary.rotation)},
      {"coverage", {{"seen", summary.seen}, {"filled", summary.filled}, {"never_seen", summary.never_seen}}},
      {"psnr_over_seen", json_of(summary.psnr_over_seen)},
      {"beyond_silhouettes", json_of(summary.beyond_silhouettes)},
      {"ghosts", json_of(summary.ghosts)},
      {"pictures_extracted", evaluation.pictures_extracted},
      {"pictures_damaged", evaluation.pictures_damaged},
      {"milliseconds_per_picture", milliseconds_per_picture(evaluation)},
      {"registration", to_json(evaluation.registration)}};
  json["instants"] = Json::array();
  for (const InstantScore& instant : evaluation.instants) json["instants"].push_back(json_of(instant));
  // Names come from files and may be any bytes: JSON must be UTF-8 all the same.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace foreview
