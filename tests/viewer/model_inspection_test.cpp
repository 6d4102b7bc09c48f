#include "foreview/viewer/model_inspection.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "foreview/scene/errors.h"
#include "foreview/viewer/commands.h"
#include "support/temporary_directory.h"

namespace foreview {
namespace {

// A plate of 1 x 1 m as two triangles, one of them the wrong way round, a duplicate, and a face without area.
const char* const kPlate = "o plate\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 4 3\nf 3 1 2\nf 1 2 2\n";

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(InspectModel, FindsWhatLooksWrong) {
  const test::TemporaryDirectory directory;
  const auto file = directory.write("plate.obj", kPlate);
  const ModelInspection inspection = inspect_model(file, {}, {});
  EXPECT_DOUBLE_EQ(inspection.area, 1);
  EXPECT_EQ(inspection.polygons_too_large, 2U);
  EXPECT_EQ(inspection.part_names, (std::vector<std::string>{"plate", "backdrop"}));
  EXPECT_EQ(inspection.part_polygons, (std::vector<std::size_t>{2, 150}));
  const std::string text = to_text(inspection);
  EXPECT_TRUE(holds(text, "faces dropped: duplicate          1\n")) << text;
  EXPECT_TRUE(holds(text, "faces dropped: no area            1\n")) << text;
  EXPECT_TRUE(holds(text, "of opposed winding                1\n")) << text;
  EXPECT_TRUE(holds(text, "2 polygons are wider than the 51.2 cm")) << text;
  EXPECT_TRUE(holds(text, "1 edges between faces of opposed winding")) << text;
  EXPECT_FALSE(holds(text, "scale")) << text;
}

TEST(InspectModel, DoubtsTheScale) {
  const test::TemporaryDirectory directory;
  const auto file = directory.write("plate.obj", kPlate);
  ImportOptions options;
  options.scale = 5000;
  EXPECT_TRUE(holds(to_text(inspect_model(file, options, {})), "the model is 5000 m wide: is the scale right?"));
  options.scale = 0.001;
  EXPECT_TRUE(holds(to_text(inspect_model(file, options, {})), "the model is only 1.000000 mm wide: is the scale"));
}

TEST(InspectModel, SaysWhatTexturesCost) {
  const test::TemporaryDirectory directory;
  const auto file = directory.write("plate.obj", "v 0 0 0\nv .5 0 0\nv .5 .5 0\nv 0 .5 0\nf 1 2 3 4\n");
  ImportOptions options;
  options.backdrop = false;
  ModelInspection inspection = inspect_model(file, options, {});
  EXPECT_NEAR(inspection.layout.useful_texels, 250 * 250, 1e-6);
  EXPECT_EQ(inspection.layout.page_size, 256);
  EXPECT_EQ(inspection.findings, std::vector<std::string>{"1 holes or rims of 4 edges: cameras see through them"});
  EXPECT_TRUE(holds(to_text(inspection), "1 of 256 x 256 texels"));
  EXPECT_EQ(inspection.charts, 1U);
  ChartOptions charts;
  charts.texels_per_metre = 10;
  inspection = inspect_model(file, options, charts);
  EXPECT_TRUE(holds(to_text(inspection), "texels are written for each useful one")) << to_text(inspection);
}

TEST(InspectModel, JsonHoldsTheSameFigures) {
  const test::TemporaryDirectory directory;
  // A part's name that is no UTF-8 must not break the report.
  const auto file = directory.write("plate.obj", "o pl\xff\x80te\nv 0 0 0\nv .5 0 0\nv .5 .5 0\nv 0 .5 0\nf 1 2 3 4\n");
  const ModelInspection inspection = inspect_model(file, {}, {});
  const nlohmann::json json = nlohmann::json::parse(to_json(inspection));
  EXPECT_EQ(json["version"], 1);
  EXPECT_EQ(json["polygons"], 151);
  EXPECT_EQ(json["edges"]["boundary"], 4);
  EXPECT_EQ(json["parts"][1]["name"], "backdrop");
  EXPECT_EQ(json["textures"]["charts"], 1) << "the backdrop's do not count";
  EXPECT_EQ(json["textures"]["memory_bytes"], inspection.layout.memory_bytes);
}

TEST(InspectCommand, ReadsItsOptionsAndWritesJson) {
  const test::TemporaryDirectory directory;
  const auto file = directory.write("plate.obj", kPlate);
  const auto run = [&](std::vector<std::string> arguments) {
    CLI::App app;
    add_inspect_command(app);
    std::reverse(arguments.begin(), arguments.end());
    app.parse(arguments);
  };
  testing::internal::CaptureStdout();
  run({"inspect", file.string(), "--scale", "0.5", "--density", "100", "--max-texels", "64", "--no-merge",
       "--no-backdrop", "--json", (directory / "out.json").string()});
  const std::string text = testing::internal::GetCapturedStdout();
  EXPECT_TRUE(holds(text, "Textures at 100 texels per metre, at most 64 along an axis")) << text;
  const nlohmann::json json = nlohmann::json::parse(directory.read("out.json"));
  EXPECT_EQ(json["options"]["scale"], 0.5);
  EXPECT_EQ(json["options"]["merge_coplanar"], false);
  EXPECT_EQ(json["backdrop_polygons"], 0);
  EXPECT_THROW(run({"inspect", (directory / "missing.obj").string()}), InputError);
  EXPECT_THROW(run({"inspect", file.string(), "--scale", "-1"}), InputError);
  EXPECT_THROW(run({"inspect", file.string(), "--density", "0"}), InputError);
  EXPECT_THROW(run({"inspect"}), CLI::ParseError);
}

}  // namespace
}  // namespace foreview
