#include <cmath>
#include <optional>
#include <vector>

#include "foreview/scene/camera_model.h"
#include "foreview/scene/input_file.h"
#include "foreview/scene/yaml_input.h"

namespace foreview {
namespace {

constexpr int kLargestSide = 16384;    // pixels; what graphics drivers take as a texture
constexpr double kLargestPixel = 1e7;  // pixels; beyond this a focal length or principal point is a misread file

// OpenCV and ROS count from the centre of the upper left pixel, we from its corner.
constexpr double kPixelCentre = 0.5;

int read_side(const YamlMap& yaml, std::initializer_list<const char*> names) {
  const std::string key = yaml.first_of(names);
  const std::optional<int> side = yaml.integer(key, 1, kLargestSide);
  if (!side) yaml.fail(key, "is missing; expected the picture's size in pixels");
  return *side;
}

void read_camera_matrix(const YamlMap& yaml, CameraModel& camera) {
  const std::string key = yaml.first_of({"camera_matrix", "Camera_Matrix", "K", "k"});
  const std::optional<std::vector<double>> k = yaml.matrix(key);
  if (!k) yaml.fail(key, "is missing; expected data: [fx, 0, cx, 0, fy, cy, 0, 0, 1]");
  if (k->size() != 9) yaml.fail(key, "has " + std::to_string(k->size()) + " numbers; expected 9");
  const auto at = [&](std::size_t row, std::size_t column) { return (*k)[row * 3 + column]; };
  if (!(at(0, 0) > 0 && at(0, 0) <= kLargestPixel && at(1, 1) > 0 && at(1, 1) <= kLargestPixel)) {
    yaml.fail(key, "focal lengths are " + number_text(at(0, 0)) + " and " + number_text(at(1, 1)) +
                       "; expected pixels, greater than 0");
  }
  if (at(0, 1) != 0 || at(1, 0) != 0 || at(2, 0) != 0 || at(2, 1) != 0 || at(2, 2) != 1) {
    yaml.fail(key, "expected [fx, 0, cx, 0, fy, cy, 0, 0, 1], without skew");
  }
  if (!(std::abs(at(0, 2)) <= kLargestPixel && std::abs(at(1, 2)) <= kLargestPixel)) {
    yaml.fail(key, "the principal point is " + number_text(at(0, 2)) + ", " + number_text(at(1, 2)) +
                       "; expected pixels of the picture");
  }
  camera.focal_length = {at(0, 0), at(1, 1)};
  camera.principal_point = {at(0, 2) + kPixelCentre, at(1, 2) + kPixelCentre};
}

void read_distortion(const YamlMap& yaml, CameraModel& camera) {
  constexpr double kLargestCoefficient = 1e9;
  const std::string key = yaml.first_of({"distortion_coefficients", "Distortion_Coefficients", "D", "d"});
  const std::vector<double> coefficients = yaml.matrix(key).value_or(std::vector<double>());
  // OpenCV's own files hold coefficients without naming a model: they are of its standard one.
  const std::string model_key = "distortion_model";
  std::string model = yaml.text(model_key).value_or("");
  if (model.empty()) model = coefficients.empty() ? "none" : "plumb_bob";

  std::size_t used = coefficients.size();
  while (used > 0 && coefficients[used - 1] == 0) --used;
  for (const double k : coefficients) {
    if (!(std::abs(k) <= kLargestCoefficient)) yaml.fail(key, "holds " + number_text(k) + ", which no lens has");
  }
  const auto expect = [&](const char* counts, bool right) {
    if (right) return;
    yaml.fail(coefficients.empty() ? model_key : key,
              model + " needs " + counts + " coefficients; " + std::to_string(coefficients.size()) + " are given");
  };
  if (model == "none") {
    if (used != 0) yaml.fail(key, "are given, but distortion_model is none");
    return;
  }
  if (model == "plumb_bob" || model == "rational_polynomial") {
    // 12 and 14 are OpenCV's thin prism and tilted sensor: readable only where those are zero.
    const std::size_t n = coefficients.size();
    expect("4, 5 or 8", n == 4 || n == 5 || n == 8 || ((n == 12 || n == 14) && used <= 8));
    camera.distortion_model = DistortionModel::plumb_bob;
  } else if (model == "equidistant" || model == "fisheye") {
    expect("4", coefficients.size() == 4);
    camera.distortion_model = DistortionModel::fisheye;
  } else {
    yaml.fail(model_key, "is " + in_quotes(model) +
                             "; expected plumb_bob, rational_polynomial, equidistant (or fisheye), or none");
  }
  for (std::size_t i = 0; i < used; ++i) camera.distortion[i] = coefficients[i];
}

/// camera_info messages may say that pictures are binned or cut out; their intrinsics are those of the full picture.
void refuse_partial_pictures(const YamlMap& yaml) {
  for (const char* key : {"binning_x", "binning_y"}) {
    if (yaml.number(key, 0, 1e9).value_or(0) > 1) {
      yaml.fail(key, "binned pictures are not supported; give the intrinsics of the pictures as they are");
    }
  }
  const std::optional<YamlMap> roi = yaml.has("roi") ? yaml.map("roi") : std::nullopt;
  if (!roi) return;
  for (const char* key : {"x_offset", "y_offset"}) {
    if (roi->number(key, 0, 1e9).value_or(0) != 0) {
      roi->fail(key, "cut-out pictures are not supported; give the intrinsics of the pictures as they are");
    }
  }
}

}  // namespace

CameraModel parse_camera_yaml(const std::string& text, const std::string& where) {
  const YamlMap yaml = YamlMap::parse(text, where);
  CameraModel camera;
  camera.width = read_side(yaml, {"image_width", "image_Width", "width"});
  camera.height = read_side(yaml, {"image_height", "image_Height", "height"});
  read_camera_matrix(yaml, camera);
  read_distortion(yaml, camera);
  refuse_partial_pictures(yaml);
  camera.name = yaml.text("camera_name").value_or("");
  return camera;
}

CameraModel read_camera_yaml(const std::filesystem::path& file) {
  return parse_camera_yaml(read_input_file(file, YamlMap::kMaxBytes), file.string());
}

std::string to_camera_yaml(const CameraModel& camera) {
  const auto list = [](const std::vector<double>& numbers) {
    std::string result;
    for (const double number : numbers) result += (result.empty() ? "" : ", ") + number_text(number);
    return "[" + result + "]";
  };
  const glm::dvec2 f = camera.focal_length;
  const glm::dvec2 c = camera.principal_point - glm::dvec2(kPixelCentre);
  std::string yaml;
  yaml += "image_width: " + std::to_string(camera.width) + "\n";
  yaml += "image_height: " + std::to_string(camera.height) + "\n";
  yaml += "camera_name: " + yaml_quoted(camera.name) + "\n";
  yaml += "camera_matrix: {rows: 3, cols: 3, data: " + list({f.x, 0, c.x, 0, f.y, c.y, 0, 0, 1}) + "}\n";
  if (camera.distortion_model == DistortionModel::none) return yaml + "distortion_model: none\n";

  const std::array<double, 8>& d = camera.distortion;
  std::string model = "plumb_bob";
  std::size_t count = 5;
  if (camera.distortion_model == DistortionModel::fisheye) {
    model = "equidistant";
    count = 4;
  } else if (d[5] != 0 || d[6] != 0 || d[7] != 0) {
    model = "rational_polynomial";
    count = 8;
  }
  yaml += "distortion_model: " + model + "\n";
  yaml += "distortion_coefficients: {rows: 1, cols: " + std::to_string(count) +
          ", data: " + list(std::vector<double>(d.begin(), d.begin() + static_cast<std::ptrdiff_t>(count))) + "}\n";
  return yaml;
}

}  // namespace foreview
