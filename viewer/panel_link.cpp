#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "foreview/viewer/interface_widgets.h"
#include "foreview/viewer/panels.h"

namespace foreview {
namespace {

constexpr float kMostJitter = 1000, kMostLoss = 90;            // ms, percent
constexpr double kLeastBandwidth = 1e4, kMostBandwidth = 1e9;  // bit/s; at the slider's end there is no limit

bool slider(const char* name, const char* id, float* value, float most, const char* format, float em,
            const std::string& tip) {
  widgets::label(name, em);
  const bool changed = ImGui::SliderFloat(id, value, 0, most, format, ImGuiSliderFlags_AlwaysClamp);
  widgets::tooltip(tip);
  return changed;
}

}  // namespace

void show_link_panel(const PanelInput& input) {
  LinkOptions& link = input.control.settings().link;
  if (input.status.live) ImGui::TextDisabled("simulated, on top of the real link");
  auto delay = static_cast<float>(link.delay.seconds() * 1e3);
  if (slider("Delay", "##delay", &delay, static_cast<float>(ViewerControl::kMostDelay * 1e3), "%.0f ms", input.em,
             "How long every picture is under way (" + keys_of(ViewerAction::less_delay) + ", " +
                 keys_of(ViewerAction::more_delay) + ": 100 ms)")) {
    link.delay = Duration::from_seconds(std::round(static_cast<double>(delay) / 10) / 100);
  }
  auto jitter = static_cast<float>(link.jitter.seconds() * 1e3);
  if (slider("Jitter", "##jitter", &jitter, kMostJitter, "%.0f ms", input.em,
             "Standard deviation of the delay: pictures overtake each other")) {
    link.jitter = Duration::from_seconds(std::round(static_cast<double>(jitter)) / 1e3);
  }
  auto loss = static_cast<float>(link.loss * 100);
  if (slider("Loss", "##loss", &loss, kMostLoss, "%.0f %%", input.em, "How many of the pictures never arrive")) {
    link.loss = std::round(static_cast<double>(loss)) / 100;
  }
  // Logarithmic, from 10 kbit/s to no limit.
  const double decades = std::log10(kMostBandwidth / kLeastBandwidth);
  auto position = static_cast<float>(link.bandwidth > 0 ? std::log10(link.bandwidth / kLeastBandwidth) / decades : 1);
  if (slider(
          "Bandwidth", "##bandwidth", &position, 1, bandwidth_text(link.bandwidth).c_str(), input.em,
          "What the link carries; pictures wait for those before them, and are lost when they would wait too long")) {
    const double bandwidth = kLeastBandwidth * std::pow(10, static_cast<double>(position) * decades);
    // Two digits are as fine as anyone sets it.
    const double unit = std::pow(10, std::floor(std::log10(bandwidth)) - 1);
    link.bandwidth = position >= 1 ? 0 : std::round(bandwidth / unit) * unit;
  }
}

}  // namespace foreview
