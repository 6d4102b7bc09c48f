#include "foreview/viewer/panel_layout.h"

#include <algorithm>
#include <cmath>

namespace foreview {
namespace {

// In heights of text. Less than this for the picture, and panels would hide what they are for.
constexpr float kLeastViewWidth = 24, kLeastViewHeight = 15;

}  // namespace

float side_panel_width(float em) {
  return std::round(em * 21.5F);
}

float timeline_height(float em) {
  return std::round(em * 2.7F);
}

PanelLayout lay_out_panels(float width, float height, float em, bool wanted) {
  PanelLayout layout;
  width = std::max(width, 0.0F);
  height = std::max(height, 0.0F);
  const float side = side_panel_width(em), below = timeline_height(em);
  layout.panels = wanted && width >= side + em * kLeastViewWidth && height >= below + em * kLeastViewHeight;
  if (!layout.panels) {
    layout.view = {0, 0, width, height};
    return layout;
  }
  layout.view = {0, 0, width - side, height - below};
  layout.side = {width - side, 0, side, height};
  layout.timeline = {0, height - below, width - side, below};
  return layout;
}

}  // namespace foreview
