#pragma once
#include <string_view>

#include "foreview/viewer/frame_painter.h"
#include "foreview/viewer/staleness.h"

namespace foreview {

/// A rectangle of the frame, pixels, y down.
struct FrameArea {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Where the frame is stale, a border all around and a band with text and age across its top.
void paint_staleness(FramePainter& painter, const FrameArea& frame, const Staleness& staleness);
/// The line between two halves of a view.
void paint_split(FramePainter& painter, const FrameArea& frame, int line);
/// Scales of the heat maps in the lower left of a view, one above the other.
void paint_age_scale(FramePainter& painter, const FrameArea& view, double span_seconds, int place);
void paint_density_scale(FramePainter& painter, const FrameArea& view, int place);
/// A few words at the lower right of a view.
void paint_note(FramePainter& painter, const FrameArea& view, std::string_view text);

}  // namespace foreview
