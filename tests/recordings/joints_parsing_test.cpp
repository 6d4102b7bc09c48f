#include "foreview/recordings/joints_parsing.h"

#include <gtest/gtest.h>

#include "foreview/scene/errors.h"

namespace foreview {
namespace {

TEST(Joints, AreReadInOrderOfTime) {
  DamageLog damage;
  const Recording::Joints joints =
      parse_joints("# robot\r\nstamp, shoulder ,elbow\r\n0.5, 1.5,-2\n0.25,0,1e-3\n\n0.5,7,7\n", "joints.csv", damage);
  EXPECT_EQ(joints.names, (std::vector<std::string>{"shoulder", "elbow"}));
  EXPECT_EQ(joints.stamps, (std::vector<Timestamp>{{250000000}, {500000000}}));
  EXPECT_EQ(joints.positions, (std::vector<std::vector<double>>{{0, 1e-3}, {1.5, -2}}));
  EXPECT_EQ(damage.counts().stamps_out_of_order, 1U);
  EXPECT_EQ(damage.counts().stamps_duplicated, 1U);
  EXPECT_EQ(damage.counts().total(), 2U);
}

TEST(Joints, DamagedLinesAreDroppedAndCounted) {
  DamageLog damage;
  const Recording::Joints joints =
      parse_joints("stamp,a,b\n1,2,3\n2,2\n3,2,3,4\n4,nan,1\n5,inf,1\nx,1,1\n6,one,1\n7,,1\n8,1,1,\n9 1 1\n10,4,5\n",
                   "joints.csv", damage);
  // "8,1,1," has only a trailing comma too many, which spreadsheets write.
  EXPECT_EQ(joints.stamps.size(), 3U);
  EXPECT_EQ(damage.counts().lines_malformed, 8U);
  EXPECT_EQ(damage.counts().total(), 8U);
}

TEST(Joints, WithoutAUsableHeaderAreAnError) {
  std::string many = "stamp";
  for (int i = 0; i < 300; ++i) many += ",j" + std::to_string(i);
  for (const std::string& text :
       {std::string(), std::string("# only\n"), std::string("stamp\n"), std::string("stamp,a,a\n"),
        std::string("stamp,,b\n"), std::string("1,2,3\n"), many, std::string("\x80\xff\0\x01,\n", 6)}) {
    DamageLog damage;
    try {
      static_cast<void>(parse_joints(text, "joints.csv", damage));
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find("joints.csv"), 0U) << error.what();
    }
  }
}

}  // namespace
}  // namespace foreview
