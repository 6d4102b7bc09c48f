#include <imgui.h>

#include "foreview/viewer/formatted.h"
#include "foreview/viewer/interface_widgets.h"
#include "foreview/viewer/panels.h"

namespace foreview {
void show_polygon_panel(const PanelInput& input) {
  const ViewerStatus& status = input.status;
  if (!status.polygon_found || !status.polygon) {
    ImGui::TextDisabled("point at the predicted view");
    return;
  }
  const PolygonReport& report = *status.polygon;
  widgets::fact("Polygon", count_text(report.polygon) + (report.part.empty() ? "" : " of " + report.part));
  widgets::fact("Corners, area", formatted("%zu, %.4g m2", report.corners, report.area));
  widgets::fact("Distance", formatted("%.3f m", status.polygon_distance));
  widgets::fact("Chart", formatted("page %u at %d, %d", report.page, report.origin.x, report.origin.y));
  widgets::fact("Chart's size", formatted("%d x %d, %u polygons", report.size.x, report.size.y, report.group_polygons));
  widgets::fact("Texels, observed", formatted("%zu, %.0f %%", report.texels, report.observed_share * 100));
  widgets::fact("Colour here", status.texel_captured ? age_text(status.now - *status.texel_captured) + " old"
                                                     : std::string("never seen"));
  for (const PolygonReport::Capture& capture : report.captures) {
    widgets::fact("  captured",
                  formatted("%s ago, %.0f %%", age_text(status.now - capture.stamp).c_str(), capture.share * 100));
  }
}

}  // namespace foreview
