#pragma once
#include <array>
#include <deque>
#include <string>

#include "foreview/viewer/viewer_status.h"

namespace foreview {

/// Building blocks of the panels, over Dear ImGui; sizes in its units, `em` is the height of text.
namespace widgets {

enum class Icon { to_start, step_back, play, pause, step_forward, to_end, loop };
/// A flat button with a drawn icon; `tooltip` for mouse and keyboard. Returns whether it was pressed.
bool icon_button(const char* id, Icon icon, bool lit, float em, const char* tooltip);

/// A line with a label at the left; the next widget fills the rest of the line.
void label(const char* text, float em, const char* tooltip = nullptr);
/// Shown when the last widget is hovered, or has the keyboard.
void tooltip(const std::string& text);
/// A fact: faint label, value at the right edge.
void fact(const char* label, const std::string& value);
/// The same in a warning's colour.
void warning_fact(const char* label, const std::string& value);
/// One of several choices, as a row of buttons that fills the line; -1 if none was pressed.
int choice_row(const char* id, const char* const* names, int count, int chosen, const std::string* tooltips);

/// Name and colour of a step of the extraction in plots.
[[nodiscard]] unsigned step_colour(ExtractionStep step);

/// Milliseconds per picture, one bar each, newest at the right, its steps stacked; with an axis and a legend of the
/// steps that are in it.
void extraction_plot(const std::deque<ViewerStatus::Picture>& pictures, float em);
/// Time between frames, with a line at the period.
void frame_plot(const std::deque<ViewerStatus::Frame>& frames, double period_ms, float em);

}  // namespace widgets
}  // namespace foreview
