#include "foreview/viewer/key_map.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <utility>

namespace foreview {
namespace {

using A = ViewerAction;

/// One or more keys and what they do; several actions share a line of the table where they belong together.
struct Binding {
  ViewerAction action;
  std::array<KeyChord, 3> chords{};  ///< unused ones: key 0
  bool repeats = false;
};

struct Line {
  const char* group;
  const char* effect;
  std::vector<Binding> bindings;
  const char* other = "";  ///< keys or mouse movements that are no bindings, as text
};

KeyChord plain(int key) {
  return {key, false, false};
}
KeyChord shifted(int key) {
  return {key, true, false};
}
KeyChord with_control(int key) {
  return {key, false, true};
}

const std::vector<Line>& lines() {
  static const std::vector<Line> kLines{
      {"View",
       "next view: predicted, delayed, side by side, split, difference",
       {{A::next_view, {plain(KeyChord::tab)}}}},
      {"View",
       "one of the five views",
       {{A::view_predicted, {plain('1')}},
        {A::view_delayed, {plain('2')}},
        {A::view_side_by_side, {plain('3')}},
        {A::view_split, {plain('4')}},
        {A::view_difference, {plain('5')}}}},
      {"View",
       "move the split line (or drag it)",
       {{A::split_left, {plain(',')}, true}, {A::split_right, {plain('.')}, true}}},
      {"Camera", "next camera: follow the recording, look around, free, overview", {{A::next_camera, {plain('c')}}}},
      {"Camera", "camera back to the recorded pose", {{A::reset_camera, {plain('r')}}}},
      {"Camera", "turn", {}, "Left drag / Shift+arrows"},
      {"Camera", "move (free camera and overview)", {}, "Right drag / Ctrl+arrows / Page Up, Down"},
      {"Camera", "nearer, farther", {}, "Wheel"},
      {"Overlays", "holes in pink: what no picture has shown and was filled", {{A::toggle_holes, {plain('h')}}}},
      {"Overlays", "polygons that no picture has shown", {{A::toggle_never_seen, {plain('n')}}}},
      {"Overlays", "age of the textures", {{A::toggle_age, {plain('a')}}}},
      {"Overlays", "texels per pixel", {{A::toggle_density, {plain('d')}}}},
      {"Overlays", "wireframe over the predicted view", {{A::toggle_wireframe, {plain('w')}}}},
      {"Overlays", "the model's edges over the delayed picture", {{A::toggle_edges, {plain('m')}}}},
      {"Overlays", "the real camera's field of view", {{A::toggle_cone, {plain('f')}}}},
      {"Overlays", "the polygon under the cursor", {{A::toggle_probe, {plain('i')}}}},
      {"Time", "pause, go on; at the end: from the start", {{A::pause, {plain(KeyChord::space)}}}},
      {"Time",
       "to the picture before, after",
       {{A::step_back, {plain(KeyChord::left)}, true}, {A::step_forward, {plain(KeyChord::right)}, true}}},
      {"Time",
       "to the start, to the end",
       {{A::to_start, {plain(KeyChord::home)}}, {A::to_end, {plain(KeyChord::end)}}}},
      {"Time",
       "slower, faster",
       {{A::slower, {plain('-')}, true}, {A::faster, {plain('='), shifted('='), plain('+')}, true}}},
      {"Time", "begin anew at the end", {{A::toggle_loop, {plain('l')}}}},
      {"Link", "delay 100 ms less, more", {{A::less_delay, {plain('[')}, true}, {A::more_delay, {plain(']')}, true}}},
      {"Program", "save what is shown as PNG", {{A::save_picture, {plain('s')}}}},
      {"Program",
       "copy the command line that shows the same without a window",
       {{A::copy_command, {with_control('c')}}}},
      {"Program", "hide or show the panels", {{A::toggle_panels, {plain('p')}}}},
      {"Program",
       "the keyboard into the panels, again: into the next; Esc: out",
       {{A::enter_panels, {plain(KeyChord::f1 + 1), plain(KeyChord::enter)}}}},
      {"Program", "this table", {{A::toggle_help, {plain(KeyChord::f1), shifted('/'), plain('?')}}}},
      {"Program", "full screen", {{A::toggle_full_screen, {plain(KeyChord::f1 + 10)}}}},
      {"Program", "quit", {{A::quit, {plain(KeyChord::escape), plain('q')}}}},
  };
  return kLines;
}

struct Held {
  KeyChord chord;
  MoveKey move;
};
constexpr std::array kHeld{
    Held{{KeyChord::left, true, false}, MoveKey::turn_left}, Held{{KeyChord::right, true, false}, MoveKey::turn_right},
    Held{{KeyChord::up, true, false}, MoveKey::turn_up},     Held{{KeyChord::down, true, false}, MoveKey::turn_down},
    Held{{KeyChord::up, false, true}, MoveKey::forward},     Held{{KeyChord::down, false, true}, MoveKey::backward},
    Held{{KeyChord::left, false, true}, MoveKey::left},      Held{{KeyChord::right, false, true}, MoveKey::right},
    Held{{KeyChord::page_up, false, false}, MoveKey::up},    Held{{KeyChord::page_down, false, false}, MoveKey::down},
};

std::string key_name(int key) {
  switch (key) {
    case KeyChord::tab:
      return "Tab";
    case KeyChord::space:
      return "Space";
    case KeyChord::escape:
      return "Esc";
    case KeyChord::enter:
      return "Enter";
    case KeyChord::left:
      return "Left";
    case KeyChord::right:
      return "Right";
    case KeyChord::up:
      return "Up";
    case KeyChord::down:
      return "Down";
    case KeyChord::home:
      return "Home";
    case KeyChord::end:
      return "End";
    case KeyChord::page_up:
      return "Page Up";
    case KeyChord::page_down:
      return "Page Down";
    default:
      break;
  }
  if (key >= KeyChord::f1) return "F" + std::to_string(key - KeyChord::f1 + 1);
  // Between other text these would pass for punctuation.
  constexpr std::array kPunctuation{std::pair{',', "Comma"}, std::pair{'.', "Period"}, std::pair{'-', "Minus"},
                                    std::pair{'=', "Equals"}};
  for (const auto& [character, name] : kPunctuation) {
    if (key == character) return name;
  }
  const char character = static_cast<char>(key);
  return {character >= 'a' && character <= 'z' ? static_cast<char>(character - 'a' + 'A') : character};
}

/// Chords that only stand in for another keyboard's layout are not named.
bool named(const Binding& binding, std::size_t chord) {
  return binding.chords[chord].key != 0 &&
         (chord == 0 || binding.action == A::quit || binding.action == A::enter_panels);
}

std::string names(const Binding& binding) {
  std::string text;
  for (std::size_t i = 0; i < binding.chords.size(); ++i) {
    if (named(binding, i)) text += (text.empty() ? "" : " / ") + to_string(binding.chords[i]);
  }
  return text;
}

std::vector<KeyRow> make_rows() {
  std::vector<KeyRow> rows;
  for (const Line& line : lines()) {
    std::string keys = line.other;
    for (const Binding& binding : line.bindings) keys += (keys.empty() ? "" : " / ") + names(binding);
    rows.push_back({line.group, keys, line.effect});
  }
  return rows;
}

}  // namespace

std::string to_string(const KeyChord& chord) {
  return std::string(chord.control ? "Ctrl+" : "") + (chord.shift ? "Shift+" : "") + key_name(chord.key);
}

const std::vector<KeyRow>& key_rows() {
  static const std::vector<KeyRow> kRows = make_rows();
  return kRows;
}

std::optional<ViewerAction> action_of(const KeyChord& chord, bool repeated) {
  for (const Line& line : lines()) {
    for (const Binding& binding : line.bindings) {
      if (chord.key == 0 || std::find(binding.chords.begin(), binding.chords.end(), chord) == binding.chords.end())
        continue;
      if (repeated && !binding.repeats) return std::nullopt;
      return binding.action;
    }
  }
  return std::nullopt;
}

std::optional<MoveKey> move_of(const KeyChord& chord) {
  const auto* const held =
      std::find_if(kHeld.begin(), kHeld.end(), [&](const Held& one) { return one.chord == chord; });
  if (held == kHeld.end()) return std::nullopt;
  return held->move;
}

std::string keys_of(ViewerAction action) {
  for (const Line& line : lines()) {
    for (const Binding& binding : line.bindings) {
      if (binding.action == action) return names(binding);
    }
  }
  return {};
}

std::vector<KeyChord> chords_of(ViewerAction action) {
  std::vector<KeyChord> chords;
  for (const Line& line : lines()) {
    for (const Binding& binding : line.bindings) {
      if (binding.action != action) continue;
      std::copy_if(binding.chords.begin(), binding.chords.end(), std::back_inserter(chords),
                   [](const KeyChord& chord) { return chord.key != 0; });
    }
  }
  return chords;
}

std::string key_table_text() {
  std::size_t widest = 0;
  for (const KeyRow& row : key_rows()) widest = std::max(widest, row.keys.size());
  std::string text = "Keys of the window:\n";
  for (const KeyRow& row : key_rows()) {
    text += "  " + row.keys + std::string(widest - row.keys.size() + 2, ' ') + row.effect + "\n";
  }
  return text;
}

std::string key_table_markdown() {
  std::string text;
  const char* group = "";
  for (const KeyRow& row : key_rows()) {
    if (std::strcmp(row.group, group) != 0) {
      text += std::string(text.empty() ? "" : "\n") + "| " + row.group + " | |\n|---|---|\n";
      group = row.group;
    }
    text += "| " + row.keys + " | " + row.effect + " |\n";
  }
  return text;
}

}  // namespace foreview
