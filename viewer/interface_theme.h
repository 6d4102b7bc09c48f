#pragma once
struct ImFontAtlas;

namespace foreview {

/// Colours and spacing of the panels for a content scale (1: about 96 dots per inch).
void apply_interface_theme(float scale);

/// Puts the interface's font into the atlas, for that scale: DejaVu Sans where it is installed, else what is built
/// into Dear ImGui. Returns the height of its text in pixels.
float load_interface_font(ImFontAtlas& atlas, float scale);

/// Colours that mean something, as 0xAABBGGRR (Dear ImGui's): the same in all panels.
namespace interface_colour {
inline constexpr unsigned kAccent = 0xFFC49A5AU;    // steel blue
inline constexpr unsigned kWarning = 0xFF3C9CE8U;   // amber
inline constexpr unsigned kBad = 0xFF5A5AE0U;       // red
inline constexpr unsigned kGood = 0xFF7CB96AU;      // green
inline constexpr unsigned kFaint = 0xFF9A928CU;     // secondary text
inline constexpr unsigned kPlotBack = 0xFF1E1B19U;  // behind plots
}  // namespace interface_colour

}  // namespace foreview
