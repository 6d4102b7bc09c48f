#include "foreview/viewer/key_map.h"

#include <gtest/gtest.h>

#include <set>
#include <sstream>
#include <vector>

namespace foreview {
namespace {

constexpr int kLastAction = static_cast<int>(ViewerAction::quit);

std::vector<KeyChord> all_chords() {
  std::vector<KeyChord> chords;
  for (int key = 1; key < KeyChord::f1 + 12; ++key) {
    for (const bool shift : {false, true}) {
      for (const bool control : {false, true}) chords.push_back({key, shift, control});
    }
  }
  return chords;
}

TEST(KeyMap, EveryActionHasAKey) {
  for (int i = 0; i <= kLastAction; ++i) {
    const auto action = static_cast<ViewerAction>(i);
    EXPECT_FALSE(chords_of(action).empty()) << "action " << i << " has no key";
    EXPECT_FALSE(keys_of(action).empty()) << "action " << i << " is not named";
  }
}

TEST(KeyMap, NoKeyDoesTwoThings) {
  for (const KeyChord& chord : all_chords()) {
    EXPECT_FALSE(action_of(chord) && move_of(chord)) << to_string(chord);
  }
  for (int i = 0; i <= kLastAction; ++i) {
    const auto action = static_cast<ViewerAction>(i);
    for (const KeyChord& chord : chords_of(action)) EXPECT_EQ(action_of(chord), action) << to_string(chord);
  }
}

TEST(KeyMap, EveryWayToMoveHasAKey) {
  std::set<MoveKey> reached;
  for (const KeyChord& chord : all_chords()) {
    if (const auto move = move_of(chord)) reached.insert(*move);
  }
  EXPECT_EQ(reached.size(), kMoveKeys);
}

TEST(KeyMap, OnlyStepsRepeat) {
  EXPECT_EQ(action_of({KeyChord::right, false, false}, true), ViewerAction::step_forward);
  EXPECT_EQ(action_of({'s', false, false}, true), std::nullopt);
  EXPECT_EQ(action_of({'q', false, false}, true), std::nullopt);
  EXPECT_EQ(action_of({KeyChord::space, false, false}, true), std::nullopt);
}

TEST(KeyMap, ModifiersMatter) {
  EXPECT_EQ(action_of({'c', false, false}), ViewerAction::next_camera);
  EXPECT_EQ(action_of({'c', false, true}), ViewerAction::copy_command);
  EXPECT_EQ(action_of({'s', false, true}), std::nullopt);
  EXPECT_EQ(move_of({KeyChord::left, true, false}), MoveKey::turn_left);
  EXPECT_EQ(move_of({KeyChord::left, false, false}), std::nullopt);
}

TEST(KeyMap, Names) {
  EXPECT_EQ(to_string(KeyChord{'c', false, true}), "Ctrl+C");
  EXPECT_EQ(to_string(KeyChord{KeyChord::left, true, false}), "Shift+Left");
  EXPECT_EQ(to_string(KeyChord{KeyChord::f1 + 10, false, false}), "F11");
  EXPECT_EQ(keys_of(ViewerAction::quit), "Esc / Q");
}

TEST(KeyMap, NoKeyPassesForPunctuation) {
  EXPECT_EQ(keys_of(ViewerAction::split_left), "Comma");
  EXPECT_EQ(keys_of(ViewerAction::slower), "Minus");
  for (const KeyRow& row : key_rows()) {
    for (const char* unclear : {",,", ", ,", ", .", "-,", "- /"}) {
      EXPECT_EQ(row.keys.find(unclear), std::string::npos) << row.keys;
    }
  }
}

TEST(KeyMap, TablesSayTheSame) {
  const std::string text = key_table_text(), markdown = key_table_markdown();
  for (const KeyRow& row : key_rows()) {
    EXPECT_NE(text.find(row.effect), std::string::npos);
    EXPECT_NE(markdown.find("| " + row.keys + " | " + row.effect + " |\n"), std::string::npos);
  }
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 110U) << line;
}

}  // namespace
}  // namespace foreview
