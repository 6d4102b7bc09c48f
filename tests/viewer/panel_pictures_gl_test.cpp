#include <backends/imgui_impl_opengl3.h>
#include <imgui_internal.h>

#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>

#include "foreview/viewer/extraction_names.h"
#include "gpu/gl_test_fixture.h"
#include "support/golden_image.h"
#include "viewer/panel_harness.h"

namespace foreview {
namespace {

using test::PanelHarness;

// Other drivers round the edges of letters and rounded corners differently.
constexpr testing::GoldenThresholds kAcrossRenderers{.maximum = 60, .mean = 0.4};

/// What the panels tell of a session that is well under way, in figures that do not change.
void fill_in(PanelHarness& panels) {
  ViewerStatus& status = panels.status();
  status.rate_reached = 32.9;
  status.frames = 12345;
  status.frames_late = 7;
  status.frames_skipped = 21;
  status.pictures_per_second = 8.4;
  for (std::size_t i = 0; i < ViewerStatus::kFrames; ++i) {
    const bool late = i % 37 == 9;
    status.last_frames.push_back({30.3F + static_cast<float>(i % 5) * 0.4F + (late ? 9.0F : 0.0F), late});
  }
  for (std::size_t i = 0; i < ViewerStatus::kPictures; ++i) {
    ViewerStatus::Picture picture;
    for (std::size_t step = 0; step < kExtractionSteps; ++step) {
      picture.step_ms[step] = 1.5F + static_cast<float>((7 * i + 5 * step) % 11) + (step == 6 ? 18.0F : 0.0F);
    }
    status.last_pictures.push_back(picture);
  }
  status.newest_picture = PanelHarness::time(103.6);
  status.source.pictures_in = 240;
  status.source.used = 98;
  status.source.overwritten = 141;
  status.registration.emplace();
  status.registration->error_recorded = 0.42;
  status.texture_bytes = std::size_t{384} << 20;
  status.process_bytes = std::size_t{1234} << 20;
  status.renderer = "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5 (Core Profile) Mesa 22.3.6";
  panels.clock().seek(PanelHarness::time(104.25));
}

void add_polygon(ViewerStatus& status) {
  PolygonReport report;
  report.polygon = 1041;
  report.part = "forearm";
  report.corners = 4;
  report.area = 0.01274;
  report.page = 2;
  report.origin = {512, 384};
  report.size = {128, 64};
  report.group_polygons = 3;
  report.texels = 4711;
  report.observed_share = 0.83;
  report.captures = {{PanelHarness::time(103.6), 0.7}, {PanelHarness::time(101), 0.13}};
  status.polygon = report;
  status.polygon_found = true;
  status.polygon_distance = 1.273;
  status.texel_captured = PanelHarness::time(103.6);
}

/// Panels drawn off-screen, by the same code that draws them in the window.
class PanelPictures : public GlTest {
 protected:
  static void set_open(const char* section, bool open) {
    ImGuiWindow* window = ImGui::FindWindowByName("Panels");
    ASSERT_NE(window, nullptr);
    window->StateStorage.SetInt(window->GetID(section), open ? 1 : 0);
  }

  /// The picture after a few frames, in which Dear ImGui finds the sizes of what is as large as its contents.
  static cv::Mat draw(PanelHarness& panels) {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const int width = static_cast<int>(size.x), height = static_cast<int>(size.y);
    EXPECT_TRUE(ImGui_ImplOpenGL3_Init("#version 450 core"));
    ImGui_ImplOpenGL3_NewFrame();
    panels.frames(4);
    const GlTexture colour = make_texture_2d(GL_RGBA8, width, height);
    const GlFramebuffer framebuffer = GlFramebuffer::create();
    glNamedFramebufferTexture(framebuffer.id(), GL_COLOR_ATTACHMENT0, colour.id(), 0);
    constexpr std::array<float, 4> kBehind{0.25F, 0.3F, 0.25F, 1};
    glClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 0, kBehind.data());
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    cv::Mat picture(height, width, CV_8UC3), upright;
    glReadPixels(0, 0, width, height, GL_BGR, GL_UNSIGNED_BYTE, picture.data);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    cv::flip(picture, upright, 0);
    ImGui_ImplOpenGL3_Shutdown();
    return upright;
  }
};

TEST_F(PanelPictures, OfASession) {
  PanelHarness panels(1280, 800, 1);
  fill_in(panels);
  testing::expect_golden(draw(panels), "panels", kAcrossRenderers);
}

TEST_F(PanelPictures, OfTheExtractionsParameters) {
  for (const PipelineKind pipeline : {PipelineKind::batched, PipelineKind::per_polygon}) {
    PanelHarness panels(900, 800, 1, pipeline);
    fill_in(panels);
    panels.frame();
    set_open("Status", false);
    set_open("Extraction", true);
    testing::expect_golden(draw(panels), std::string("panels-extraction-") + to_string(pipeline), kAcrossRenderers);
  }
}

TEST_F(PanelPictures, OfThePolygonUnderTheCursor) {
  PanelHarness panels(1280, 1000, 1);
  fill_in(panels);
  add_polygon(panels.status());
  panels.control().settings().probe = true;
  testing::expect_golden(draw(panels), "panels-polygon", kAcrossRenderers);
}

TEST_F(PanelPictures, OfTroubles) {
  PanelHarness panels(1280, 800, 1);
  fill_in(panels);
  SourceStatus& source = panels.status().source;
  source.pictures_in = 1234567;
  source.used = 1000000;
  source.overwritten = 234567;
  panels.status().registration->is_correcting = true;
  panels.status().registration->error_recorded = 15.9;
  panels.status().registration->error_registered = 11.4;
  source.lost = 12;
  source.damaged = 3;
  source.stateless = 1;
  source.error = "/home/operator/recordings/cell-7/rgb/000123.png: no such file";
  panels.status().message = "the graphics context was lost; textures are made anew";
  panels.status().message_is_error = true;
  panels.control().settings().choice.mode = ViewMode::difference;
  panels.status().truth_known = false;
  testing::expect_golden(draw(panels), "panels-troubles", kAcrossRenderers);
}

TEST_F(PanelPictures, OfTheHelpInOneColumnAndInTwo) {
  for (const float width : {1280.0F, 720.0F}) {
    PanelHarness panels(width, 900, 1);
    fill_in(panels);
    panels.control().settings().help = true;
    testing::expect_golden(draw(panels), "panels-help-" + std::to_string(static_cast<int>(width)), kAcrossRenderers);
  }
}

TEST_F(PanelPictures, OfTheKeyboardInThePanels) {
  PanelHarness panels(1280, 800, 1);
  fill_in(panels);
  panels.frames(2);
  panels.enter();
  panels.press(ImGuiKey_DownArrow);
  testing::expect_golden(draw(panels), "panels-keyboard", kAcrossRenderers);
}

TEST_F(PanelPictures, OfAScreenOfTwiceTheDensity) {
  PanelHarness panels(2560, 1600, 2);
  fill_in(panels);
  const cv::Mat picture = draw(panels);
  EXPECT_EQ(panels.em(), 30);
  testing::expect_golden(picture, "panels-density-2", kAcrossRenderers);
}

/// Nothing may be cut off at the right, at any density: what is drawn last in a line ends where the panel's margin
/// begins, and the panel cannot be scrolled sideways.
TEST_F(PanelPictures, FitAtEveryDensity) {
  for (const float scale : {1.0F, 1.25F, 1.5F, 2.0F, 3.0F}) {
    PanelHarness panels(std::round(1280 * scale), std::round(800 * scale), scale);
    fill_in(panels);
    add_polygon(panels.status());
    panels.control().settings().probe = true;
    panels.frames(4);
    for (const char* name : {"Panels", "Timeline"}) {
      const ImGuiWindow* window = ImGui::FindWindowByName(name);
      ASSERT_NE(window, nullptr);
      const float room = window->InnerRect.GetWidth() - 2 * window->WindowPadding.x;
      EXPECT_LE(window->ContentSize.x, room + 1) << name << " at " << scale;
    }
  }
}

}  // namespace
}  // namespace foreview
