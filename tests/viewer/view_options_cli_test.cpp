#include "foreview/viewer/view_options_cli.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <memory>
#include <random>

#include "foreview/scene/errors.h"
#include "foreview/viewer/command_line.h"

namespace foreview {
namespace {

ViewChoice parse(std::vector<std::string> words) {
  CLI::App app;
  ViewChoice choice;
  add_view_options(app, choice);
  std::reverse(words.begin(), words.end());  // as CLI11 wants them
  app.parse(words);
  return choice;
}

std::string refusal(const std::vector<std::string>& words) {
  try {
    static_cast<void>(parse(words));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

void expect_same(const ViewChoice& a, const ViewChoice& b) {
  ViewChoice left = a, right = b;
  EXPECT_LT(glm::distance(left.turn, right.turn), 1e-12);
  ASSERT_EQ(left.field_of_view.has_value(), right.field_of_view.has_value());
  if (left.field_of_view) {
    EXPECT_NEAR(*left.field_of_view, *right.field_of_view, 1e-12);
  }
  ASSERT_EQ(left.pose.has_value(), right.pose.has_value());
  if (left.pose) {
    EXPECT_EQ(left.pose->translation, right.pose->translation);
    EXPECT_LT(angle_between(*left.pose, *right.pose), 1e-12);
  }
  left.turn = right.turn;
  left.field_of_view = right.field_of_view;
  left.pose = right.pose;
  EXPECT_EQ(left, right) << "to the last bit, but for angles";
}

TEST(ViewOptionsCli, NothingGivenIsTheUsualView) {
  EXPECT_EQ(parse({}), ViewChoice());
  EXPECT_TRUE(to_view_arguments(ViewChoice()).empty());
}

TEST(ViewOptionsCli, EveryChoiceComesBack) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> real(-1, 1);
  const auto coin = [&] { return random() % 2 == 0; };
  for (int i = 0; i < 500; ++i) {
    ViewChoice choice;
    choice.mode = kViewModes[random() % kViewModes.size()];
    choice.quality = kViewQualities[random() % kViewQualities.size()];
    choice.split = 0.5 + 0.5 * real(random);
    choice.overlays = {coin(), coin(), coin(), coin(), coin(), coin(), coin()};
    choice.age_span = 5.5 + 5 * real(random);
    if (coin()) choice.polygon = static_cast<std::uint32_t>(random());
    choice.camera = kCameraModes[random() % kCameraModes.size()];
    if (coin()) {
      choice.pose = Pose{glm::normalize(glm::dquat(real(random), real(random), real(random), real(random))),
                         {1e3 * real(random), real(random), 1e-7 * real(random)}};
    }
    if (coin()) choice.turn = {3 * real(random), real(random)};
    if (coin()) choice.field_of_view = 1.4 + 1.3 * real(random);
    expect_same(parse(to_view_arguments(choice)), choice);
  }
}

TEST(ViewOptionsCli, NamesAndOtherSpellings) {
  EXPECT_EQ(parse({"--view", "side-by-side"}).mode, ViewMode::side_by_side);
  EXPECT_EQ(parse({"--view", "both"}).mode, ViewMode::side_by_side);
  EXPECT_EQ(parse({"--camera-pose=-1,2,3, 0,0,0,1"}).pose, (Pose{{1, 0, 0, 0}, {-1, 2, 3}}));
  EXPECT_EQ(parse({"--camera-pose", "-1 2 3 0 0 0 1"}).pose, (Pose{{1, 0, 0, 0}, {-1, 2, 3}}));
  EXPECT_NEAR(parse({"--camera-turn=-90 0"}).turn.x, -1.5707963, 1e-6);
}

TEST(ViewOptionsCli, RefusalsNameTheOption) {
  for (const auto& [option, value] :
       std::vector<std::pair<std::string, std::string>>{{"--view", "sideways"},

                                                        {"--split", "1.1"},
                                                        {"--split", "nan"},
                                                        {"--split", "0.5x"},
                                                        {"--quality", "best"},
                                                        {"--age-span", "0"},
                                                        {"--age-span", "inf"},
                                                        {"--polygon", "-1"},
                                                        {"--polygon", "99999999999"},
                                                        {"--camera-mode", "fly"},
                                                        {"--camera-pose", "1 2 3"},
                                                        {"--camera-pose", "1 2 3 0 0 0 2"},
                                                        {"--camera-pose", "1 2 3 0 0 0 1 4"},
                                                        {"--camera-pose", "nan 2 3 0 0 0 1"},
                                                        {"--camera-pose", "1e10 2 3 0 0 0 1"},
                                                        {"--camera-turn", "90"},
                                                        {"--camera-turn", "1e9 0"},
                                                        {"--fov", "0"},
                                                        {"--fov", "179"}}) {
    const std::string text = refusal({option + "=" + value});
    EXPECT_EQ(text.rfind(option + ": ", 0), 0U) << option << "=" << value << ": " << text;
    EXPECT_NE(text.find("expected"), std::string::npos) << text;
  }
}

TEST(ViewOptionsCli, AShellGivesTheWordsBack) {
  const std::vector<std::string> words{"foreview", "re play", "it's", "$(false)", "--camera-pose=-1 2 3 0 0 0 1",
                                       "",         "a\"b\\c", "*"};
  std::string line = "printf '%s|'";
  for (const std::string& word : words) line += " " + shell_word(word);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(line.c_str(), "r"), pclose);
  ASSERT_NE(pipe, nullptr);
  std::string out;
  for (int c = std::fgetc(pipe.get()); c != EOF; c = std::fgetc(pipe.get())) out += static_cast<char>(c);
  std::string expected;
  for (const std::string& word : words) expected += word + "|";
  EXPECT_EQ(out, expected);
}

}  // namespace
}  // namespace foreview
