#include "foreview/recordings/builtin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "foreview/recordings/synthetic/arm.h"
#include "foreview/recordings/synthetic/renderer.h"
#include "foreview/recordings/synthetic/sensor_noise.h"
#include "foreview/recordings/synthetic/site_builder.h"
#include "foreview/scene/errors.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;

fs::path fresh_directory(const std::string& name) {
  const fs::path directory = fs::path(FOREVIEW_TEST_OUTPUT_DIR) / "builtin" / name;
  fs::remove_all(directory);
  fs::create_directories(directory.parent_path());
  return directory;
}

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// All files below a directory by relative name.
std::map<std::string, std::string> contents_of(const fs::path& directory) {
  std::map<std::string, std::string> result;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    if (entry.is_regular_file()) result[fs::relative(entry.path(), directory).string()] = bytes_of(entry.path());
  }
  return result;
}

CameraModel smaller(CameraModel camera, double factor) {
  camera.width = static_cast<int>(camera.width * factor);
  camera.height = static_cast<int>(camera.height * factor);
  camera.focal_length *= factor;
  camera.principal_point *= factor;
  return camera;
}

GenerateOptions tiny(const std::string& name) {
  GenerateOptions options;
  options.name = name;
  options.pictures = 2;
  options.scale = 0.12;
  return options;
}

/// The sites are expensive enough to make them once.
const SyntheticSite& workcell() {
  static const SyntheticSite site("workcell");
  return site;
}

TEST(BuiltinRecordings, WorkcellHasTheWorkloadOf2005) {
  const RawMesh& mesh = workcell().mesh();
  EXPECT_EQ(mesh.faces.size(), 1936U);
  EXPECT_EQ(workcell().instants(), 320U);
  EXPECT_EQ(workcell().camera_count(), 2U);
  EXPECT_EQ(workcell().camera(0).name, "left");
  EXPECT_EQ(workcell().camera(1).name, "right");
  EXPECT_EQ(workcell().camera(0).width, 751);
  EXPECT_EQ(workcell().camera(0).height, 570);
  EXPECT_EQ((workcell().stamp(1) - workcell().stamp(0)).nanoseconds, 40'000'000);
  EXPECT_EQ(mesh.part_names.size(), workcell().world_from_part(workcell().stamp(0)).size());
  for (const char* name : {"room", "link1", "link7", "finger_left", "finger_right", "workpiece"}) {
    EXPECT_EQ(std::count(mesh.part_names.begin(), mesh.part_names.end(), name), 1) << name;
  }
}

TEST(BuiltinRecordings, ModelsSurviveTheImportWhole) {
  const std::map<std::string, std::size_t> polygons{{"workcell", 1936}, {"object", 139}, {"cube", 6}};
  for (const auto& [name, expected] : polygons) {
    ImportOptions options;
    options.merge_coplanar = false;
    options.backdrop = false;
    ImportReport report;
    const SyntheticSite site(name);
    const PolygonModel model = build_polygon_model(site.mesh(), options, &report, name);
    EXPECT_EQ(model.polygons().size(), expected) << name;
    EXPECT_EQ(report.faces_split_not_planar + report.faces_split_concave, 0U) << name;
    EXPECT_EQ(report.faces_degenerate + report.faces_duplicate, 0U) << name;
    EXPECT_EQ(report.edges_with_opposed_winding, 0U) << name;
    EXPECT_EQ(report.boundary_edges, 0U) << name;
  }
}

TEST(BuiltinRecordings, PicturesShowAsManyPolygonsAsIn2005) {
  std::size_t fewest = 10'000, most = 0;
  for (std::size_t i = 0; i < 320; i += 8) {
    const Timestamp stamp = workcell().stamp(i);
    const std::size_t seen =
        workcell().visible_polygons(workcell().camera(0), workcell().world_from_camera(0, stamp), stamp).size();
    EXPECT_GE(seen, 15U) << "picture " << i;
    EXPECT_LE(seen, 344U) << "picture " << i;
    fewest = std::min(fewest, seen);
    most = std::max(most, seen);
  }
  EXPECT_LE(fewest, 30U);
  EXPECT_GE(most, 300U);
}

TEST(BuiltinRecordings, DelayedPicturesAreHardAndPointsMoveFar) {
  const CameraModel camera = smaller(workcell().camera(0), 0.4);
  double sum = 0;
  int count = 0;
  for (std::size_t i = 20; i < 320; i += 30) {
    const Timestamp now = workcell().stamp(i), before = workcell().stamp(i - 13);
    const Pose here = workcell().world_from_camera(0, now), there = workcell().world_from_camera(0, before);
    sum += cv::PSNR(workcell().render(camera, here, now), workcell().render(camera, there, before));
    ++count;
  }
  EXPECT_GE(sum / count, 12.0);
  EXPECT_LE(sum / count, 16.0);
  // The point two metres ahead, at every instant: at least 20 pixels, but for moments of return.
  int far = 0, all = 0;
  for (std::size_t i = 13; i < 320; ++i, ++all) {
    const Pose here = workcell().world_from_camera(0, workcell().stamp(i));
    const Pose there = workcell().world_from_camera(0, workcell().stamp(i - 13));
    const glm::dvec3 seen_before = there.inverse() * (here * glm::dvec3(0, 0, 2));
    const glm::dvec2 way = workcell().camera(0).pixel_from_camera({seen_before.x, seen_before.y, 2}) -
                           workcell().camera(0).pixel_from_camera({0, 0, 2});
    far += glm::length(way) >= 20 ? 1 : 0;
  }
  EXPECT_GE(far, all * 90 / 100);
}

// A cube of one colour before black: its area's centre and its rim say where the renderer puts corners.
TEST(BuiltinRecordings, RendererPutsCornersWhereTheCameraModelDoes) {
  synthetic::Site site;
  synthetic::SiteBuilder builder(site);
  const std::uint32_t part = builder.part("squares", false);
  const std::uint32_t lamp = builder.surface({synthetic::Material::lamp, {1, 1, 1}, {0, 0, 0}, 0, ""});
  const std::vector<glm::dvec2> places{{-0.85, -0.62}, {0.80, -0.58}, {-0.78, 0.60}, {0.82, 0.61}, {0, 0}};
  constexpr double kHalf = 0.06, kDistance = 1.6;
  for (const glm::dvec2& at : places) {
    builder.box(part, synthetic::placed({at.x, kDistance + kHalf, -at.y}), glm::dvec3(2 * kHalf), lamp);
  }
  // A lamp is shown 1.6 times as bright as its light: here exactly white.
  site.lights.push_back(
      {{0, 0, 3}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, -1}, {1, 1, 1}, 1, [](double) { return 1 / 1.6; }});
  site.ambient_over_time = [](double) { return 1.0; };
  site.world_from_part = [](double) { return std::vector<Pose>(1); };
  const synthetic::Renderer renderer(site);
  const CameraModel& camera = workcell().camera(0);
  const Pose world_from_camera = looking_at({0, 0, 0}, {0, 1, 0}, {0, 0, 1});
  const cv::Mat picture = renderer.render(camera, world_from_camera, 0);
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  for (const glm::dvec2& at : places) {
    // All faces but the front one are hidden or foreshortened: take the outline of the whole box.
    std::vector<cv::Point2f> corners;
    for (int k = 0; k < 8; ++k) {
      const glm::dvec3 p{at.x + ((k & 1) != 0 ? kHalf : -kHalf), at.y + ((k & 2) != 0 ? kHalf : -kHalf),
                         kDistance + ((k & 4) != 0 ? 2 * kHalf : 0)};
      const glm::dvec2 pixel = camera.pixel_from_camera(p);
      corners.emplace_back(static_cast<float>(pixel.x), static_cast<float>(pixel.y));
    }
    std::vector<cv::Point2f> outline;
    cv::convexHull(corners, outline);
    const cv::Moments expected = cv::moments(outline);
    const cv::Rect around(static_cast<int>(expected.m10 / expected.m00) - 45,
                          static_cast<int>(expected.m01 / expected.m00) - 45, 90, 90);
    cv::Mat patch;
    grey(around).convertTo(patch, CV_64F, 1.0 / 255);
    double mass = 0, mx = 0, my = 0;
    for (int y = 0; y < patch.rows; ++y) {
      for (int x = 0; x < patch.cols; ++x) {
        const double v = patch.at<double>(y, x);
        mass += v;
        mx += v * (around.x + x + 0.5);
        my += v * (around.y + y + 0.5);
      }
    }
    EXPECT_NEAR(mx / mass, expected.m10 / expected.m00, 0.05);
    EXPECT_NEAR(my / mass, expected.m01 / expected.m00, 0.05);
    // An outline that is off by 0.05 px all around changes the area by 0.05 times its length.
    EXPECT_NEAR(mass, expected.m00, 0.05 * cv::arcLength(outline, true));
  }
}

TEST(BuiltinRecordings, SameOptionsGiveTheSameBytes) {
  const fs::path first = fresh_directory("same-1"), second = fresh_directory("same-2");
  generate_recording(tiny("workcell"), first);
  generate_recording(tiny("workcell"), second);
  EXPECT_EQ(contents_of(first), contents_of(second));
}

TEST(BuiltinRecordings, LaterPicturesDoNotDependOnWhereOneBegins) {
  const fs::path all = fresh_directory("all"), later = fresh_directory("later");
  GenerateOptions options = tiny("workcell");
  generate_recording(options, all);
  options.pictures = 1;
  options.first_picture = 1;
  generate_recording(options, later);
  const Recording whole = Recording::open(all), part = Recording::open(later);
  ASSERT_EQ(part.cameras()[1].pictures.size(), 1U);
  EXPECT_EQ(part.cameras()[1].pictures[0].stamp, whole.cameras()[1].pictures[1].stamp);
  EXPECT_EQ(bytes_of(part.cameras()[1].pictures[0].file), bytes_of(whole.cameras()[1].pictures[1].file));
}

TEST(BuiltinRecordings, WrittenRecordingsReadBackWhole) {
  for (const std::string& name : builtin_recording_names()) {
    const fs::path directory = fresh_directory("read-" + name);
    generate_recording(tiny(name), directory);
    const Recording recording = Recording::open(directory);
    EXPECT_EQ(recording.damage().total(), 0U) << name;
    ASSERT_TRUE(recording.scene_file().has_value());
    const PolygonModel model = import_model(*recording.scene_file(), recording.import_options());
    const SyntheticSite site(name);
    const Timestamp stamp = recording.cameras()[0].pictures[1].stamp;
    const auto state = recording.capture_state(0, stamp, model);
    ASSERT_TRUE(state.has_value()) << name;
    EXPECT_LT(glm::length(state->world_from_camera.translation - site.world_from_camera(0, stamp).translation), 1e-9);
    const std::vector<Pose> truth = site.world_from_part(stamp);
    for (std::size_t p = 0; p < site.mesh().part_names.size(); ++p) {
      const int index = model.part_index(site.mesh().part_names[p]);
      ASSERT_GE(index, 0) << site.mesh().part_names[p];
      const Pose& said = state->world_from_part[static_cast<std::size_t>(index)];
      EXPECT_LT(glm::length(said.translation - truth[p].translation), 1e-9) << site.mesh().part_names[p];
      EXPECT_LT(angle_between(said, truth[p]), 1e-7) << site.mesh().part_names[p];
    }
  }
}

TEST(SensorNoise, HasItsStrengthAndSharesWhatItShould) {
  cv::Mat picture(200, 300, CV_8UC3, cv::Scalar::all(128));
  synthetic::add_sensor_noise(picture, 2.4, 0.5, 7);
  cv::Scalar mean, sigma;
  cv::meanStdDev(picture, mean, sigma);
  double together = 0;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const auto& pixel = picture.at<cv::Vec3b>(y, x);
      together += (pixel[0] - mean[0]) * (pixel[2] - mean[2]);
    }
  }
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(mean[c], 128, 0.05);
    // Rounding to whole values adds 1/12 to the variance.
    EXPECT_NEAR(sigma[c], std::sqrt(2.4 * 2.4 + 1.0 / 12), 0.05);
  }
  EXPECT_NEAR(together / static_cast<double>(picture.total()), 0.5 * 2.4 * 2.4, 0.1);
  cv::Mat other(200, 300, CV_8UC3, cv::Scalar::all(128));
  synthetic::add_sensor_noise(other, 2.4, 0.5, 8);
  EXPECT_GT(cv::norm(picture, other, cv::NORM_L2), 3 * std::sqrt(60'000.0 * 3));
}

TEST(BuiltinRecordings, PicturesOnDiskAreNoisyStill) {
  GenerateOptions options = tiny("workcell");
  options.pictures = 1;
  options.scale = 0.5;
  const fs::path directory = fresh_directory("noise");
  generate_recording(options, directory);
  const Recording recording = Recording::open(directory);
  const Timestamp stamp = recording.cameras()[0].pictures[0].stamp;
  const cv::Mat truth = workcell().render(recording.cameras()[0].model, workcell().world_from_camera(0, stamp), stamp);
  cv::Mat difference;
  cv::subtract(recording.read_picture(0, 0), truth, difference, cv::noArray(), CV_16S);
  for (int c = 0; c < 3; ++c) {
    // The median of the magnitude: JPEG's errors at coloured edges are large, but few.
    std::vector<int> magnitudes;
    double sum = 0;
    for (int y = 0; y < difference.rows; ++y) {
      for (int x = 0; x < difference.cols; ++x) {
        const int d = difference.at<cv::Vec3s>(y, x)[c];
        // A tie-breaking fraction of whole numbers: 100 d plus something spread over one step.
        magnitudes.push_back(std::abs(100 * d + (x * 37 + y * 61) % 100 - 50));
        sum += d;
      }
    }
    std::nth_element(magnitudes.begin(), magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2),
                     magnitudes.end());
    const double sigma = magnitudes[magnitudes.size() / 2] / 100.0 * 1.4826;
    EXPECT_NEAR(sum / static_cast<double>(magnitudes.size()), 0, 0.2);
    EXPECT_GE(sigma, 2.0);
    EXPECT_LE(sigma, 6.0);
  }
}

TEST(BuiltinRecordings, WorkpieceRidesInTheGripperAndStaysWhereItIsPut) {
  const auto& names = workcell().mesh().part_names;
  const auto index = [&](const char* name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const auto at = [&](double t) { return workcell().world_from_part(workcell().stamp(0) + Duration::from_seconds(t)); };
  const std::size_t hand = index("link7"), workpiece = index("workpiece");
  const std::vector<Pose> gripped = at(3.0);
  const Pose hand_from_workpiece = gripped[hand].inverse() * gripped[workpiece];
  double highest = 0;
  for (int tenths = 30; tenths <= 71; ++tenths) {
    const double t = tenths * 0.1;
    const std::vector<Pose> poses = at(t);
    const Pose now = poses[hand].inverse() * poses[workpiece];
    EXPECT_LT(glm::length(now.translation - hand_from_workpiece.translation), 1e-9) << t;
    EXPECT_LT(angle_between(now, hand_from_workpiece), 1e-7) << t;
    highest = std::max(highest, poses[workpiece].translation.z - gripped[workpiece].translation.z);
  }
  EXPECT_GT(highest, 0.25);
  EXPECT_EQ(at(0.0)[workpiece], at(2.8)[workpiece]);
  EXPECT_EQ(at(8.0)[workpiece], at(12.7)[workpiece]);
  EXPECT_NEAR(at(12.7)[workpiece].translation.z, at(0.0)[workpiece].translation.z, 1e-9);
}

TEST(BuiltinRecordings, JointAnglesReachTheirPosesAndNeverJump) {
  const fs::path directory = fresh_directory("joints");
  GenerateOptions options = tiny("workcell");
  options.pictures.reset();
  options.scale = 0.02;
  generate_recording(options, directory);
  const Recording recording = Recording::open(directory);
  ASSERT_EQ(recording.joints().names.size(), 8U);
  ASSERT_EQ(recording.joints().positions.size(), 320U);
  const auto& names = workcell().mesh().part_names;
  const auto link = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  for (std::size_t i = 0; i < 320; ++i) {
    const std::vector<double>& q = recording.joints().positions[i];
    for (std::size_t k = 0; k < 7 && i > 0; ++k) {
      EXPECT_LT(std::abs(q[k] - recording.joints().positions[i - 1][k]), 0.25) << "joint " << k + 1 << " at " << i;
    }
    synthetic::arm::JointAngles angles{};
    std::copy(q.begin(), q.begin() + 7, angles.begin());
    const auto links = synthetic::arm::base_from_links(angles);
    const std::vector<Pose> truth = workcell().world_from_part(recording.joints().stamps[i]);
    const Pose said = links[0].inverse() * links[6];
    const Pose wanted = truth[link("link1")].inverse() * truth[link("link7")];
    EXPECT_LT(glm::length(said.translation - wanted.translation), 1e-9);
    EXPECT_LT(angle_between(said, wanted), 1e-6);
  }
}

TEST(BuiltinRecordings, InjectedErrorsFalsifyWhatIsSaidAndNotThePictures) {
  const fs::path exact = fresh_directory("exact"), wrong = fresh_directory("wrong");
  GenerateOptions options = tiny("workcell");
  generate_recording(options, exact);
  options.errors = {1.0, 8.0, 2.0, 10.0, 15.0};
  generate_recording(options, wrong);
  const Recording truth = Recording::open(exact), said = Recording::open(wrong);
  EXPECT_EQ(bytes_of(truth.cameras()[0].pictures[1].file), bytes_of(said.cameras()[0].pictures[1].file));
  const Pose a = truth.cameras()[0].world_from_camera.samples()[1].pose;
  const Pose b = said.cameras()[0].world_from_camera.samples()[1].pose;
  EXPECT_NEAR(angle_between(a, b), 1.0 * M_PI / 180, 1e-7);
  EXPECT_NEAR(glm::length(a.translation - b.translation), 0.008, 1e-9);
  const CameraModel &lens = truth.cameras()[0].model, &falsified = said.cameras()[0].model;
  EXPECT_NEAR(falsified.focal_length.x / lens.focal_length.x, 1.02, 1e-9);
  EXPECT_NEAR(falsified.distortion[0] / lens.distortion[0], 1.10, 1e-9);
  const RawMesh exact_mesh = read_mesh(*truth.scene_file()), wrong_mesh = read_mesh(*said.scene_file());
  ASSERT_EQ(exact_mesh.vertices.size(), wrong_mesh.vertices.size());
  std::size_t moved = 0, kept = 0;
  for (std::size_t v = 0; v < exact_mesh.vertices.size(); ++v) {
    const double by = glm::length(exact_mesh.vertices[v] - wrong_mesh.vertices[v]);
    if (by < 1e-9) {
      ++kept;
    } else {
      EXPECT_NEAR(by, 0.015, 1e-6);
      ++moved;
    }
  }
  EXPECT_GT(moved, 500U);  // objects
  EXPECT_GT(kept, 300U);   // the room
}

TEST(BuiltinRecordings, InterruptedGenerationIsRedoneAndForeignFilesAreLeftAlone) {
  const fs::path directory = fresh_directory("interrupted"), whole = fresh_directory("whole");
  const auto stop = [](std::size_t done, std::size_t) {
    if (done == 2) throw Interrupted();
  };
  EXPECT_THROW(generate_recording(tiny("cube"), directory, stop), Interrupted);
  generate_recording(tiny("cube"), directory);
  generate_recording(tiny("cube"), whole);
  EXPECT_EQ(contents_of(directory), contents_of(whole));

  GenerateOptions other = tiny("cube");
  other.pictures = 1;
  EXPECT_THROW(generate_recording(other, directory), InputError);
  EXPECT_EQ(contents_of(directory), contents_of(whole));
  const fs::path foreign = fresh_directory("foreign");
  fs::create_directories(foreign);
  std::ofstream(foreign / "thesis.txt") << "years of work";
  EXPECT_THROW(generate_recording(tiny("cube"), foreign), InputError);
  EXPECT_EQ(bytes_of(foreign / "thesis.txt"), "years of work");
}

TEST(BuiltinRecordings, CacheMakesARecordingOnce) {
  const fs::path cache = fresh_directory("cache");
  ASSERT_EQ(setenv("FOREVIEW_CACHE", cache.c_str(), 1), 0);
  std::size_t calls = 0;
  const auto count = [&](std::size_t, std::size_t) { ++calls; };
  const fs::path first = cached_recording(tiny("cube"), count);
  EXPECT_GT(calls, 0U);
  calls = 0;
  EXPECT_EQ(cached_recording(tiny("cube"), count), first);
  EXPECT_EQ(calls, 0U);
  GenerateOptions other = tiny("cube");
  other.errors.pose_degrees = 1;
  EXPECT_NE(cached_recording(other), first);
  unsetenv("FOREVIEW_CACHE");
}

TEST(BuiltinRecordings, ImpossibleOptionsAreRefused) {
  const auto refused = [](const std::function<void(GenerateOptions&)>& spoil) {
    GenerateOptions options = tiny("cube");
    spoil(options);
    EXPECT_THROW(generate_recording(options, fresh_directory("refused")), InputError);
  };
  refused([](GenerateOptions& o) { o.name = "kitchen"; });
  refused([](GenerateOptions& o) { o.scale = std::nan(""); });
  refused([](GenerateOptions& o) { o.scale = 0; });
  refused([](GenerateOptions& o) { o.pictures = 0; });
  refused([](GenerateOptions& o) { o.first_picture = 80; });
  refused([](GenerateOptions& o) { o.errors.focal_length_percent = -100; });
  refused([](GenerateOptions& o) { o.errors.pose_degrees = INFINITY; });
}

}  // namespace
}  // namespace foreview
