#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "foreview/recordings/recording.h"
#include "foreview/scene/errors.h"
#include "sample_recording.h"
#include "support/simulated_disk.h"

namespace foreview {
namespace {

using test::patterned_picture;
using test::SimulatedDisk;
using test::TemporaryDirectory;
using Luck = SimulatedDisk::Luck;

constexpr std::size_t kCameras = 2;
constexpr std::array kAllLuck{Luck::nothing_stays, Luck::all_stays, Luck::names_stay, Luck::content_stays, Luck::zeros};

Timestamp stamp(std::size_t camera, int i) {
  return {1'700'000'000'000'000'000 + i * 100'000'000 + static_cast<int>(camera) * 30'000'000};
}
Pose pose(std::size_t camera, int i) {
  return {{1, 0, 0, 0}, {1.25 * i, 10.0 * static_cast<double>(camera), 0}};
}
cv::Mat picture(std::size_t camera, int i) {
  return patterned_picture(21, 13, i + 50 * static_cast<int>(camera));
}

/// A recording of two cameras, a part and joints: what is on the disk, and what was promised when.
struct Written {
  SimulatedDisk disk;
  std::filesystem::path root = "/nowhere/disk";
  struct Promise {
    std::size_t calls;
    int pictures;  ///< of each camera
  };
  std::vector<Promise> promises;
  std::string error;

  RecordingWriter::Description description() {
    RecordingWriter::Description result;
    result.name = "cut";
    CameraModel camera;
    camera.width = 21;
    camera.height = 13;
    camera.focal_length = {30, 30};
    camera.principal_point = {10, 6};
    result.cameras = {{"left", camera}, {"right", camera}};
    result.is_durable = true;
    result.disk = &disk;
    return result;
  }
  /// `pictures` of each camera, committed by two and three.
  void record(int pictures) try {
    RecordingWriter writer(root / "new/recording", description());
    writer.set_joint_names({"a"});
    int committed = 0;
    for (int i = 0; i < pictures; ++i) {
      for (std::size_t camera = 0; camera < kCameras; ++camera) {
        writer.add_camera_pose(camera, stamp(camera, i), pose(camera, i));
        writer.add_picture(camera, stamp(camera, i), picture(camera, i), "png");
      }
      writer.add_part_pose("arm", stamp(0, i) + Duration{-1'000'000}, Pose{{1, 0, 0, 0}, {0.0, 0.0, 1.0 * i}});
      writer.add_part_pose("arm", stamp(1, i), Pose{{1, 0, 0, 0}, {0.0, 0.0, 1.0 * i}});
      writer.add_joints(stamp(0, i), {1.0 * i});
      if (i % 5 != 1 && i % 5 != 4) continue;
      EXPECT_EQ(writer.commit(), kCameras * static_cast<std::size_t>(i + 1 - committed));
      committed = i + 1;
      promises.push_back({disk.calls(), committed});
    }
    writer.finish();
    promises.push_back({disk.calls(), pictures});
  } catch (const InputError& failure) {
    error = failure.what();
  }

  /// Cuts the power after so many calls and reads what is left. Returns the pictures found.
  std::size_t expect_sound_remainder(std::size_t calls, Luck luck, unsigned seed = 0) const {
    const TemporaryDirectory directory;
    disk.write_remainder(calls, luck, seed, root, directory.path());
    int promised = 0;
    for (const Promise& promise : promises) {
      if (promise.calls <= calls) promised = promise.pictures;
    }
    const std::filesystem::path at = directory / "new/recording";
    std::optional<Recording> recording;
    try {
      recording = Recording::open(at);
    } catch (const InputError& failure) {
      EXPECT_EQ(promised, 0) << failure.what();
      for (const char* camera : {"left", "right"}) expect_nothing_listed_that_is_not_there(at / camera);
      return 0;
    }
    // A line that was being written may be cut off, and is then dropped. Nothing else is amiss.
    const RecordingDamage& damage = recording->damage();
    const std::size_t cut_lines = luck == Luck::zeros || luck == Luck::random ? 6 : 0;
    EXPECT_LE(damage.lines_malformed + damage.pictures_missing, cut_lines);
    EXPECT_EQ(damage.total(), damage.lines_malformed + damage.pictures_missing);
    std::size_t found = 0;
    for (std::size_t camera = 0; camera < kCameras; ++camera) {
      const auto& entries = recording->cameras()[camera].pictures;
      EXPECT_GE(entries.size(), static_cast<std::size_t>(promised));
      for (std::size_t k = 0; k < entries.size(); ++k) {
        const int i = static_cast<int>(k);
        EXPECT_EQ(entries[k].stamp, stamp(camera, i));
        EXPECT_EQ(cv::norm(recording->read_picture(camera, k), picture(camera, i), cv::NORM_INF), 0);
        EXPECT_EQ(recording->cameras()[camera].world_from_camera.at(entries[k].stamp), pose(camera, i));
        EXPECT_TRUE(recording->part_trajectories().at("arm").at(entries[k].stamp));
      }
      found += entries.size();
    }
    return found;
  }
  static void expect_nothing_listed_that_is_not_there(const std::filesystem::path& camera) {
    std::ifstream list(camera / "rgb.txt");
    std::string line;
    while (std::getline(list, line)) {
      const std::size_t name = line.find("rgb/");
      // A name cut off is none.
      if (name == std::string::npos || !line.ends_with(".png")) continue;
      EXPECT_GT(std::filesystem::file_size(camera / line.substr(name)), 100U) << line;
    }
  }
};

TEST(DurableRecording, IsSoundWhereverThePowerIsCut) {
  Written written;
  written.record(7);
  ASSERT_EQ(written.error, "");
  ASSERT_EQ(written.promises.size(), 4U);
  std::size_t remainders = 0, most = 0;
  for (std::size_t calls = 0; calls <= written.disk.calls() && !HasFailure(); ++calls) {
    SCOPED_TRACE(calls);
    for (const Luck luck : kAllLuck) most = std::max(most, written.expect_sound_remainder(calls, luck)), ++remainders;
    for (unsigned seed = 0; seed < 2; ++seed, ++remainders) {
      written.expect_sound_remainder(calls, Luck::random, static_cast<unsigned>(calls) * 7 + seed);
    }
  }
  EXPECT_EQ(most, 14U);
  std::printf("%zu calls, %zu remainders read\n", written.disk.calls(), remainders);
  RecordProperty("cuts", static_cast<int>(written.disk.calls()));
  RecordProperty("remainders", static_cast<int>(remainders));
}

TEST(DurableRecording, IsSoundWhereverTheDiskIsFull) {
  Written whole;
  whole.record(5);
  for (std::size_t full = 0; full < whole.disk.calls() && !HasFailure(); ++full) {
    SCOPED_TRACE(full);
    Written written;
    written.disk.full_from = full;
    written.record(5);
    if (!written.error.empty()) {
      EXPECT_NE(written.error.find("No space left on device"), std::string::npos) << written.error;
      EXPECT_EQ(written.error.find('\n'), std::string::npos);
    }
    // As it is, and after a power cut on top of it.
    written.expect_sound_remainder(written.disk.calls(), Luck::all_stays);
    written.expect_sound_remainder(written.disk.calls(), Luck::nothing_stays);
  }
}

TEST(DurableRecording, ListsNothingMoreOnceSyncingHasFailed) {
  Written whole;
  whole.record(5);
  std::size_t failed = 0;
  for (std::size_t call = 0; call < whole.disk.calls() && !HasFailure(); ++call) {
    SCOPED_TRACE(call);
    Written written;
    written.disk.failing_sync = call;
    written.record(5);
    if (written.error.empty()) continue;
    ++failed;
    EXPECT_NE(written.error.find("Input/output error"), std::string::npos) << written.error;
    written.expect_sound_remainder(written.disk.calls(), Luck::nothing_stays);
    written.expect_sound_remainder(written.disk.calls(), Luck::names_stay);
  }
  EXPECT_GE(failed, 20U);
}

}  // namespace
}  // namespace foreview
