#include "foreview/gpu/shader_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/errors.h"

namespace foreview {
namespace {

class ShaderDirectory : public ::testing::Test {
 public:
  ~ShaderDirectory() override { set_shader_directory(""); }

 protected:
  ShaderDirectory() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    directory_ = std::filesystem::path(FOREVIEW_TEST_OUTPUT_DIR) / "shaders" / info->name();
    std::filesystem::remove_all(directory_);
    std::filesystem::create_directories(directory_);
    set_shader_directory(directory_.c_str());
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(directory_ / name, std::ios::binary) << text;
  }
  std::filesystem::path directory_;
};

TEST(EmbeddedShaders, AreReachableByFileNameByteForByte) {
  const std::vector<std::string> names = embedded_shader_names();
  EXPECT_NE(std::find(names.begin(), names.end(), "fullscreen.vert.glsl"), names.end());
  const std::string text = load_shader("fullscreen.vert.glsl").text;
  EXPECT_EQ(text.rfind("#version 450 core\n#line 2 0\n", 0), 0U) << text;
  EXPECT_NE(text.find("gl_Position = vec4(v_uv * 2.0 - 1.0, 0.0, 1.0);"), std::string::npos);
}

TEST(EmbeddedShaders, UnknownNameIsAnError) {
  EXPECT_THROW((void)load_shader("no_such.glsl"), GraphicsError);
}

TEST_F(ShaderDirectory, ResolvesIncludesOnceAndKeepsLineNumbers) {
  write("main.glsl", "#version 450 core\nint a;\n#include \"one.glsl\"  // why\n  # include \"two.glsl\"\nint d;\n");
  write("one.glsl", "#include \"two.glsl\"\nint b;\n");
  write("two.glsl", "#include \"one.glsl\"\nint c;\r\n");
  const ShaderSource source = load_shader("main.glsl", "#define N 3");
  EXPECT_EQ(source.text,
            "#version 450 core\n#define N 3\n#line 2 0\nint a;\n"
            "#line 1 1\n#line 1 2\n#line 2 2\nint c;\n#line 2 1\nint b;\n#line 4 0\n#line 5 0\nint d;\n");
  EXPECT_EQ(source.files, (std::vector<std::string>{"main.glsl", "one.glsl", "two.glsl"}));
}

TEST_F(ShaderDirectory, ReadsAgainAfterAChange) {
  write("main.glsl", "#version 450 core\nint a;\n");
  EXPECT_NE(load_shader("main.glsl").text.find("int a;"), std::string::npos);
  write("main.glsl", "#version 450 core\nint b;\n");
  EXPECT_NE(load_shader("main.glsl").text.find("int b;"), std::string::npos);
}

TEST_F(ShaderDirectory, MissingFilesAndVersionsAreErrors) {
  EXPECT_THROW((void)load_shader("absent.glsl"), GraphicsError);
  write("includes_absent.glsl", "#version 450 core\n#include \"absent.glsl\"\n");
  EXPECT_THROW((void)load_shader("includes_absent.glsl"), GraphicsError);
  write("no_version.glsl", "int a;\n");
  EXPECT_THROW((void)load_shader("no_version.glsl"), GraphicsError);
  write("empty.glsl", "");
  EXPECT_THROW((void)load_shader("empty.glsl"), GraphicsError);
}

}  // namespace
}  // namespace foreview
