#include "foreview/server/dds/dds_node.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <mutex>
#include <vector>

#include "dds_test_domain.h"
#include "foreview/scene/errors.h"
#include "played_recording.h"

namespace foreview {
namespace {

using test::comes_true;

/// Sends one message and returns what came.
template <class Message>
std::optional<Message> round_trip(const std::string& topic, const Message& message,
                                  QosProfile qos = QosProfile::reliable) {
  DdsNode sender({test::dds_domain()}), receiver({test::dds_domain()});
  std::mutex mutex;
  std::optional<Message> received;
  const auto reader = receiver.subscribe<Message>(topic, qos, [&](Message&& incoming, const Reception&) {
    const std::lock_guard lock(mutex);
    received = std::move(incoming);
  });
  const auto writer = sender.advertise<Message>(topic, qos);
  if (!comes_true([&] { return writer->subscribers() == 1 && reader->publishers() == 1; })) return std::nullopt;
  writer->write(message);
  static_cast<void>(comes_true([&] {
    const std::lock_guard lock(mutex);
    return received.has_value();
  }));
  return received;
}

const MessageHeader kHeader{{-1'500'000'000}, "camera optical frame"};

TEST(DdsNode, PicturesComeAsTheyWereSent) {
  CompressedImageMessage message{kHeader, "jpeg", {}};
  for (int i = 0; i < 700'000; ++i) message.data.push_back(static_cast<std::uint8_t>(i * 7 + i / 251));
  const auto received = round_trip("/camera/image/compressed", message);
  ASSERT_TRUE(received);
  EXPECT_EQ(received->header.stamp, kHeader.stamp);
  EXPECT_EQ(received->header.frame, kHeader.frame);
  EXPECT_EQ(received->format, "jpeg");
  EXPECT_EQ(received->data, message.data);

  const ImageMessage raw{kHeader, 2, 3, "rgb8", true, 9, std::vector<std::uint8_t>(18, 200)};
  const auto raw_received = round_trip("camera/image", raw, QosProfile::sensor_data);
  ASSERT_TRUE(raw_received);
  EXPECT_EQ(raw_received->height, 2U);
  EXPECT_EQ(raw_received->width, 3U);
  EXPECT_EQ(raw_received->encoding, "rgb8");
  EXPECT_TRUE(raw_received->is_big_endian);
  EXPECT_EQ(raw_received->step, 9U);
  EXPECT_EQ(raw_received->data, raw.data);
}

TEST(DdsNode, CameraInfoJointsPosesAndTextComeAsTheyWereSent) {
  CameraInfoMessage info;
  info.header = kHeader;
  info.height = 480;
  info.width = 640;
  info.distortion_model = "plumb_bob";
  info.d = {0.1, -0.2, 0.3, -0.4, 0.5};
  info.k = {500, 0, 320, 0, 501, 240, 0, 0, 1};
  info.binning_x = 2;
  info.roi = {1, 2, 3, 4};
  const auto camera = round_trip("camera_info", info);
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->d, info.d);
  EXPECT_EQ(camera->k, info.k);
  EXPECT_EQ(camera->distortion_model, "plumb_bob");
  EXPECT_EQ(camera->width, 640U);
  EXPECT_EQ(camera->binning_x, 2U);
  EXPECT_EQ(camera->roi.width, 4U);

  const auto joints = round_trip("joint_states", JointStateMessage{kHeader, {"a", "", "c"}, {1, 2, 3}});
  ASSERT_TRUE(joints);
  EXPECT_EQ(joints->name, (std::vector<std::string>{"a", "", "c"}));
  EXPECT_EQ(joints->position, (std::vector<double>{1, 2, 3}));

  const Pose pose{{0.5, -0.5, 0.5, 0.5}, {1, 2, 3}};
  const auto posed = round_trip("pose", PoseMessage{kHeader, pose});
  ASSERT_TRUE(posed);
  EXPECT_EQ(posed->pose, pose);
  const auto transforms = round_trip("tf", TransformMessage{{{kHeader, "a", pose}, {{{5}, "b"}, "c", pose.inverse()}}},
                                     QosProfile::transforms);
  ASSERT_TRUE(transforms);
  ASSERT_EQ(transforms->transforms.size(), 2U);
  EXPECT_EQ(transforms->transforms[0].child_frame, "a");
  EXPECT_EQ(transforms->transforms[1].parent_from_child, pose.inverse());
  EXPECT_EQ(transforms->transforms[1].header.stamp, Timestamp{5});

  const auto text = round_trip("text", TextMessage{"one line"});
  ASSERT_TRUE(text);
  EXPECT_EQ(text->data, "one line");
}

TEST(DdsNode, StaticTransformsReachWhoComesLater) {
  DdsNode sender({test::dds_domain()});
  const auto writer = sender.advertise<TransformMessage>("tf_static", QosProfile::static_transforms);
  writer->write({{{kHeader, "camera", Pose()}}});
  DdsNode receiver({test::dds_domain()});
  std::atomic<int> count{0};
  const auto reader = receiver.subscribe<TransformMessage>("tf_static", QosProfile::static_transforms,
                                                           [&](TransformMessage&&, const Reception&) { ++count; });
  EXPECT_TRUE(comes_true([&] { return count == 1; }));
}

TEST(DdsNode, ReaderThatThrowsGoesOn) {
  DdsNode node({test::dds_domain()});
  std::atomic<int> count{0};
  const auto reader = node.subscribe<TextMessage>("t", QosProfile::reliable, [&](TextMessage&&, const Reception&) {
    if (++count == 1) throw InputError("topic t", "is nonsense");
  });
  const auto writer = node.advertise<TextMessage>("/t", QosProfile::reliable);
  ASSERT_TRUE(comes_true([&] { return writer->subscribers() == 1; }));
  writer->write({"1"});
  writer->write({"2"});
  EXPECT_TRUE(comes_true([&] { return count == 2; }));
}

TEST(DdsNode, RefusesWhatCannotBeUsed) {
  const auto error = [](const std::function<void()>& action) -> std::string {
    try {
      action();
    } catch (const InputError& failure) {
      return failure.what();
    }
    return "";
  };
  EXPECT_NE(error([] { DdsNode({233}); }).find("expected 0 to 232"), std::string::npos);
  EXPECT_NE(error([] { DdsNode({77, "no-such-network"}); }).find("is no network interface"), std::string::npos);
  DdsNode node({test::dds_domain()});
  for (const char* name : {"", "/", "a//b", "a b", "a/", "caf\xc3\xa9"}) {
    EXPECT_NE(error([&] { static_cast<void>(node.advertise<TextMessage>(name, QosProfile::reliable)); }), "") << name;
  }
}

}  // namespace
}  // namespace foreview
