#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace foreview {

/// What a key of the viewer does. What each means: key_rows().
enum class ViewerAction {
  // what is shown
  next_view,
  view_predicted,
  view_delayed,
  view_side_by_side,
  view_split,
  view_difference,
  split_left,
  split_right,
  // from where
  next_camera,
  reset_camera,
  // overlays
  toggle_holes,
  toggle_never_seen,
  toggle_age,
  toggle_density,
  toggle_wireframe,
  toggle_edges,
  toggle_cone,
  toggle_probe,
  // time
  pause,
  step_back,
  step_forward,
  to_start,
  to_end,
  slower,
  faster,
  toggle_loop,
  // link
  less_delay,
  more_delay,
  // the rest
  save_picture,
  copy_command,
  toggle_panels,
  enter_panels,
  toggle_help,
  toggle_full_screen,
  quit,
};

/// A key with its modifiers. Printable keys are the lower-case character on them, whatever the keyboard's layout.
struct KeyChord {
  enum Special : int {
    tab = 256,
    space,
    escape,
    enter,
    left,
    right,
    up,
    down,
    home,
    end,
    page_up,
    page_down,
    f1 = 300
  };
  int key = 0;  ///< a character, a Special, or f1 + n for the function key n + 1
  bool shift = false;
  bool control = false;
  bool operator==(const KeyChord&) const = default;
};
/// "Shift+Left", "Ctrl+C", "F1", "H".
[[nodiscard]] std::string to_string(const KeyChord& chord);

/// A key held down to move the operator's own camera.
enum class MoveKey : std::uint8_t {
  turn_left,
  turn_right,
  turn_up,
  turn_down,
  forward,
  backward,
  left,
  right,
  up,
  down,
};
inline constexpr std::size_t kMoveKeys = 10;

/// A line of the table that the help overlay, `--help` and docs/viewer.md show.
struct KeyRow {
  const char* group = "";  ///< headline, the same for rows in sequence
  std::string keys;        ///< "Left, Right"
  const char* effect = "";
};
[[nodiscard]] const std::vector<KeyRow>& key_rows();

/// What the key does, if anything. `repeated`: it is being held down; most keys do nothing then.
[[nodiscard]] std::optional<ViewerAction> action_of(const KeyChord& chord, bool repeated = false);
/// Which way a held key moves the operator's own camera, if any.
[[nodiscard]] std::optional<MoveKey> move_of(const KeyChord& chord);
/// All keys of an action, the one that is named first.
[[nodiscard]] std::vector<KeyChord> chords_of(ViewerAction action);
/// "H", "Esc, Q": for tooltips.
[[nodiscard]] std::string keys_of(ViewerAction action);

/// The table as plain text of at most 110 columns, for `--help` and the terminal.
[[nodiscard]] std::string key_table_text();
/// The same as Markdown, for docs/viewer.md.
[[nodiscard]] std::string key_table_markdown();

}  // namespace foreview
