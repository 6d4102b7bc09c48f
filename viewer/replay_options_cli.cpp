#include "foreview/viewer/replay_options_cli.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <sstream>

#include "foreview/recordings/builtin.h"
#include "foreview/scene/errors.h"
#include "foreview/viewer/extraction_names.h"

namespace foreview {
namespace {

template <typename Number>
Number parse_number(const std::string& text, const std::string& option, Number least, Number greatest,
                    const char* what) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stop != end || !(number >= least && number <= greatest)) {
    std::ostringstream why;
    why << "'" << text << "' cannot be; expected " << what << " from " << least << " to " << greatest;
    throw InputError(option, why.str());
  }
  return number;
}

/// Each option is read by a function that is given its text: so that our own errors name it, and nothing is silently
/// rounded or cut.
template <typename Function>
CLI::Option* add(CLI::App& command, const std::string& name, const char* type, const std::string& help,
                 Function&& read) {
  return command
      .add_option_function<std::string>(
          name, [name, read](const std::string& text) { read(text, name); }, help)
      ->type_name(type);
}

template <typename Number, typename Target>
void add_number(CLI::App& command, const std::string& name, Target& target, Number least, Number greatest,
                const char* what, const char* type, const std::string& help) {
  add(command, name, type, help, [&target, least, greatest, what](const std::string& text, const std::string& option) {
    target = parse_number<Number>(text, option, least, greatest, what);
  });
}

std::string listed(const std::vector<std::string>& names) {
  std::string result;
  for (const std::string& name : names) result += (result.empty() ? "" : ", ") + name;
  return result;
}

Duration parse_delay(const std::string& text, const std::string& option) {
  const Duration delay = Duration::parse(text, option);
  if (delay < Duration{0} || delay > Duration::from_seconds(3600)) {
    throw InputError(option, "'" + text + "' is out of range; expected a duration from 0 s to 1 h, as in 500ms");
  }
  return delay;
}

}  // namespace

std::size_t parse_count(const std::string& text, const std::string& option) {
  return parse_number<std::size_t>(text, option, 1, 1'000'000, "a whole number");
}

void add_replay_options(CLI::App& command, ReplayOptions& options, bool needs_recording) {
  using Text = const std::string&;
  const auto text_into = [](auto& target) { return [&target](Text text, Text) { target = text; }; };
  add(command, "RECORDING", "", "A recording's directory, or a built-in one: " + listed(builtin_recording_names()),
      text_into(options.recording))
      ->required(needs_recording);

  add(command, "--scene", "FILE",
      "Polygon model to use instead of the recording's own (OBJ, PLY, STL, OFF, glTF, DAE); looked for where you are, "
      "then in the recording",
      text_into(options.scene));
  add(command, "--camera", "NAME",
      "Whose pictures are compared, and whose pose is the operator's (default: the recording's first camera); pictures "
      "of all cameras give textures",
      text_into(options.camera));
  add(command, "--delay", "TIME",
      "How old a picture is when it arrives: textures come only from pictures captured before t - delay (default: "
      "500ms)",
      [&options](Text text, Text option) { options.delay = parse_delay(text, option); });
  add(command, "--from", "POSITION", "Where to begin: seconds from the recording's start, or a picture as #200",
      text_into(options.from));
  add(command, "--to", "POSITION", "Where to end, the same way", text_into(options.to));
  add_number<std::size_t>(command, "--history", options.history, 1, 1'000'000, "a number of pictures", "N",
                          "Use only the last N pictures of each camera before t - delay (default: all from the start)");

  ExtractionOptions& extraction = options.extraction;
  add(command, "--artefacts", "RULE",
      "Artefact suppression: diamond or none; per-polygon also alternating, progressive (default: diamond)",
      [&extraction](Text text, Text option) { extraction.artefacts = parse_artefact_suppression(text, option); });
  add_number<int>(command, "--passes", extraction.passes, 0, 64, "a number of passes", "N",
                  "How often artefact suppression is repeated (default: 3)");
  add(command, "--alpha-c", "A",
      "Threshold of the per-polygon pipeline's diamond rule, from 3 to below 3.875 (default: 3.5)",
      [&extraction](Text text, Text option) {
        extraction.alpha_c = parse_number<double>(text, option, 3, 3.875, "a sum of four alphas");
        if (extraction.alpha_c >= 3.875) {
          throw InputError(option, "from 3.875 on, polygons would be eroded from outside; expected 3 <= A < 3.875");
        }
      });
  add_number<int>(command, "--small-texture", extraction.small_texture, 0, 1'000'000, "a number of pixels", "PIXELS",
                  "Per-polygon pipeline: a polygon narrower than this in the picture is not suppressed (default: 12)");
  add(command, "--fill", "RULE", "Hole filling: pyramid; per-polygon also iterative, none (default: pyramid)",
      [&extraction](Text text, Text option) { extraction.fill = parse_hole_filling(text, option); });
  add_number<double>(command, "--density", options.density, 0.1, 1e6, "texels per metre", "D",
                     "Texels per metre (default: what the recording proposes, else what its pictures resolve)");
  add_number<int>(command, "--max-texels", options.max_texels, 4, 16384, "a number of texels", "R",
                  "Most texels of one polygon along an axis (default: what the recording proposes, else enough for "
                  "the largest polygon, between 256 and 1024)");
  add(command, "--exposure", "RULE",
      "What to do about pictures' changing exposure and white balance: auto (compensate; --pipeline batched only) or "
      "off "
      "(default: auto)",
      [&extraction](Text text, Text option) { extraction.compensate_exposure = parse_auto_or_off(text, option); });
  add_number<double>(command, "--near", extraction.near_plane, 1e-4, 1e3, "metres", "METRES",
                     "Nearest distance that is drawn and extracted (default: 0.02)");

  add(command, "--load-textures", "DIR", "Begin with textures saved earlier", text_into(options.load_textures));
  add(command, "--save-textures", "DIR", "Keep the textures in this directory at the end",
      text_into(options.save_textures));
}

void add_pipeline_options(CLI::App& command, ReplayOptions& options) {
  add(command, "--pipeline", "KIND",
      "How textures are extracted: batched (all polygons at once) or per-polygon (the method of 2005, with all its "
      "variants) (default: batched)",
      [&options](const std::string& text, const std::string& option) {
        options.pipeline = parse_pipeline(text, option);
      });
  command.add_flag("--stats", options.stats,
                   "Print the run's counters at the end: pictures, texels, polygons, memory, passes. Counting observed "
                   "texels costs a read-back per picture");
}

void add_registration_option(CLI::App& command, ReplayOptions& options) {
  add(command, "--registration", "RULE",
      "What to do about poses and a camera that do not quite fit the pictures: auto (correct them by landmarks found "
      "again) or off (default: auto)",
      [&options](const std::string& text, const std::string& option) {
        options.registration = parse_auto_or_off(text, option);
      });
}

}  // namespace foreview
