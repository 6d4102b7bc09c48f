#include <imgui.h>

#include "foreview/viewer/formatted.h"
#include "foreview/viewer/interface_widgets.h"
#include "foreview/viewer/panels.h"

namespace foreview {
namespace {

void show_display(const ViewerStatus& status, float em) {
  widgets::fact("Display", formatted("%.1f of %.0f Hz", status.rate_reached, status.rate_wanted));
  widgets::frame_plot(status.last_frames, status.rate_wanted > 0 ? 1e3 / status.rate_wanted : 0, em);
  const std::string frames = count_text(status.frames);
  const std::string late = count_text(status.frames_late);
  const std::string left_out = count_text(status.frames_skipped + status.frames_missed);
  widgets::fact("Frames / late / left out", frames + " / " + late + " / " + left_out);
  ImGui::Spacing();
}

void show_extraction(const ViewerStatus& status, float em) {
  const auto total = [&] {
    float sum = 0;
    for (const float ms : status.last_pictures.back().step_ms) sum += ms;
    return sum;
  };
  widgets::fact("Extraction",
                status.last_pictures.empty()
                    ? std::string("no picture yet")
                    : formatted("%.0f ms, %.1f pictures/s", static_cast<double>(total()), status.pictures_per_second));
  widgets::extraction_plot(status.last_pictures, em);
  ImGui::Spacing();
}

void show_source(const ViewerStatus& status) {
  const SourceStatus& source = status.source;
  widgets::fact("Newest picture", status.newest_picture ? age_text(status.now - *status.newest_picture) + " old"
                                                        : std::string("none yet"));
  widgets::fact("Pictures in / used / overwritten", count_text(source.pictures_in) + " / " + count_text(source.used) +
                                                        " / " + count_text(source.overwritten));
  if (source.lost > 0) widgets::fact("Lost on the way", count_text(source.lost));
  if (source.damaged + source.stateless > 0) {
    widgets::warning_fact("Damaged / without a pose",
                          count_text(source.damaged) + " / " + count_text(source.stateless));
  }
  if (!source.error.empty()) widgets::warning_fact("Source", source.error);
}

}  // namespace

void show_status_panel(const PanelInput& input) {
  const ViewerStatus& status = input.status;
  show_display(status, input.em);
  show_extraction(status, input.em);
  show_source(status);
  widgets::fact("Memory: textures / all", bytes_text(status.texture_bytes) + " / " + bytes_text(status.process_bytes));
  ImGui::PushTextWrapPos(0);
  ImGui::TextDisabled("%s", status.renderer.c_str());
  ImGui::PopTextWrapPos();
}

}  // namespace foreview
