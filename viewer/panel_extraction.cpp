#include <imgui.h>

#include <array>

#include "foreview/viewer/extraction_names.h"
#include "foreview/viewer/interface_widgets.h"
#include "foreview/viewer/panels.h"

namespace foreview {
namespace {

template <class Choice, std::size_t count>
void combo(const char* name, const char* id, Choice& chosen, const std::array<Choice, count>& choices,
           std::size_t offered, float em, const char* tip) {
  widgets::label(name, em);
  if (ImGui::BeginCombo(id, to_string(chosen))) {
    for (std::size_t i = 0; i < offered; ++i) {
      const bool is_chosen = choices[i] == chosen;
      if (ImGui::Selectable(to_string(choices[i]), is_chosen)) chosen = choices[i];
      if (is_chosen) ImGui::SetItemDefaultFocus();
    }
    ImGui::EndCombo();
  }
  widgets::tooltip(tip);
}

}  // namespace

void show_extraction_panel(const PanelInput& input) {
  ViewerControl::Settings& settings = input.control.settings();
  ExtractionOptions& options = settings.extraction;
  const bool batched = settings.pipeline == PipelineKind::batched;

  // Variants that only the one of 2005 has come last, and are offered with it alone.
  constexpr std::array kArtefacts{ArtefactSuppression::none, ArtefactSuppression::diamond,
                                  ArtefactSuppression::alternating, ArtefactSuppression::progressive};
  constexpr std::array kFillings{HoleFilling::pyramid, HoleFilling::iterative, HoleFilling::none};
  // Not to be changed here: the textures' atlas is laid out for one of the two. --pipeline chooses.
  widgets::fact("Pipeline", to_string(settings.pipeline));
  combo("Artefacts", "##artefacts", options.artefacts, kArtefacts, batched ? 2 : 4, input.em,
        "How colours along occluders' contours are kept off what is behind them");
  widgets::label("Passes", input.em);
  ImGui::SliderInt("##passes", &options.passes, 0, 12, "%d", ImGuiSliderFlags_AlwaysClamp);
  widgets::tooltip("How far from a contour colours are discarded, in pixels of the picture");
  if (!batched) {
    auto alpha = static_cast<float>(options.alpha_c);
    widgets::label("Alpha c", input.em);
    if (ImGui::SliderFloat("##alpha", &alpha, 3, 3.87F, "%.2f", ImGuiSliderFlags_AlwaysClamp)) {
      options.alpha_c = static_cast<double>(alpha);
    }
    widgets::tooltip("Threshold of the diamond rule");
    widgets::label("Small", input.em);
    ImGui::SliderInt("##small", &options.small_texture, 0, 64, "%d pixels", ImGuiSliderFlags_AlwaysClamp);
    widgets::tooltip("Polygons narrower than this in the picture are left alone");
    combo("Filling", "##fill", options.fill, kFillings, 3, input.em, "How holes are filled");
  }
  auto near_plane = static_cast<float>(options.near_plane * 100);
  widgets::label("Near plane", input.em);
  if (ImGui::SliderFloat("##near", &near_plane, 0.1F, 100, "%.1f cm",
                         ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_Logarithmic)) {
    options.near_plane = static_cast<double>(near_plane) / 100;
  }
  widgets::tooltip("Nearest distance that is drawn and extracted");
  if (batched) {
    widgets::label("Exposure", input.em);
    ImGui::Checkbox("compensate##exposure", &options.compensate_exposure);
    widgets::tooltip("Brings pictures of changing exposure and white balance together");
  }
  ImGui::PushTextWrapPos(0);
  ImGui::TextDisabled("Changes hold from the next picture on; what the textures have stays.");
  ImGui::PopTextWrapPos();
}

}  // namespace foreview
