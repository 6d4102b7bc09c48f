#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "foreview/gpu/shader_source.h"
#include "gpu/gl_test_fixture.h"

namespace foreview {
namespace {

class ShaderProgram : public GlTest {
 public:
  ~ShaderProgram() override { set_shader_directory(""); }

 protected:
  ShaderProgram() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    directory_ = std::filesystem::path(FOREVIEW_TEST_OUTPUT_DIR) / "shader_programs" / info->name();
    std::filesystem::remove_all(directory_);
    std::filesystem::create_directories(directory_);
    set_shader_directory(directory_.c_str());
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(directory_ / name) << text; }
  std::filesystem::path directory_;
};

TEST_F(ShaderProgram, CompilerErrorsNameFileAndLine) {
  write("main.comp.glsl",
        "#version 450 core\nlayout(local_size_x = 1) in;\n#include \"snippet.glsl\"\nvoid main() { f(); }\n");
  write("snippet.glsl", "// fine\nvoid f() { undeclared_thing = 3; }\n");
  try {
    const GlProgram program = make_compute_program("main.comp.glsl");
    FAIL() << "compiled";
  } catch (const GraphicsError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("1 = snippet.glsl"), std::string::npos) << text;
    EXPECT_NE(text.find(":2("), std::string::npos) << "the line, as Mesa writes it: " << text;
    EXPECT_NE(text.find("1:2\tvoid f()"), std::string::npos) << text;
    EXPECT_NE(text.find("0:4\tvoid main()"), std::string::npos) << text;
    EXPECT_NE(text.find("undeclared_thing"), std::string::npos);
  }
}

TEST_F(ShaderProgram, LinkErrorsAreThrown) {
  write("a.vert.glsl", "#version 450 core\nout vec3 x;\nvoid main() { x = vec3(1); gl_Position = vec4(0); }\n");
  write("b.frag.glsl", "#version 450 core\nin vec4 x;\nout vec4 c;\nvoid main() { c = x; }\n");
  EXPECT_THROW((void)make_program("a.vert.glsl", "b.frag.glsl"), GraphicsError);
}

TEST_F(ShaderProgram, FullscreenTriangleCoversEveryPixelWithItsOwnCoordinates) {
  std::ofstream(directory_ / "fullscreen.vert.glsl")
      << std::ifstream(std::string(FOREVIEW_TEST_DIR) + "/../gpu/shaders/fullscreen.vert.glsl").rdbuf();
  write("uv.frag.glsl",
        "#version 450 core\nin vec2 v_uv;\nout vec4 c;\nvoid main() { c = vec4(v_uv * SCALE, 0, 1); }\n");
  const GlProgram program = make_program("fullscreen.vert.glsl", "uv.frag.glsl", "#define SCALE vec2(4.0, 2.0)\n");
  const GlTexture target = make_texture_2d(GL_RGBA32F, 4, 2);
  const GlFramebuffer framebuffer = make_framebuffer(target.id());
  const GlVertexArray vertex_array = GlVertexArray::create();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
  glViewport(0, 0, 4, 2);
  glUseProgram(program.id());
  glBindVertexArray(vertex_array.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  std::array<float, 4 * 4 * 2> texels{};
  glGetTextureImage(target.id(), 0, GL_RGBA, GL_FLOAT, sizeof texels, texels.data());
  for (std::size_t y = 0; y < 2; ++y) {
    for (std::size_t x = 0; x < 4; ++x) {
      const std::size_t i = 4 * (y * 4 + x);
      EXPECT_NEAR(texels[i], static_cast<float>(x) + 0.5F, 1e-5);
      EXPECT_NEAR(texels[i + 1], static_cast<float>(y) + 0.5F, 1e-5);
      EXPECT_EQ(texels[i + 3], 1.0F);
    }
  }
  glBindVertexArray(0);
}

TEST_F(GlTest, FramebuffersWithoutAttachmentsAreRefused) {
  EXPECT_THROW((void)make_framebuffer(0, 0), GraphicsError);
}

TEST_F(GlTest, LayerFramebuffersWriteOnlyTheirLayerAndLevel) {
  const GlTexture pages = make_texture_2d_array(GL_RGBA8, 4, 4, 2, 2);
  const std::array<GLubyte, 4> grey{9, 9, 9, 9};
  for (int level = 0; level < 2; ++level) {
    glClearTexImage(pages.id(), level, GL_RGBA, GL_UNSIGNED_BYTE, grey.data());
  }
  const GlFramebuffer framebuffer = make_layer_framebuffer(pages.id(), 1, 1);
  const std::array<float, 4> white{1, 1, 1, 1};
  glClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 0, white.data());
  std::vector<GLubyte> level0(4 * 4 * 4 * 2), level1(2 * 2 * 4 * 2);
  glGetTextureImage(pages.id(), 0, GL_RGBA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(level0.size()), level0.data());
  glGetTextureImage(pages.id(), 1, GL_RGBA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(level1.size()), level1.data());
  EXPECT_EQ(level0, std::vector<GLubyte>(level0.size(), 9));
  for (std::size_t i = 0; i < level1.size(); ++i) EXPECT_EQ(level1[i], i < 16 ? 9 : 255) << i;
}

TEST_F(GlTest, LiveObjectCounterFollowsOwnership) {
  const long before = live_gl_objects();
  {
    GlBuffer a = GlBuffer::create();
    EXPECT_EQ(live_gl_objects(), before + 1);
    GlBuffer b = std::move(a);
    EXPECT_EQ(live_gl_objects(), before + 1);
    b = GlBuffer::create();
    EXPECT_EQ(live_gl_objects(), before + 1);
    b.reset();
    EXPECT_EQ(live_gl_objects(), before);
  }
  EXPECT_EQ(live_gl_objects(), before);
}

}  // namespace
}  // namespace foreview
