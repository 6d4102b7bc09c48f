#include <gtest/gtest.h>

#include <mutex>
#include <opencv2/imgcodecs.hpp>

#include "fast_node.h"
#include "foreview/server/camera_info.h"
#include "foreview/server/dds/dds_node.h"
#include "foreview/server/live_receiver.h"
#include "foreview/server/live_source.h"
#include "server/dds_test_domain.h"
#include "server/played_recording.h"

#ifdef __SANITIZE_ADDRESS__
// Debian's libfastrtps deletes its statistics' ancillary objects by way of a base class without a virtual destructor:
// reported wherever one of its writers or readers ends, and not ours to mend. ASAN_OPTIONS are read after these, and
// those that do not name this check leave it off.
extern "C" const char* __asan_default_options() {
  return "new_delete_type_mismatch=0";
}
#endif

namespace foreview {
namespace {

using test::comes_true;

// foreview speaks with Cyclone DDS; here, another DDS implementation is at the other end.

cv::Mat noisy_picture() {
  cv::Mat picture(480, 640, CV_8UC3);
  cv::theRNG().state = 5;
  cv::randu(picture, 0, 256);  // some 400 kB of JPEG: many fragments
  return picture;
}

TEST(FastDds, RobotThatSpeaksFastDdsIsHeard) {
  const int domain = test::dds_domain() + 50;
  DdsNode node({domain});
  LiveSource::Options options;
  options.cameras = {{"arm", ""}};
  options.parts = {"gripper"};
  LiveSource source(options);
  const LiveReceiver receiver(node, {camera_topics("/arm/image_raw/compressed")}, source);
  std::mutex mutex;
  std::optional<JointStateMessage> joints;
  const auto joint_reader = node.subscribe<JointStateMessage>("/joint_states", QosProfile::sensor_data,
                                                              [&](JointStateMessage&& message, const Reception&) {
                                                                const std::lock_guard lock(mutex);
                                                                joints = std::move(message);
                                                              });

  fast::Node robot(domain);
  auto* const pictures = robot.advertise<fast::CompressedImage>("rt/arm/image_raw/compressed", false);
  auto* const infos = robot.advertise<fast::CameraInfo>("rt/arm/camera_info", true);
  auto* const tf = robot.advertise<fast::TFMessage>("rt/tf", true);
  auto* const tf_static = robot.advertise<fast::TFMessage>("rt/tf_static", true, true);
  auto* const joint_states = robot.advertise<fast::JointState>("rt/joint_states", true);

  fast::TFMessage fixed;
  fixed.transforms = {{{1, 0, "tool"}, "eye", {0, 0, 0.5}, {0, 0, 0, 1}}};
  tf_static->write(&fixed);
  ASSERT_TRUE(comes_true([&] { return receiver.missing().empty() && joint_reader->publishers() == 1; }))
      << receiver.missing();

  fast::CompressedImage picture;
  picture.header = {1'700'000'000, 123'456'789, "eye"};
  picture.format = "jpeg";
  cv::imencode(".jpg", noisy_picture(), picture.data);
  ASSERT_GT(picture.data.size(), 200'000U);
  fast::CameraInfo info;
  info.header = picture.header;
  info.height = 480;
  info.width = 640;
  info.distortion_model = "plumb_bob";
  info.d = {0.1, 0.01, 0.001, 0.002, 0.003};
  info.k = {500, 0, 319.5, 0, 510, 239.5, 0, 0, 1};
  fast::TFMessage moving;
  moving.transforms = {{picture.header, "tool", {1, 2, 3}, {0, 0, 1, 0}},
                       {picture.header, "gripper", {7, 8, 9}, {0, 0, 0, 1}}};
  for (auto& transform : moving.transforms) transform.header.frame_id = "world";
  fast::JointState state;
  state.header = picture.header;
  state.name = {"shoulder", "elbow"};
  state.position = {0.25, -1.5};
  state.velocity = {9};

  // Writers are matched one after the other; volatile ones may be heard only from the second message on.
  std::optional<IncomingFrame> frame;
  ASSERT_TRUE(comes_true([&] {
    infos->write(&info);
    tf->write(&moving);
    joint_states->write(&state);
    pictures->write(&picture);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    if (!frame) frame = source.take();
    picture.header.nanosec += 1000;
    for (auto& transform : moving.transforms) transform.header.nanosec += 1000;
    const std::lock_guard lock(mutex);
    return frame && joints;
  }));
  cv::Mat expected;
  cv::imdecode(picture.data, cv::IMREAD_COLOR, &expected);
  EXPECT_EQ(cv::norm(frame->frame.picture, expected, cv::NORM_INF), 0);
  EXPECT_EQ(frame->frame.state.stamp.nanoseconds / 1'000'000, 1'700'000'000'123);
  EXPECT_EQ(frame->frame.camera.focal_length, glm::dvec2(500, 510));
  EXPECT_EQ(frame->frame.camera.principal_point, glm::dvec2(320, 240));
  EXPECT_EQ(frame->frame.camera.distortion[4], 0.003);
  // world_from_tool * tool_from_eye; half a turn about z.
  EXPECT_EQ(frame->frame.state.world_from_camera.translation, glm::dvec3(1, 2, 3.5));
  EXPECT_LT(angle_between(frame->frame.state.world_from_camera, Pose{{0, 0, 0, 1}, {}}), 1e-9);
  EXPECT_EQ(frame->frame.state.world_from_part.at(0).translation, glm::dvec3(7, 8, 9));
  EXPECT_EQ(joints->name, state.name);
  EXPECT_EQ(joints->position, state.position);
}

TEST(FastDds, RobotsToolThatSpeaksFastDdsHearsForeview) {
  const int domain = test::dds_domain() + 51;
  fast::Node tool(domain);
  auto* const pictures = tool.subscribe<fast::CompressedImage>("rt/arm/image_raw/compressed", false);
  auto* const raw_pictures = tool.subscribe<fast::Image>("rt/arm/image_raw", true);
  auto* const infos = tool.subscribe<fast::CameraInfo>("rt/arm/camera_info", true);
  auto* const tf = tool.subscribe<fast::TFMessage>("rt/tf", true);
  auto* const tf_static = tool.subscribe<fast::TFMessage>("rt/tf_static", true, true);
  auto* const joint_states = tool.subscribe<fast::JointState>("rt/joint_states", true);

  DdsNode node({domain});
  const auto picture_writer =
      node.advertise<CompressedImageMessage>("/arm/image_raw/compressed", QosProfile::sensor_data);
  const auto raw_writer = node.advertise<ImageMessage>("/arm/image_raw", QosProfile::reliable);
  const auto info_writer = node.advertise<CameraInfoMessage>("/arm/camera_info", QosProfile::reliable);
  const auto tf_writer = node.advertise<TransformMessage>("/tf", QosProfile::transforms);
  const auto static_writer = node.advertise<TransformMessage>("/tf_static", QosProfile::static_transforms);
  const auto joint_writer = node.advertise<JointStateMessage>("/joint_states", QosProfile::reliable);

  const MessageHeader header{{1'700'000'000'123'456'789}, "eye"};
  const Pose pose{{0, 0, 0, 1}, {1, 2, 3}};
  static_writer->write({{{{header.stamp, "tool"}, "eye", pose}}});
  ASSERT_TRUE(comes_true([&] {
    return picture_writer->subscribers() == 1 && raw_writer->subscribers() == 1 && info_writer->subscribers() == 1 &&
           tf_writer->subscribers() == 1 && joint_writer->subscribers() == 1;
  }));
  CompressedImageMessage picture{header, "jpeg", {}};
  cv::imencode(".jpg", noisy_picture(), picture.data);
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.focal_length = {500, 510};
  camera.principal_point = {320, 240};
  camera.distortion_model = DistortionModel::plumb_bob;
  camera.distortion = {0.1, 0.01};
  CameraInfoMessage info = info_from_camera(camera);
  info.header = header;
  const ImageMessage raw{header, 2, 3, "mono8", false, 3, {1, 2, 3, 4, 5, 6}};

  std::optional<fast::CompressedImage> heard_picture;
  std::optional<fast::Image> heard_raw;
  std::optional<fast::CameraInfo> heard_info;
  std::optional<fast::TFMessage> heard_tf, heard_static;
  std::optional<fast::JointState> heard_joints;
  ASSERT_TRUE(comes_true([&] {
    picture_writer->write(picture);
    raw_writer->write(raw);
    info_writer->write(info);
    tf_writer->write({{{{header.stamp, "world"}, "tool", pose}}});
    joint_writer->write({header, {"shoulder", "elbow"}, {0.25, -1.5}});
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    if (!heard_picture) heard_picture = fast::take<fast::CompressedImage>(pictures);
    if (!heard_raw) heard_raw = fast::take<fast::Image>(raw_pictures);
    if (!heard_info) heard_info = fast::take<fast::CameraInfo>(infos);
    if (!heard_tf) heard_tf = fast::take<fast::TFMessage>(tf);
    if (!heard_static) heard_static = fast::take<fast::TFMessage>(tf_static);
    if (!heard_joints) heard_joints = fast::take<fast::JointState>(joint_states);
    return heard_picture && heard_raw && heard_info && heard_tf && heard_static && heard_joints;
  })) << heard_picture.has_value()
      << heard_raw.has_value() << heard_info.has_value() << heard_tf.has_value() << heard_static.has_value()
      << heard_joints.has_value();
  EXPECT_EQ(heard_picture->header.sec, 1'700'000'000);
  EXPECT_EQ(heard_picture->header.nanosec, 123'456'789U);
  EXPECT_EQ(heard_picture->header.frame_id, "eye");
  EXPECT_EQ(heard_picture->format, "jpeg");
  EXPECT_EQ(heard_picture->data, picture.data);
  EXPECT_EQ(heard_raw->encoding, "mono8");
  EXPECT_EQ(heard_raw->step, 3U);
  EXPECT_EQ(heard_raw->data, raw.data);
  EXPECT_EQ(heard_info->width, 640U);
  EXPECT_EQ(heard_info->k, (std::array<double, 9>{500, 0, 319.5, 0, 510, 239.5, 0, 0, 1}));
  EXPECT_EQ(heard_info->r, (std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_EQ(heard_info->p, (std::array<double, 12>{500, 0, 319.5, 0, 0, 510, 239.5, 0, 0, 0, 1, 0}));
  EXPECT_EQ(heard_info->d, (std::vector<double>{0.1, 0.01, 0, 0, 0}));
  EXPECT_FALSE(heard_info->do_rectify);
  ASSERT_EQ(heard_tf->transforms.size(), 1U);
  EXPECT_EQ(heard_tf->transforms[0].header.frame_id, "world");
  EXPECT_EQ(heard_tf->transforms[0].child_frame_id, "tool");
  EXPECT_EQ(heard_tf->transforms[0].translation, (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(heard_tf->transforms[0].rotation, (std::array<double, 4>{0, 0, 1, 0}));
  EXPECT_EQ(heard_static->transforms[0].child_frame_id, "eye");
  EXPECT_EQ(heard_joints->name, (std::vector<std::string>{"shoulder", "elbow"}));
  EXPECT_EQ(heard_joints->position, (std::vector<double>{0.25, -1.5}));
}

}  // namespace
}  // namespace foreview
