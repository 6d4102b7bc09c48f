#include "foreview/viewer/command_line.h"

#include <cstdio>

#include "foreview/viewer/extraction_names.h"
#include "foreview/viewer/view_options_cli.h"

namespace foreview {
namespace {

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

}  // namespace

std::string shell_word(const std::string& text) {
  constexpr const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./:,=+%@";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos) return text;
  std::string quoted = "'";
  for (const char character : text) quoted += character == '\'' ? std::string("'\\''") : std::string(1, character);
  return quoted + "'";
}

std::string headless_command(const ReplayOptions& replay, const ViewChoice& choice, std::size_t index) {
  const ReplayOptions usual;
  std::string text = "foreview replay " + shell_word(replay.recording.string());
  const auto add = [&](const char* option, const std::string& value) {
    text += std::string(" ") + option + " " + shell_word(value);
  };
  const auto add_unless_usual = [&](const char* option, const auto& value, const auto& usual_value, auto to_text) {
    if (value != usual_value) add(option, to_text(value));
  };
  const auto named = [](auto value) { return std::string(to_string(value)); };
  if (replay.scene) add("--scene", replay.scene->string());
  if (!replay.camera.empty()) add("--camera", replay.camera);
  add("--delay", number(replay.delay.seconds() * 1e3) + "ms");
  const std::string position = "#" + std::to_string(index);
  add("--from", position);
  add("--to", position);
  if (replay.history) add("--history", std::to_string(*replay.history));
  add_unless_usual("--pipeline", replay.pipeline, usual.pipeline, named);
  const ExtractionOptions &extraction = replay.extraction, &usually = usual.extraction;
  add_unless_usual("--artefacts", extraction.artefacts, usually.artefacts, named);
  add_unless_usual("--passes", extraction.passes, usually.passes, [](int passes) { return std::to_string(passes); });
  add_unless_usual("--alpha-c", extraction.alpha_c, usually.alpha_c, number);
  add_unless_usual("--small-texture", extraction.small_texture, usually.small_texture,
                   [](int pixels) { return std::to_string(pixels); });
  add_unless_usual("--fill", extraction.fill, usually.fill, named);
  add_unless_usual("--near", extraction.near_plane, usually.near_plane, number);
  if (!replay.registration) add("--registration", "off");
  if (!extraction.compensate_exposure) add("--exposure", "off");
  if (replay.density) add("--density", number(*replay.density));
  if (replay.max_texels) add("--max-texels", std::to_string(*replay.max_texels));
  if (replay.load_textures) add("--load-textures", replay.load_textures->string());
  for (const std::string& word : to_view_arguments(choice)) text += " " + shell_word(word);
  return text + " --headless --out .";
}

}  // namespace foreview
