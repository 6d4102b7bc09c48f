#pragma once
#include <functional>
#include <memory>
#include <string>

#include "foreview/recordings/recording.h"
#include "foreview/server/dds/dds_node.h"

namespace foreview {

/// The robot's side, played by a recording: publishes it under ROS 2's types at its own pace.
///
/// Of camera NAME: /NAME/image_raw/compressed (the file's bytes as they are), /NAME/camera_info with the same stamp,
/// and tf from "world" to NAME_optical_frame. Of part NAME of the model: tf from "world" to NAME (tf_static, where a
/// single pose is recorded). Joints: /joint_states. Poses are sent at their own stamps and, interpolated, at those of
/// the pictures, before the picture: so their receiver has the state that a replay has.
class RecordingSender {
 public:
  struct Options {
    double speed = 1;
    bool loop = false;
    /// Stamps as recorded; else shifted so that what is sent first is stamped with the time it is sent.
    bool keeps_stamps = false;
    bool is_reliable = false;  ///< pictures and camera_info, too
    /// Where pictures go before they are sent: damage them for a test, say. May be empty.
    std::function<void(CompressedImageMessage&)> before_sending = {};
  };
  /// Recording and node must outlive the sender. Throws InputError on a speed out of range (0.01 to 100).
  RecordingSender(const Recording& recording, DdsNode& node, Options options);
  ~RecordingSender();

  /// Somebody hears every camera's pictures and camera_info, and tf.
  [[nodiscard]] bool is_heard() const;
  struct Summary {
    std::size_t pictures = 0;    ///< sent
    std::size_t unreadable = 0;  ///< files that could not be read
  };
  /// Sends all (with `loop` without end), waiting in between; `goes_on` is asked at least every 100 ms.
  Summary run(const std::function<bool()>& goes_on);

  [[nodiscard]] static std::string image_topic(const std::string& camera);
  [[nodiscard]] static std::string frame(const std::string& camera);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
