#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "foreview/scene/camera_model.h"
#include "foreview/scene/errors.h"
#include "support/temporary_directory.h"

namespace foreview {
namespace {

const std::string kRos =
    "image_width: 640\n"
    "image_height: 480\n"
    "camera_name: head_left\n"
    "camera_matrix:\n"
    "  rows: 3\n"
    "  cols: 3\n"
    "  data: [525.5, 0, 319.5, 0, 526.25, 239.5, 0, 0, 1]\n"
    "distortion_model: plumb_bob\n"
    "distortion_coefficients: {rows: 1, cols: 5, data: [0.1, -0.2, 0.001, -0.002, 0.03]}\n"
    "rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n"
    "projection_matrix: {rows: 3, cols: 4, data: [500, 0, 1, 0, 0, 500, 1, 0, 0, 0, 1, 0]}\n";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

std::string error_of(const std::string& text) {
  try {
    static_cast<void>(parse_camera_yaml(text, "camera.yaml"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(CameraYaml, ReadsRosAndMovesThePrincipalPointByHalfAPixel) {
  const CameraModel camera = parse_camera_yaml(kRos, "camera.yaml");
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.height, 480);
  EXPECT_EQ(camera.name, "head_left");
  EXPECT_EQ(camera.focal_length, glm::dvec2(525.5, 526.25));
  EXPECT_EQ(camera.principal_point, glm::dvec2(320, 240));
  EXPECT_EQ(camera.distortion_model, DistortionModel::plumb_bob);
  const std::array<double, 8> expected{0.1, -0.2, 0.001, -0.002, 0.03, 0, 0, 0};
  EXPECT_EQ(camera.distortion, expected);
}

TEST(CameraYaml, ReadsOpenCvsOwnFiles) {
  const CameraModel camera = parse_camera_yaml(
      "%YAML:1.0\n"
      "---\n"
      "image_width: 751\n"
      "image_height: 570\n"
      "camera_matrix: !!opencv-matrix\n"
      "   rows: 3\n"
      "   cols: 3\n"
      "   dt: d\n"
      "   data: [ 8.0e+02, 0., 3.75e+02, 0., 8.1e+02, 2.845e+02, 0., 0., 1. ]\n"
      "distortion_coefficients: !!opencv-matrix\n"
      "   rows: 5\n"
      "   cols: 1\n"
      "   dt: d\n"
      "   data: [ -2.5e-01, 1.0e-01, 0., 0., 0. ]\n",
      "out_camera_data.yml");
  EXPECT_EQ(camera.principal_point, glm::dvec2(375.5, 285));
  EXPECT_EQ(camera.focal_length, glm::dvec2(800, 810));
  EXPECT_EQ(camera.distortion_model, DistortionModel::plumb_bob);
  EXPECT_EQ(camera.distortion[0], -0.25);
}

TEST(CameraYaml, ReadsWhatRostopicEchoPrints) {
  const CameraModel camera = parse_camera_yaml(
      "header:\n  seq: 5\n  stamp:\n    secs: 1\n    nsecs: 2\n  frame_id: \"cam\"\n"
      "height: 480\nwidth: 640\ndistortion_model: \"equidistant\"\n"
      "D: [0.1, 0.01, 0.0, 0.0]\n"
      "K: [300.0, 0.0, 320.0, 0.0, 300.0, 240.0, 0.0, 0.0, 1.0]\n"
      "R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\n"
      "binning_x: 0\nbinning_y: 0\nroi:\n  x_offset: 0\n  y_offset: 0\n  height: 0\n  width: 0\n  do_rectify: False\n"
      "---\n",
      "echo.yaml");
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.distortion_model, DistortionModel::fisheye);
  EXPECT_EQ(camera.distortion[1], 0.01);
}

TEST(CameraYaml, ReadsRowsOfAMatrixAndRationalCoefficients) {
  std::string text = replaced(kRos, "[525.5, 0, 319.5, 0, 526.25, 239.5, 0, 0, 1]",
                              "[[525.5, 0, 319.5], [0, 526.25, 239.5], [0, 0, 1]]");
  text = replaced(text, "plumb_bob", "rational_polynomial");
  text = replaced(text, "[0.1, -0.2, 0.001, -0.002, 0.03]", "[1, 2, 3, 4, 5, 6, 7, 8, 0, 0, 0, 0]");
  const CameraModel camera = parse_camera_yaml(text, "camera.yaml");
  EXPECT_EQ(camera.focal_length, glm::dvec2(525.5, 526.25));
  EXPECT_EQ(camera.distortion[7], 8);
}

TEST(CameraYaml, WithoutAnyDistortionKeyThereIsNone) {
  const CameraModel camera =
      parse_camera_yaml("image_width: 1\nimage_height: 1\ncamera_matrix: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n", "camera.yaml");
  EXPECT_EQ(camera.distortion_model, DistortionModel::none);
  EXPECT_EQ(camera.width, 1);
}

TEST(CameraYaml, WritesWhatItReadsBackExactly) {
  CameraModel camera;
  camera.width = 751;
  camera.height = 570;
  camera.focal_length = {1.0 / 3 * 2000, 812.3456789012345};
  camera.principal_point = {375.123456789, 285.987654321};
  camera.name = "left \"eye\": \\ #1 ü";
  for (const DistortionModel model : {DistortionModel::none, DistortionModel::plumb_bob, DistortionModel::fisheye}) {
    for (const std::size_t used : {4U, 5U, 8U}) {
      camera.distortion_model = model;
      camera.distortion.fill(0);
      if (model == DistortionModel::fisheye && used > 4) continue;
      for (std::size_t i = 0; i < used && model != DistortionModel::none; ++i) {
        camera.distortion[i] = 0.1 / (3.0 + static_cast<double>(i));
      }
      const CameraModel read = parse_camera_yaml(to_camera_yaml(camera), "written");
      EXPECT_EQ(read.width, camera.width);
      EXPECT_EQ(read.height, camera.height);
      EXPECT_EQ(read.focal_length, camera.focal_length);
      EXPECT_NEAR(read.principal_point.x, camera.principal_point.x, 1e-12);
      EXPECT_NEAR(read.principal_point.y, camera.principal_point.y, 1e-12);
      EXPECT_EQ(read.distortion_model, camera.distortion_model);
      EXPECT_EQ(read.distortion, camera.distortion);
      EXPECT_EQ(read.name, camera.name);
    }
  }
}

TEST(CameraYaml, NamesFileLineAndKeyOfWhatIsWrong) {
  EXPECT_EQ(error_of(replaced(kRos, "640", "wide")), "camera.yaml:1: image_width: expected a number, not 'wide'");
  const struct {
    const char *what, *by, *message;
  } cases[] = {
      {"image_width: 640\n", "", "image_width: is missing"},
      {"640", "0", "image_width: is 0; expected 1 to 16384"},
      {"640", "20000", "image_width: is 20000"},
      {"640", "640.5", "image_width: expected a whole number"},
      {"640", ".nan", "image_width: expected a number"},
      {"640", "[640]", "image_width: expected a number"},
      {"525.5", "0", "focal lengths are 0"},
      {"525.5", "-525", "focal lengths are -525"},
      {"525.5", "nan", "expected finite numbers"},
      {"525.5", "inf", "expected finite numbers"},
      {"525.5", "1e99", "focal lengths are 1e+99"},
      {"525.5, 0,", "525.5, 0.5,", "without skew"},
      {"319.5", "-1e300", "principal point"},
      {", 0, 0, 1]", ", 0, 0]", "has 8 numbers; expected 9"},
      {"data: [525.5", "dota: [525.5", "camera_matrix: expected 'data'"},
      {"plumb_bob", "barrel", "distortion_model: is 'barrel'; expected plumb_bob"},
      {"plumb_bob", "equidistant", "equidistant needs 4 coefficients; 5 are given"},
      {"plumb_bob", "none", "distortion_model is none"},
      {", 0.03]", "]", ""},
      {"-0.002, 0.03]", "1]", ""},
      {"0.001, -0.002, 0.03]", "0.001]", "needs 4, 5 or 8 coefficients; 3 are given"},
      {"0.03]", "0.03, 0, 0]", "7 are given"},
      {"0.03]", "0.03, 0, 0, 0, 1, 0, 0, 0]", "12 are given"},
      {"-0.2", "nan", "expected finite numbers"},
      {"-0.2", "1e200", "which no lens has"},
      {"camera_name: head_left", "binning_x: 2", "binned pictures are not supported"},
      {"camera_name: head_left", "roi: {x_offset: 10}", "cut-out pictures are not supported"},
  };
  for (const auto& c : cases) {
    const std::string message = error_of(replaced(kRos, c.what, c.by));
    EXPECT_NE(message.find(c.message), std::string::npos) << c.by << " gives: " << message;
    EXPECT_EQ(message.empty(), c.message[0] == '\0') << c.by << " gives: " << message;
  }
}

TEST(CameraYaml, RefusesWhatIsNoYamlInOneLine) {
  const std::string deep_list(5000, '[');
  const std::string deep_map = [] {
    std::string text;
    for (int i = 0; i < 300; ++i) text += std::string(static_cast<std::size_t>(i) % 150, ' ') + "a:\n";
    return text;
  }();
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string last = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + last + ", " + last + ", " + last + "]\n";
  }
  bomb += "camera_matrix: *a29\nimage_width: 1\nimage_height: 1\n";
  const std::string cycle = "a: &a [*a]\nimage_width: *a\n";
  const std::string garbage("\x00\xff\x80\x01 \x9f{[:&*", 11);
  for (const std::string& text :
       {deep_list, deep_map, bomb, cycle, garbage, std::string("- 1\n- 2\n"), std::string("just words"), std::string(),
        std::string(100000, 'a'), std::string("image_width: &x 1\n*x : 2\n"), std::string("? [a, b]\n: 1\n")}) {
    const std::string message = error_of(text);
    EXPECT_EQ(message.substr(0, 11), "camera.yaml") << text.substr(0, 40);
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(CameraYaml, MessagesStayOneLineWhateverTheFileHolds) {
  for (const char* text : {"a: \"\\\x02\"", "image_width: \"\\\n\"", "camera_name: \"\\q\"", "a: \x91\xff\"\\\n"}) {
    for (const char c : error_of(text)) EXPECT_TRUE(c >= 0x20 && c < 0x7f) << error_of(text);
  }
}

TEST(CameraYaml, ReadsFilesAndNamesThem) {
  const test::TemporaryDirectory directory;
  EXPECT_EQ(read_camera_yaml(directory.write("camera.yaml", kRos)).width, 640);
  for (const char* name : {"nowhere.yaml", "."}) {
    try {
      static_cast<void>(read_camera_yaml(directory / name));
      ADD_FAILURE() << name;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find((directory / name).string()), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace foreview
