#include "foreview/viewer/interface_theme.h"

#include <imgui.h>

#include <array>
#include <cmath>
#include <filesystem>

namespace foreview {
namespace {

constexpr float kTextHeight = 15;  // pixels at scale 1

/// Debian's fonts-dejavu-core first; elsewhere the same font lies elsewhere.
constexpr std::array kFonts{
    "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
    "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
    "/usr/share/fonts/TTF/DejaVuSans.ttf",
    "/usr/share/fonts/dejavu/DejaVuSans.ttf",
};

ImVec4 grey(float value, float alpha = 1) {
  return {value, value * 1.01F, value * 1.03F, alpha};
}

ImVec4 accent(float value, float alpha = 1) {
  return {0.36F * value, 0.61F * value, 0.78F * value, alpha};
}

void set_colours(ImGuiStyle& style) {
  const auto set = [&](ImGuiCol which, const ImVec4& colour) { style.Colors[which] = colour; };
  set(ImGuiCol_Text, grey(0.87F));
  set(ImGuiCol_TextDisabled, grey(0.55F));
  set(ImGuiCol_WindowBg, grey(0.125F, 0.97F));
  set(ImGuiCol_ChildBg, grey(0.125F, 0));
  set(ImGuiCol_PopupBg, grey(0.15F, 0.98F));
  set(ImGuiCol_Border, grey(0.25F));
  set(ImGuiCol_FrameBg, grey(0.20F));
  set(ImGuiCol_FrameBgHovered, grey(0.26F));
  set(ImGuiCol_FrameBgActive, grey(0.30F));
  set(ImGuiCol_TitleBg, grey(0.16F));
  set(ImGuiCol_TitleBgActive, grey(0.20F));
  set(ImGuiCol_TitleBgCollapsed, grey(0.16F));
  set(ImGuiCol_ScrollbarBg, grey(0.125F, 0));
  set(ImGuiCol_ScrollbarGrab, grey(0.28F));
  set(ImGuiCol_ScrollbarGrabHovered, grey(0.36F));
  set(ImGuiCol_ScrollbarGrabActive, grey(0.42F));
  set(ImGuiCol_CheckMark, accent(1.15F));
  set(ImGuiCol_SliderGrab, accent(0.95F));
  set(ImGuiCol_SliderGrabActive, accent(1.2F));
  set(ImGuiCol_Button, grey(0.22F));
  set(ImGuiCol_ButtonHovered, grey(0.30F));
  set(ImGuiCol_ButtonActive, accent(0.8F));
  set(ImGuiCol_Header, grey(0.19F));
  set(ImGuiCol_HeaderHovered, grey(0.25F));
  set(ImGuiCol_HeaderActive, grey(0.29F));
  set(ImGuiCol_Separator, grey(0.25F));
  set(ImGuiCol_PlotLines, accent(1));
  set(ImGuiCol_PlotHistogram, accent(1));
  set(ImGuiCol_TextSelectedBg, accent(0.7F, 0.6F));
  set(ImGuiCol_NavHighlight, {0.93F, 0.75F, 0.36F, 1});
  set(ImGuiCol_TableBorderLight, grey(0.22F));
  set(ImGuiCol_TableRowBgAlt, grey(1, 0.02F));
}

}  // namespace

void apply_interface_theme(float scale) {
  ImGuiStyle style;
  style.WindowPadding = {10, 8};
  style.FramePadding = {6, 3};
  style.ItemSpacing = {8, 5};
  style.ItemInnerSpacing = {6, 4};
  style.ScrollbarSize = 11;
  style.GrabMinSize = 10;
  style.WindowRounding = 0;
  style.FrameRounding = 3;
  style.GrabRounding = 3;
  style.PopupRounding = 3;
  style.ScrollbarRounding = 5;
  style.WindowBorderSize = 0;
  style.PopupBorderSize = 1;
  set_colours(style);
  style.ScaleAllSizes(scale);
  ImGui::GetStyle() = style;
}

float load_interface_font(ImFontAtlas& atlas, float scale) {
  // Half pixels would blur what hinting has made sharp.
  const float height = std::round(kTextHeight * scale);
  ImFontConfig config;
  config.OversampleH = 2;
  config.PixelSnapH = true;
  for (const char* file : kFonts) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(file, ignored) && atlas.AddFontFromFileTTF(file, height, &config) != nullptr) {
      return height;
    }
  }
  config.SizePixels = std::max(13.0F, std::round(13 * scale));
  atlas.AddFontDefault(&config);
  return config.SizePixels;
}

}  // namespace foreview
