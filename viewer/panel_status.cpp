#include <imgui.h>

#include "foreview/viewer/formatted.h"
#include "foreview/viewer/interface_widgets.h"
#include "foreview/viewer/panels.h"
#include "foreview/viewer/registration_report.h"

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

/// What is known of live streams alone: how late they are, by whose clock, and what each camera's pictures came to.
void show_live(const LiveReport& live) {
  const LiveSource::Latency& latency = live.latency;
  widgets::fact("Capture to display", live.displayed > 0
                                          ? age_text(live.display_median) + ", 99 % " + age_text(live.display_p99)
                                          : std::string("nothing displayed yet"));
  const bool is_synchronised = latency.clock_mode == ClockMode::synchronised;
  widgets::fact("Robot's clock",
                is_synchronised ? std::string("synchronised") : "estimated, +-" + age_text(latency.clock_uncertainty));
  if (!latency.clock_warning.empty()) widgets::warning_fact("Clock", latency.clock_warning);
  for (const LiveReport::Camera& camera : live.cameras) {
    const PictureCounts& counts = camera.counts;
    widgets::fact((camera.name + ": in / used / overwritten").c_str(),
                  count_text(counts.in) + " / " + count_text(counts.used) + " / " + count_text(counts.overwritten));
    if (counts.damaged + counts.stateless > 0) {
      widgets::warning_fact("  damaged / without a pose",
                            count_text(counts.damaged) + " / " + count_text(counts.stateless));
    }
    if (counts.lost + camera.lost_on_network + counts.duplicated > 0) {
      widgets::fact("  lost / came twice",
                    count_text(counts.lost + camera.lost_on_network) + " / " + count_text(counts.duplicated));
    }
  }
  if (!live.missing.empty()) widgets::warning_fact("Waiting", live.missing);
}

void show_source(const ViewerStatus& status) {
  const SourceStatus& source = status.source;
  widgets::fact("Newest picture", status.newest_picture ? age_text(status.now - *status.newest_picture) + " old"
                                                        : std::string("none yet"));
  widgets::fact("Registration", to_text(status.registration));
  if (status.live) return show_live(*status.live);
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
