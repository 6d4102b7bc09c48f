#include "foreview/viewer/command_line.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "foreview/viewer/key_map.h"

namespace foreview {
namespace {

TEST(CommandLine, SaysNoMoreThanItMust) {
  ReplayOptions replay;
  replay.recording = "workcell";
  const std::string command = headless_command(replay, {}, 40);
  EXPECT_EQ(command, "foreview replay workcell --delay 500ms --from '#40' --to '#40' --headless --out .");
}

TEST(CommandLine, SaysWhatIsUnusual) {
  ReplayOptions replay;
  replay.recording = "my recordings/it's mine";
  replay.delay = Duration{120'000'000};
  replay.extraction.passes = 5;
  replay.extraction.compensate_exposure = false;
  replay.density = 120;
  ViewChoice choice;
  choice.mode = ViewMode::side_by_side;
  choice.overlays.holes = true;
  choice.overlays.age = true;
  choice.camera = CameraMode::overview;
  const std::string command = headless_command(replay, choice, 3);
  EXPECT_EQ(command,
            "foreview replay 'my recordings/it'\\''s mine' --delay 120ms --from '#3' --to '#3' --passes 5 --exposure "
            "off --density 120 --view=both --holes --age --camera-mode=overview --headless --out .");
}

TEST(KeyTable, IsThatOfTheDocumentation) {
  std::ifstream file(std::string(FOREVIEW_TEST_DIR) + "/../docs/viewer.md");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_NE(text.str().find("<!-- keys -->\n" + key_table_markdown() + "<!-- end of keys -->"), std::string::npos)
      << "docs/viewer.md should have:\n"
      << key_table_markdown();
}

}  // namespace
}  // namespace foreview
