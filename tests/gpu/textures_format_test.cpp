#include "foreview/gpu/textures_format.h"

#include <gtest/gtest.h>

#include <limits>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

using State = TextureStore::PolygonState;

TexturesIndex some_index() {
  TexturesIndex index;
  index.model_fingerprint = 0x0123456789abcdefULL;
  index.layout_fingerprint = 0xfedcba9876543210ULL;
  index.polygons = 3;
  index.charts = 2;
  index.page_size = 64;
  index.page_checksums = {1, 0xffffffffffffffffULL};
  index.states_checksum = 42;
  return index;
}

std::string message_of(const std::string& yaml) {
  try {
    (void)parse_textures_yaml(yaml, "textures.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(TexturesYaml, ReadsBackWhatItWrites) {
  EXPECT_EQ(parse_textures_yaml(to_textures_yaml(some_index()), "x"), some_index());
}

TEST(TexturesYaml, NamesPlaceAndReasonOfEveryDamage) {
  const std::string good = to_textures_yaml(some_index());
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "format"},
      {"- 1\n- 2\n", "textures.yaml"},
      {"format: [", "not valid YAML"},
      {replaced("foreview-textures", "something"), "textures.yaml:1: format: 'something' is not foreview-textures"},
      {replaced("version: 2", "version: 1"), "textures.yaml:2: version: is 1; this program reads 2"},
      {replaced("0123456789abcdef", "0123"), "model_fingerprint"},
      {replaced("0123456789abcdef", "0123456789abcdeg"), "model_fingerprint"},
      {replaced("polygons: 3", "polygons: 0"), "polygons"},
      {replaced("polygons: 3", "polygons: 99999999999"), "polygons"},
      {replaced("charts: 2", "charts: 0"), "charts"},
      {replaced("page_size: 64", "page_size: -64"), "page_size"},
      {replaced("page_size: 64\n", ""), "page_size: is missing"},
      {replaced("[\"0000000000000001\"", "[{}"), "page_checksums"},
      {good + "more: 1\n", "unknown key 'more'"},
      {good.substr(0, good.size() / 2), "textures.yaml"},
  };
  for (const auto& [yaml, expected] : cases) {
    EXPECT_NE(message_of(yaml).find(expected), std::string::npos) << "'" << message_of(yaml) << "' for\n" << yaml;
    EXPECT_FALSE(message_of(yaml).empty()) << yaml;
  }
}

TEST(StatesCsv, ReadsBackBitByBit) {
  const std::vector<State> states{{0, 1, 0.5F, 1},
                                  {0.1F, 1.0F / 3, std::numeric_limits<float>::denorm_min(), 0.5F},
                                  {std::nextafter(1.0F, 0.0F), 0.7F, 1e-30F, 0}};
  const std::vector<State> read = parse_states_csv(to_states_csv(states), "s", states.size());
  ASSERT_EQ(read.size(), states.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    EXPECT_EQ(read[i].red, states[i].red);
    EXPECT_EQ(read[i].green, states[i].green);
    EXPECT_EQ(read[i].blue, states[i].blue);
    EXPECT_EQ(read[i].seen, states[i].seen);
  }
}

TEST(StatesCsv, RefusesDamageNamingTheLine) {
  const std::string head = "red,green,blue,seen\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "s: has the states of 0 polygons; expected 2"},
      {"red;green\n", "s:1: "},
      {head + "0,0,0,1\n", "s: has the states of 1 polygons; expected 2"},
      {head + "0,0,0,1\n0,0,0,1\n0,0,0,1\n", "s:4: more lines than the model's 2 polygons"},
      {head + "0,0,0,1\n0,0,0,1", "s:3: the file is cut off"},
      {head + "0,0,0\n", "s:2: "},
      {head + "0,0,0,1,1\n", "s:2: "},
      {head + "0,0,,1\n", "s:2: "},
      {head + "nan,0,0,1\n", "s:2: "},
      {head + "inf,0,0,1\n", "s:2: "},
      {head + "1.5,0,0,1\n", "s:2: "},
      {head + "-0.1,0,0,1\n", "s:2: "},
      {head + "0,0,0,0.7\n", "s:2: "},
      {head + "0, 0,0,1\n", "s:2: "},
      {head + "\n", "s:2: "},
  };
  for (const auto& [csv, expected] : cases) {
    try {
      (void)parse_states_csv(csv, "s", 2);
      ADD_FAILURE() << "accepted " << csv;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).rfind(expected, 0), 0U) << error.what() << " for " << csv;
    }
  }
}

TEST(LayoutFingerprint, ChangesWithWhateverMovesATexel) {
  ChartLayout layout;
  layout.page_size = 64;
  layout.pages = 2;
  layout.groups.resize(2);
  layout.groups[1].origin = {16, 0};
  layout.groups[0].member_count = 2;
  layout.groups[1].member_count = 1;
  layout.members = {0, 2, 1};
  const std::uint64_t first = layout_fingerprint(layout);
  EXPECT_EQ(layout_fingerprint(layout), first);
  for (int change = 0; change < 8; ++change) {
    ChartLayout other = layout;
    if (change == 0) other.page_size = 128;
    if (change == 1) other.pages = 3;
    if (change == 2) other.groups[1].page = 1;
    if (change == 3) other.groups[1].origin = {0, 16};
    if (change == 4) other.groups[1].size.y = 16;
    if (change == 5) other.groups[0].inner.x = 12;
    if (change == 6) other.groups[0].member_count = 1, other.groups[1].member_count = 2;
    if (change == 7) other.members = {1, 2, 0};
    EXPECT_NE(layout_fingerprint(other), first) << change;
  }
}

TEST(FileChecksum, IsFnv1a) {
  // The test vectors of its authors.
  EXPECT_EQ(file_checksum(""), 0xcbf29ce484222325ULL);
  EXPECT_EQ(file_checksum("a"), 0xaf63dc4c8601ec8cULL);
  EXPECT_EQ(file_checksum("foobar"), 0x85944171f73967e8ULL);
}

}  // namespace
}  // namespace foreview
