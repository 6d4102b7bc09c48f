#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "foreview/server/live_sink.h"

namespace foreview {

class Disk;

/// Writes what comes in live into a recording, in a thread of its own. It begins when every camera's model is known; of
/// each camera it keeps the pictures as they came (raw ones as PNG), whole ones of the right size only, once their pose
/// is known, and the camera's pose at every step of tf. It writes durably (RecordingWriter), what has come since the
/// last time in one commit: whether the process is killed, the disk is full or the power is cut, what is listed is
/// whole and what is counted as written is listed. A model of another size in mid-stream is not recorded: its pictures
/// count as damaged. Where a stream begins anew (StreamRestart) the recording ends: it has one time only.
class StreamRecorder final : public LiveSink {
 public:
  struct Camera {
    std::string name;
    std::string frame;            ///< its optical frame; empty: the pictures' frame_id
    bool has_pose_topic = false;  ///< its pose comes by on_pose(), not by tf
  };
  struct Options {
    std::filesystem::path directory;
    std::string name;
    std::vector<Camera> cameras;
    std::string world_frame = "world";
    std::string scene_file;          ///< as RecordingWriter::Description
    std::vector<std::string> parts;  ///< of the model: those with a frame of their name are recorded
    Duration state_wait{2'000'000'000};
    std::size_t waiting_bytes = std::size_t{512} << 20;
    Disk* disk = nullptr;  ///< none: the machine's
  };
  /// Throws InputError where there is no camera.
  explicit StreamRecorder(Options options);
  ~StreamRecorder() override;

  void on_picture(std::size_t camera, EncodedPicture picture, const Reception& reception) override;
  void on_camera_info(std::size_t camera, const CameraInfoMessage& info) override;
  void on_transforms(const TransformMessage& message, bool is_static) override;
  void on_pose(std::size_t camera, const PoseMessage& pose) override;
  void on_joints(const JointStateMessage& joints) override;

  struct Status {
    /// = written + damaged + stateless + late + overflowed + unwritten + those that wait.
    std::size_t pictures_in = 0;
    std::size_t written = 0;  ///< and listed
    std::size_t damaged = 0, stateless = 0;
    std::size_t late = 0;        ///< not newer than the one before: came twice, or of another clock
    std::size_t overflowed = 0;  ///< the disk did not keep up
    std::size_t unwritten = 0;   ///< because of `error`, or because it never began
    std::string waiting_for;     ///< why it has not begun; empty: it has
    std::string error;           ///< why it ended; empty: it goes on
  };
  [[nodiscard]] Status status() const;
  /// Writes what waits and can be written.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
