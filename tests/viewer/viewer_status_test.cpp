#include "foreview/viewer/viewer_status.h"

#include <gtest/gtest.h>

#include "foreview/viewer/panel_layout.h"

namespace foreview {
namespace {

TEST(ViewerStatus, Times) {
  EXPECT_EQ(time_text(Duration::from_seconds(12.345)), "12.35 s");
  EXPECT_EQ(time_text(Duration::from_seconds(0)), "0.00 s");
  EXPECT_EQ(time_text(Duration::from_seconds(62.5)), "1:02.50");
  EXPECT_EQ(time_text(Duration::from_seconds(119.999)), "2:00.00");
  EXPECT_EQ(time_text(Duration::from_seconds(-1.5)), "-1.50 s");
}

TEST(ViewerStatus, Ages) {
  EXPECT_EQ(age_text(Duration::from_seconds(0.32)), "320 ms");
  EXPECT_EQ(age_text(Duration::from_seconds(0.9996)), "1.00 s");
  EXPECT_EQ(age_text(Duration::from_seconds(1.254)), "1.25 s");
  EXPECT_EQ(age_text(Duration::from_seconds(9.996)), "10 s");
  EXPECT_EQ(age_text(Duration::from_seconds(34)), "34 s");
}

TEST(ViewerStatus, Amounts) {
  EXPECT_EQ(bytes_text(std::size_t{48} << 20), "48 MiB");
  EXPECT_EQ(bytes_text(std::size_t{1280} << 20), "1.2 GiB");
  EXPECT_EQ(bandwidth_text(0), "no limit");
  EXPECT_EQ(bandwidth_text(5e5), "500 kbit/s");
  EXPECT_EQ(bandwidth_text(9.999e5), "1.0 Mbit/s");
  EXPECT_EQ(bandwidth_text(2.5e6), "2.5 Mbit/s");
  EXPECT_EQ(bandwidth_text(1e8), "100 Mbit/s");
  EXPECT_EQ(count_text(0), "0");
  EXPECT_EQ(count_text(999), "999");
  EXPECT_EQ(count_text(1234567), "1,234,567");
}

TEST(ViewerStatus, Title) {
  TitleInput input;
  input.name = "workcell";
  input.mode = ViewMode::split;
  input.since_first = Duration::from_seconds(1.234);
  input.delay = Duration::from_seconds(0.5);
  input.rate = 49.6;
  EXPECT_EQ(viewer_title(input), "foreview: workcell | split | 1.23 s | delay 500 ms | 50 fps");
  input.paused = true;
  EXPECT_EQ(viewer_title(input), "foreview: workcell | split | 1.23 s | delay 500 ms | 50 fps | paused");
  input.at_end = true;
  EXPECT_EQ(viewer_title(input), "foreview: workcell | split | 1.23 s | delay 500 ms | 50 fps | end");
  input.extracting = true;
  EXPECT_EQ(viewer_title(input), "foreview: workcell | split | 1.23 s | delay 500 ms | 50 fps | end | extracting");
  input.paused = input.at_end = false;
  EXPECT_EQ(viewer_title(input), "foreview: workcell | split | 1.23 s | delay 500 ms | 50 fps");
  input.live = true;
  EXPECT_EQ(viewer_title(input), "foreview: workcell | split | live | no picture yet | 50 fps");
  input.age = Duration::from_seconds(0.0834);
  EXPECT_EQ(viewer_title(input), "foreview: workcell | split | live | 83 ms old | 50 fps");
}

TEST(ViewerStatus, PlotsEndAtRoundFigures) {
  EXPECT_EQ(plot_top(0), 1);
  EXPECT_EQ(plot_top(1), 1);
  EXPECT_EQ(plot_top(1.01), 2);
  EXPECT_EQ(plot_top(4), 5);
  EXPECT_EQ(plot_top(51), 100);
  EXPECT_EQ(plot_top(100), 100);
  EXPECT_EQ(plot_top(101), 200);
}

TEST(ViewerStatus, MemoryOfThisProcess) {
  EXPECT_GT(resident_bytes(), std::size_t{1} << 20);
}

TEST(PanelLayout, FillsTheWindowWithoutOverlap) {
  for (const float em : {15.0F, 30.0F}) {
    const PanelLayout layout = lay_out_panels(1440, 900, em, true);
    ASSERT_TRUE(layout.panels);
    EXPECT_EQ(layout.view.width + layout.side.width, 1440);
    EXPECT_EQ(layout.view.height + layout.timeline.height, 900);
    EXPECT_EQ(layout.side.x, layout.view.width);
    EXPECT_EQ(layout.timeline.y, layout.view.height);
    EXPECT_EQ(layout.timeline.width, layout.view.width);
    EXPECT_EQ(layout.side.height, 900);
  }
}

TEST(PanelLayout, GivesTheViewEverythingWherePanelsAreNotWantedOrHaveNoRoom) {
  for (const PanelLayout& layout : {lay_out_panels(1280, 800, 15, false), lay_out_panels(360, 240, 15, true)}) {
    EXPECT_FALSE(layout.panels);
    EXPECT_EQ(layout.side.width, 0);
  }
  EXPECT_EQ(lay_out_panels(360, 240, 15, true).view.width, 360);
  EXPECT_EQ(lay_out_panels(0, 0, 15, true).view.width, 0);
}

}  // namespace
}  // namespace foreview
