#pragma once

namespace foreview {

/// Where panels and view lie in the window, in the interface's units, (0, 0) its upper left corner.
struct PanelLayout {
  struct Area {
    float x = 0, y = 0, width = 0, height = 0;
  };
  bool panels = false;  ///< shown at all
  Area view;
  Area side;      ///< at the right, over the whole height
  Area timeline;  ///< below the view
};

/// `wanted`: the user wants panels. They are left out where the window has no room for them beside a picture that is
/// still of use. `em` is the height of text.
[[nodiscard]] PanelLayout lay_out_panels(float width, float height, float em, bool wanted);

/// The panels' own width and height, for the window that shows a picture in its own size beside them.
[[nodiscard]] float side_panel_width(float em);
[[nodiscard]] float timeline_height(float em);

}  // namespace foreview
