#pragma once
#include "foreview/viewer/panel_layout.h"
#include "foreview/viewer/viewer_control.h"
#include "foreview/viewer/viewer_status.h"

namespace foreview {

/// What every panel works on: the state that it shows and changes, and what it tells of.
struct PanelInput {
  ViewerControl& control;
  const ViewerStatus& status;
  float em;  ///< height of text
};

/// All that is to be seen in this frame, between Interface::begin() and end(): timeline, side panel, help, and the line
/// that says what was done last.
void show_panels(const PanelInput& input, const PanelLayout& layout);

// Each of them alone.
void show_timeline(const PanelInput& input);
void show_view_panel(const PanelInput& input);
void show_link_panel(const PanelInput& input);
void show_extraction_panel(const PanelInput& input);
void show_status_panel(const PanelInput& input);
void show_polygon_panel(const PanelInput& input);
void show_help(const PanelInput& input, const PanelLayout& layout);

}  // namespace foreview
