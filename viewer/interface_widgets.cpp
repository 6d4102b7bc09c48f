#include "foreview/viewer/interface_widgets.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "foreview/viewer/interface_theme.h"

namespace foreview::widgets {
namespace {

ImVec2 operator+(const ImVec2& a, const ImVec2& b) {
  return {a.x + b.x, a.y + b.y};
}

/// Bars and triangles of a transport icon, within a square of side `size` centred at `centre`.
void draw_icon(ImDrawList& list, Icon icon, const ImVec2& centre, float size, ImU32 colour) {
  const float half = size / 2, bar = size / 5;
  const auto triangle = [&](float from, float to) {
    list.AddTriangleFilled(centre + ImVec2(from, -half), centre + ImVec2(from, half), centre + ImVec2(to, 0), colour);
  };
  const auto column = [&](float from) {
    list.AddRectFilled(centre + ImVec2(from, -half), centre + ImVec2(from + bar, half), colour);
  };
  switch (icon) {
    case Icon::play:
      triangle(-half * 0.8F, half);
      break;
    case Icon::pause:
      column(-half * 0.75F);
      column(half * 0.75F - bar);
      break;
    case Icon::step_forward:
      column(-half * 0.9F);
      triangle(-half * 0.2F, half);
      break;
    case Icon::step_back:
      column(half * 0.9F - bar);
      triangle(half * 0.2F, -half);
      break;
    case Icon::to_start:
      column(-half);
      triangle(half * 0.1F, -half + bar);
      triangle(half, half * 0.1F);
      break;
    case Icon::to_end:
      column(half - bar);
      triangle(-half * 0.1F, half - bar);
      triangle(-half, -half * 0.1F);
      break;
    case Icon::loop: {
      const float radius = half * 0.85F, thickness = std::max(1.5F, size / 9);
      list.PathArcTo(centre, radius, -1.0F, 4.2F, 24);
      list.PathStroke(colour, 0, thickness);
      const ImVec2 tip = centre + ImVec2(radius * std::cos(-1.0F), radius * std::sin(-1.0F));
      list.AddTriangleFilled(tip + ImVec2(-half * 0.5F, -half * 0.35F), tip + ImVec2(half * 0.25F, -half * 0.4F),
                             tip + ImVec2(half * 0.05F, half * 0.45F), colour);
      break;
    }
  }
}

void fact_in(const char* label, const std::string& value, const ImVec4& colour) {
  const float left = ImGui::GetCursorPosX(), room = ImGui::GetContentRegionAvail().x;
  const float width = ImGui::CalcTextSize(value.c_str()).x;
  const float label_end = ImGui::CalcTextSize(label).x + ImGui::GetStyle().ItemInnerSpacing.x;
  ImGui::TextDisabled("%s", label);
  // What does not fit beside its label goes below it, broken where even that is not enough.
  if (label_end + width <= room) ImGui::SameLine();
  ImGui::SetCursorPosX(left + std::max(room - width, 0.0F));
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(value.c_str());
  ImGui::PopTextWrapPos();
  ImGui::PopStyleColor();
}

struct PlotArea {
  ImVec2 from, to;
  [[nodiscard]] float width() const { return to.x - from.x; }
  [[nodiscard]] float height() const { return to.y - from.y; }
};

/// Makes room for a plot over the whole width and gives it its background.
PlotArea begin_plot(const char* id, float em, float height) {
  const ImVec2 from = ImGui::GetCursorScreenPos();
  const float width = std::max(ImGui::GetContentRegionAvail().x, em);
  ImGui::PushID(id);
  ImGui::Dummy({width, height});
  ImGui::PopID();
  const PlotArea area{from, from + ImVec2(width, height)};
  ImGui::GetWindowDrawList()->AddRectFilled(area.from, area.to, interface_colour::kPlotBack,
                                            ImGui::GetStyle().FrameRounding);
  return area;
}

/// After the bars: what the plot's upper edge means, on a ground of its own.
void end_plot(const PlotArea& area, double top, float em) {
  char text[32];
  std::snprintf(text, sizeof text, "%g ms", top);
  const ImVec2 from = area.from + ImVec2(em * 0.2F, em * 0.15F), size = ImGui::CalcTextSize(text);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(from, from + ImVec2(size.x + em * 0.4F, size.y), interface_colour::kPlotBack & 0xD0FFFFFFU, 3);
  list.AddText(from + ImVec2(em * 0.2F, 0), 0xFFD8D4D0U, text);
}

}  // namespace

bool icon_button(const char* id, Icon icon, bool lit, float em, const char* text) {
  const float side = ImGui::GetFrameHeight();
  ImGui::PushStyleColor(ImGuiCol_Button,
                        lit ? ImVec4(0.25F, 0.42F, 0.54F, 1) : ImGui::GetStyleColorVec4(ImGuiCol_FrameBg));
  const ImVec2 from = ImGui::GetCursorScreenPos();
  const bool pressed = ImGui::Button(id, {side * 1.3F, side});
  ImGui::PopStyleColor();
  draw_icon(*ImGui::GetWindowDrawList(), icon, from + ImVec2(side * 0.65F, side * 0.5F), em * 0.72F,
            ImGui::GetColorU32(ImGuiCol_Text));
  tooltip(text);
  return pressed;
}

void label(const char* text, float em, const char* help) {
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(text);
  if (help != nullptr && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", help);
  ImGui::SameLine(em * 6.2F);
  ImGui::SetNextItemWidth(-1);
}

void tooltip(const std::string& text) {
  if (text.empty() || !ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(ImGui::GetFontSize() * 24);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

void fact(const char* name, const std::string& value) {
  fact_in(name, value, ImGui::GetStyleColorVec4(ImGuiCol_Text));
}

void warning_fact(const char* name, const std::string& value) {
  fact_in(name, value, ImGui::ColorConvertU32ToFloat4(interface_colour::kWarning));
}

int choice_row(const char* id, const char* const* names, int count, int chosen, const std::string* tooltips) {
  int pressed = -1;
  ImGui::PushID(id);
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x * 0.5F;
  const float width =
      (ImGui::GetContentRegionAvail().x - gap * static_cast<float>(count - 1)) / static_cast<float>(count);
  for (int i = 0; i < count; ++i) {
    if (i > 0) ImGui::SameLine(0, gap);
    ImGui::PushStyleColor(ImGuiCol_Button,
                          i == chosen ? ImVec4(0.25F, 0.42F, 0.54F, 1) : ImGui::GetStyleColorVec4(ImGuiCol_FrameBg));
    if (ImGui::Button(names[i], {width, 0})) pressed = i;
    ImGui::PopStyleColor();
    if (tooltips != nullptr) tooltip(tooltips[i]);
  }
  ImGui::PopID();
  return pressed;
}

unsigned step_colour(ExtractionStep step) {
  // One hue a step, of even lightness; what belongs together is near.
  constexpr std::array<unsigned, kExtractionSteps> kColours{
      0xFFB0936BU,  // upload
      0xFF8FA860U,  // projection
      0xFF6CB07CU,  // occlusion
      0xFF5FB4A8U,  // suppression
      0xFF5AA9D0U,  // normalisation
      0xFF6C93DCU,  // fusion
      0xFFB883C0U,  // filling
      0xFF9A7AC8U,  // publishing
      0xFF8C8C8CU,  // other
  };
  return kColours[static_cast<std::size_t>(step)];
}

void extraction_plot(const std::deque<ViewerStatus::Picture>& pictures, float em) {
  float most = 1;
  std::array<bool, kExtractionSteps> occurs{};
  for (const ViewerStatus::Picture& picture : pictures) {
    float sum = 0;
    for (std::size_t i = 0; i < kExtractionSteps; ++i) {
      sum += picture.step_ms[i];
      if (picture.step_ms[i] > 0.05F) occurs[i] = true;
    }
    most = std::max(most, sum);
  }
  const double top = plot_top(static_cast<double>(most));
  const PlotArea area = begin_plot("extraction", em, em * 4.5F);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float bar = area.width() / static_cast<float>(ViewerStatus::kPictures);
  for (std::size_t i = 0; i < pictures.size() && i < ViewerStatus::kPictures; ++i) {
    const ViewerStatus::Picture& picture = pictures[pictures.size() - 1 - i];
    const float right = area.to.x - bar * static_cast<float>(i);
    float below = area.to.y;
    for (std::size_t step = 0; step < kExtractionSteps; ++step) {
      const float height = picture.step_ms[step] / static_cast<float>(top) * area.height();
      if (height <= 0) continue;
      list.AddRectFilled({right - bar * 0.85F, below - height}, {right, below},
                         step_colour(static_cast<ExtractionStep>(step)));
      below -= height;
    }
  }
  end_plot(area, top, em);
  // Legend, as many to a line as fit.
  const float end = ImGui::GetCursorPosX() + ImGui::GetContentRegionAvail().x;
  bool first = true;
  for (std::size_t i = 0; i < kExtractionSteps; ++i) {
    if (!occurs[i]) continue;
    const auto step = static_cast<ExtractionStep>(i);
    const float width = ImGui::CalcTextSize(to_string(step)).x + em * 1.2F;
    if (!first) {
      ImGui::SameLine(0, em * 0.5F);
      if (ImGui::GetCursorPosX() + width > end) ImGui::NewLine();
    }
    first = false;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    list.AddRectFilled(at + ImVec2(0, em * 0.3F), at + ImVec2(em * 0.6F, em * 0.9F), step_colour(step), 2);
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + em * 0.85F);
    ImGui::TextDisabled("%s", to_string(step));
  }
}

void frame_plot(const std::deque<ViewerStatus::Frame>& frames, double period_ms, float em) {
  // Twice the period is as much as tells anything: what is longer is as bad.
  const double top = plot_top(std::max(period_ms, 1.0) * 1.6);
  const PlotArea area = begin_plot("frames", em, em * 3);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float bar = area.width() / static_cast<float>(ViewerStatus::kFrames);
  for (std::size_t i = 0; i < frames.size() && i < ViewerStatus::kFrames; ++i) {
    const ViewerStatus::Frame& frame = frames[frames.size() - 1 - i];
    const float right = area.to.x - bar * static_cast<float>(i);
    const float height = std::min(frame.milliseconds / static_cast<float>(top), 1.0F) * area.height();
    list.AddRectFilled({right - bar * 0.85F, area.to.y - height}, {right, area.to.y},
                       frame.late ? interface_colour::kWarning : interface_colour::kAccent);
  }
  const float line = area.to.y - static_cast<float>(period_ms / top) * area.height();
  list.AddLine({area.from.x, line}, {area.to.x, line}, 0x60FFFFFFU);
  end_plot(area, top, em);
}

}  // namespace foreview::widgets
