#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "foreview/scene/camera_frame.h"
#include "foreview/scene/polygon_model.h"

namespace foreview {

class Disk;

/// Poses over time: between stamps interpolated, outside the covered time none (never extrapolated).
class Trajectory {
 public:
  /// Keeps samples in order of time; a sample whose stamp is already there is refused (returns false).
  bool add(Timestamp stamp, const Pose& pose);
  [[nodiscard]] std::optional<Pose> at(Timestamp stamp) const;
  [[nodiscard]] bool empty() const { return samples_.empty(); }
  [[nodiscard]] std::size_t size() const { return samples_.size(); }
  [[nodiscard]] Timestamp first() const { return samples_.front().stamp; }
  [[nodiscard]] Timestamp last() const { return samples_.back().stamp; }
  struct Sample {
    Timestamp stamp;
    Pose pose;
  };
  [[nodiscard]] const std::vector<Sample>& samples() const { return samples_; }

 private:
  std::vector<Sample> samples_;
};

/// What was wrong with a recording's items, dropped and counted; each kind is logged once with its first place.
struct RecordingDamage {
  std::size_t lines_malformed = 0;        ///< rgb.txt, trajectories, joints.csv: dropped lines
  std::size_t stamps_out_of_order = 0;    ///< kept, sorted in
  std::size_t stamps_duplicated = 0;      ///< dropped, the first stays
  std::size_t poses_not_finite = 0;       ///< dropped: NaN, infinite, or further than 1e9 m from the origin
  std::size_t poses_not_unit = 0;         ///< quaternion off unit length by more than 1e-2: dropped; less: normalised
  std::size_t pictures_missing = 0;       ///< listed, but no such file: dropped
  std::size_t pictures_without_pose = 0;  ///< outside their camera's or a part's recorded time: dropped
  std::size_t pictures_unreadable = 0;    ///< found when read (each counted once): cut off, no picture, wrong size
  [[nodiscard]] std::size_t total() const;
};

enum class StampMeaning { middle_of_exposure, start_of_exposure };

/// A recorded stream in a directory (docs/recording-format.md): TUM RGB-D conventions plus camera.yaml, a scene model
/// and an optional recording.yaml.
class Recording {
 public:
  struct PictureEntry {
    Timestamp stamp;             ///< middle of exposure
    std::filesystem::path file;  ///< absolute or relative to the working directory
    std::string stem;            ///< file name without directory and extension; names the pictures we save, so where
                                 ///< two of a camera agree, the later one gets its index appended
  };
  struct Camera {
    std::string name;
    CameraModel model;
    std::vector<PictureEntry> pictures;  ///< ascending stamps, each with a pose
    Trajectory world_from_camera;
  };

  /// Reads all but the pictures themselves. Throws InputError where the recording as a whole cannot be used (no
  /// directory, no camera.yaml, no list, not one usable picture, broken YAML); damaged items are dropped and counted.
  [[nodiscard]] static Recording open(const std::filesystem::path& directory);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }
  [[nodiscard]] const std::vector<Camera>& cameras() const { return cameras_; }
  /// The camera named, or the first where `name` is empty; InputError lists the names there are.
  [[nodiscard]] std::size_t camera_index(const std::string& name) const;
  [[nodiscard]] std::optional<std::filesystem::path> scene_file() const { return scene_file_; }
  [[nodiscard]] const ImportOptions& import_options() const { return import_options_; }
  /// Options for textures that the recording proposes (recording.yaml: textures: {density, max_texels}).
  [[nodiscard]] std::optional<double> proposed_density() const { return proposed_density_; }
  [[nodiscard]] std::optional<int> proposed_max_texels() const { return proposed_max_texels_; }
  /// A recording that begins with a model already textured (spec 12's "partly textured object"): saved textures.
  [[nodiscard]] std::optional<std::filesystem::path> initial_textures() const { return initial_textures_; }
  [[nodiscard]] const RecordingDamage& damage() const { return damage_; }

  /// Times covered by this camera's pictures.
  [[nodiscard]] Timestamp first_stamp(std::size_t camera = 0) const;
  [[nodiscard]] Timestamp last_stamp(std::size_t camera = 0) const;
  /// "#200" is picture 200's stamp, "3.5", "3.5s", "500ms" the time since the first picture. InputError names `option`.
  [[nodiscard]] Timestamp parse_position(std::string_view text, const std::string& option,
                                         std::size_t camera = 0) const;

  /// Where the camera and the model's parts were at a time; none outside the recorded time of what moves. Parts
  /// without a recorded trajectory stay at identity, parts with a single recorded pose stay there.
  [[nodiscard]] std::optional<CaptureState> capture_state(std::size_t camera, Timestamp stamp,
                                                          const PolygonModel& model) const;
  [[nodiscard]] std::optional<PredictedState> predicted_state(std::size_t camera, Timestamp stamp,
                                                              const PolygonModel& model) const;
  /// Part trajectories by part name (parts/NAME.txt, TUM format, world_from_part).
  [[nodiscard]] const std::map<std::string, Trajectory>& part_trajectories() const { return parts_; }
  /// Joint positions over time, as recorded (joints.csv: "stamp,joint1,..."); kept for the kinematics.
  struct Joints {
    std::vector<std::string> names;
    std::vector<Timestamp> stamps;
    std::vector<std::vector<double>> positions;  ///< per stamp, one per name, radians or metres
  };
  [[nodiscard]] const Joints& joints() const { return joints_; }

  /// Decodes a picture to CV_8UC3 BGR. Grey becomes BGR. Throws InputError (file, why) on a file that is not a whole
  /// picture (a cut-off JPEG or PNG included) or not of the camera's size.
  [[nodiscard]] cv::Mat read_picture(std::size_t camera, std::size_t index) const;
  /// The picture with its state, or nothing where it is damaged: then it is counted in damage() and logged.
  [[nodiscard]] std::optional<CameraFrame> read_frame(std::size_t camera, std::size_t index, const PolygonModel& model);
  /// Index of the newest picture with stamp < `before` (strictly), or none.
  [[nodiscard]] std::optional<std::size_t> newest_before(std::size_t camera, Timestamp before) const;

 private:
  friend class RecordingReader;
  std::string name_;
  std::filesystem::path directory_;
  std::vector<Camera> cameras_;
  std::optional<std::filesystem::path> scene_file_, initial_textures_;
  ImportOptions import_options_;
  std::optional<double> proposed_density_;
  std::optional<int> proposed_max_texels_;
  std::map<std::string, Trajectory> parts_;
  Joints joints_;
  RecordingDamage damage_;
  std::set<std::pair<std::size_t, std::size_t>> dropped_;  ///< camera and index of pictures found damaged when read
};

/// Reads a JPEG or PNG strictly: CV_8UC3, or InputError where the file is missing, not a picture, or cut off (OpenCV
/// alone would return a picture with a grey lower part).
[[nodiscard]] cv::Mat read_picture_file(const std::filesystem::path& file);

/// Writes a recording; every file is whole at any moment (written beside and renamed; list lines appended only after
/// their picture). Throws InputError naming the file where the disk refuses.
///
/// Durable, it holds that also where the power is cut: a picture is listed by commit() only, which first brings all
/// pictures, then all poses, then the lists to where no power cut takes them. What is listed is whole, with its poses;
/// what was committed is listed. What was added since the last commit() may be lost, and then nothing speaks of it.
class RecordingWriter {
 public:
  struct Description {
    std::string name;
    struct Camera {
      std::string name;  ///< "" for the only camera: its files lie at the top
      CameraModel model;
    };
    std::vector<Camera> cameras;
    std::string scene_file;  ///< relative, already written or to be written by the caller; may be empty
    ImportOptions import_options;
    std::optional<double> density;
    std::optional<int> max_texels;
    std::string initial_textures;                                   ///< relative; may be empty
    StampMeaning stamp_meaning = StampMeaning::middle_of_exposure;  ///< of the stamps given to add_picture
    Duration exposure;                                              ///< needed where stamps mean the start of exposure
    bool is_durable = false;
    Disk* disk = nullptr;  ///< none: real_disk(). Must outlive the writer
  };
  /// Creates the directory. Throws InputError where it holds a recording already, and on names that cannot be files'.
  RecordingWriter(const std::filesystem::path& directory, const Description& description);
  /// `format` "png" or "jpg" (quality 95).
  void add_picture(std::size_t camera, Timestamp stamp, const cv::Mat& bgr, const std::string& format = "jpg");
  /// The same of a picture as its camera encoded it: a whole JPEG or PNG (`format` "jpg" or "png") of the camera's
  /// size, which the caller has checked.
  void add_encoded_picture(std::size_t camera, Timestamp stamp, std::span<const unsigned char> bytes,
                           const std::string& format);
  void add_camera_pose(std::size_t camera, Timestamp stamp, const Pose& world_from_camera);
  /// `part` becomes a file's name: InputError where it cannot be one.
  void add_part_pose(const std::string& part, Timestamp stamp, const Pose& world_from_part);
  /// Once, before add_joints(); names without commas and line ends.
  void set_joint_names(const std::vector<std::string>& names);
  void add_joints(Timestamp stamp, const std::vector<double>& positions);
  /// Writes what is buffered; durable, for good. Returns how many pictures were listed since the last time it was
  /// called. Durable, once syncing has failed nothing more is listed: what the disk then holds is not known.
  std::size_t commit();
  /// commit(), at the end. Called by the destructor too, which swallows errors.
  void finish();
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace foreview
