#include "foreview/viewer/replay_input.h"

#include <epoxy/gl.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "foreview/recordings/builtin.h"
#include "foreview/scene/errors.h"
#include "foreview/viewer/gl_debug.h"
#include "foreview/viewer/interrupt.h"
#include "foreview/viewer/progress.h"
#include "foreview/viewer/texture_proposal.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;

fs::path find_scene(const ReplayOptions& options, const Recording& recording) {
  std::error_code error;
  if (options.scene) {
    if (fs::is_regular_file(*options.scene, error)) return *options.scene;
    const fs::path beside = recording.directory() / *options.scene;
    if (fs::is_regular_file(beside, error)) return beside;
    throw InputError("--scene", "no such file: " + options.scene->string() + " (nor in " +
                                    recording.directory().string() + "); expected a polygon model");
  }
  const auto own = recording.scene_file();
  if (!own) {
    throw InputError(recording.directory().string(),
                     "the recording has no scene model; expected scene.ply, scene.obj or the like, or --scene FILE");
  }
  if (!fs::is_regular_file(*own, error)) {
    throw InputError(own->string(), "no such file, though the recording names it as its scene model; see --scene");
  }
  return *own;
}

ChartOptions chart_options(const ReplayOptions& options, const TextureProposal& proposal, const char* origin) {
  ChartOptions charts;
  charts.texels_per_metre = options.density.value_or(proposal.texels_per_metre);
  charts.max_texels = options.max_texels.value_or(proposal.max_texels);
  spdlog::info("textures: {:g} texels/m ({}), at most {} texels along an axis", charts.texels_per_metre,
               options.density ? "--density" : origin, charts.max_texels);
  GLint limit = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
  charts.page_size = std::min(charts.page_size, static_cast<int>(limit));
  charts.group_polygons = options.pipeline == PipelineKind::batched;
  return charts;
}

ChartOptions chart_options_for(const ReplayOptions& options, const Recording& recording, const PolygonModel& model) {
  const auto density = recording.proposed_density();
  const auto max_texels = recording.proposed_max_texels();
  TextureProposal proposal;
  if ((!options.density && !density) || (!options.max_texels && !max_texels)) {
    proposal = propose_textures(recording, model);
  }
  proposal.texels_per_metre = density.value_or(proposal.texels_per_metre);
  proposal.max_texels = max_texels.value_or(proposal.max_texels);
  return chart_options(options, proposal, density ? "the recording's proposal" : "what the pictures resolve");
}

}  // namespace

PolygonModel import_scene(const fs::path& file, const ImportOptions& options) {
  ImportReport report;
  PolygonModel model = import_model(file, options, &report);
  spdlog::info("{}: {} polygons, {} of them backdrop, in {} part(s)", file.string(), model.polygons().size(),
               report.backdrop_polygons, model.parts().size());
  const std::size_t dropped = report.faces_with_bad_index + report.faces_not_finite + report.faces_degenerate +
                              report.faces_duplicate + report.faces_too_complex;
  if (dropped > 0) {
    spdlog::warn("{}: {} of {} faces are unusable and were dropped; foreview inspect tells why", file.string(), dropped,
                 report.faces_in);
  }
  for (const std::string& warning : report.warnings) spdlog::debug("{}: {}", file.string(), warning);
  return model;
}

ChartOptions chart_options_for(const ReplayOptions& options, const PolygonModel& model) {
  return chart_options(options, propose_textures(model), "for a camera as far away as the model is large");
}

/// A directory wins over a built-in recording of the same name: it is what someone who generated one there means.
Recording open_recording(const fs::path& place) {
  std::error_code error;
  const std::vector<std::string> names = builtin_recording_names();
  const bool is_builtin = std::find(names.begin(), names.end(), place.string()) != names.end();
  if (!is_builtin && !fs::exists(place, error)) {
    std::string listed;
    for (const std::string& name : names) listed += (listed.empty() ? "" : ", ") + name;
    throw InputError(place.string(), "no such directory, nor a built-in recording (" + listed + ")");
  }
  if (!is_builtin || fs::is_directory(place, error)) return Recording::open(place);
  GenerateOptions generate;
  generate.name = place.string();
  std::unique_ptr<ProgressBar> bar;
  const fs::path directory = cached_recording(generate, [&](std::size_t done, std::size_t todo) {
    throw_if_interrupted();
    if (!bar) bar = std::make_unique<ProgressBar>("generating " + generate.name, todo);
    bar->update(done);
  });
  return Recording::open(directory);
}

ReplayInput::ReplayInput(const ReplayOptions& from)
    : options(from),
      recording((from.extraction.validate(), open_recording(from.recording))),
      camera(recording.camera_index(from.camera)),
      model(import_scene(find_scene(from, recording), recording.import_options())),
      charts(chart_options_for(from, recording, model)) {}

ReplaySpan find_span(const ReplayInput& input) {
  const Recording& recording = input.recording;
  const std::size_t camera = input.camera;
  const std::string &from_text = input.options.from, &to_text = input.options.to;
  const auto known = [&](Timestamp t) { return recording.predicted_state(camera, t, input.model).has_value(); };
  const Timestamp from =
      from_text.empty() ? recording.first_stamp(camera) : recording.parse_position(from_text, "--from", camera);
  const Timestamp to =
      to_text.empty() ? recording.last_stamp(camera) : recording.parse_position(to_text, "--to", camera);
  if (to < from) throw InputError("--to", "lies before --from; expected the same position or a later one");
  ReplaySpan span;
  bool any = false;
  for (const Recording::PictureEntry& picture : recording.cameras()[camera].pictures) {
    if (picture.stamp < from || picture.stamp > to || !known(picture.stamp)) continue;
    if (!any) span.first = picture.stamp;
    span.last = picture.stamp;
    any = true;
  }
  if (!any) {
    throw InputError(recording.directory().string(),
                     "no usable picture from " + (from_text.empty() ? "its start" : from_text) + " to " +
                         (to_text.empty() ? "its end" : to_text) +
                         "; expected at least one with the poses of the camera and all parts");
  }
  // A display time between pictures is as good, so long as its state is known.
  if (from > recording.first_stamp(camera) && known(from)) span.first = from;
  if (to < recording.last_stamp(camera) && known(to)) span.last = to;
  return span;
}

LiveScene::Options live_scene_options(const ReplayOptions& options, const ChartOptions& charts,
                                      const std::optional<std::filesystem::path>& initial_textures) {
  LiveScene::Options result;
  result.pipeline = options.pipeline;
  result.extraction = options.extraction;
  result.charts = charts;
  result.initial_textures = options.load_textures ? options.load_textures : initial_textures;
  result.initial_textures_must_fit = options.load_textures.has_value();
  result.debug = gl_debug_from_environment() != GlDebug::off;
  return result;
}

}  // namespace foreview
