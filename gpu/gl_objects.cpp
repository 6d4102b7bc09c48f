#include "foreview/gpu/gl_objects.h"

#include <algorithm>
#include <cstdio>
#include <sstream>
#include <string>

#include "foreview/gpu/shader_source.h"
#include "foreview/scene/errors.h"

namespace foreview {

namespace {

void set_nearest_clamped(GLuint texture) {
  glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

/// Every line as FILE:LINE, counted as the #line directives say. Mesa's messages keep the line but lose the file's
/// number, so a reader looks for the line among the files.
std::string numbered(const std::string& text) {
  std::ostringstream out;
  std::istringstream in(text);
  std::string text_line;
  int file = 0, line = 1;
  while (std::getline(in, text_line)) {
    if (std::sscanf(text_line.c_str(), "#line %d %d", &line, &file) == 2) continue;
    out << file << ":" << line++ << "\t" << text_line << "\n";
  }
  return out.str();
}

std::string file_list(const ShaderSource& source) {
  std::string list;
  for (std::size_t i = 0; i < source.files.size(); ++i) {
    list += (i == 0 ? "" : ", ") + std::to_string(i) + " = " + source.files[i];
  }
  return list;
}

struct Shader {
  explicit Shader(GLenum type) : id(glCreateShader(type)) {}
  ~Shader() { glDeleteShader(id); }
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;
  GLuint id;
};

void compile(const Shader& shader, const ShaderSource& source) {
  const char* text = source.text.c_str();
  glShaderSource(shader.id, 1, &text, nullptr);
  glCompileShader(shader.id);
  GLint ok = 0;
  glGetShaderiv(shader.id, GL_COMPILE_STATUS, &ok);
  if (ok != 0) return;
  GLint length = 0;
  glGetShaderiv(shader.id, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
  glGetShaderInfoLog(shader.id, length, &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  throw GraphicsError("shader " + source.files.front() + " does not compile (files: " + file_list(source) + ")\n" +
                      log + "\n" + numbered(source.text));
}

void link(GLuint program, const std::string& name) {
  glLinkProgram(program);
  GLint ok = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &ok);
  if (ok != 0) return;
  GLint length = 0;
  glGetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
  glGetProgramInfoLog(program, length, &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  throw GraphicsError("shader program " + name + " does not link\n" + log);
}

GlFramebuffer checked(GlFramebuffer framebuffer, GLuint color_texture) {
  if (color_texture == 0) {
    glNamedFramebufferDrawBuffer(framebuffer.id(), GL_NONE);
    glNamedFramebufferReadBuffer(framebuffer.id(), GL_NONE);
  }
  const GLenum status = glCheckNamedFramebufferStatus(framebuffer.id(), GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    char text[80];
    std::snprintf(text, sizeof text, "framebuffer is incomplete (status 0x%04X)", status);
    throw GraphicsError(text);
  }
  return framebuffer;
}

}  // namespace

namespace {

/// Whether the fence passed within the time.
bool wait_for(GLsync sync, GLuint64 nanoseconds) {
  const GLenum result = glClientWaitSync(sync, 0, nanoseconds);
  if (result == GL_WAIT_FAILED) throw GraphicsError("the graphics driver refuses to wait for a fence");
  return result != GL_TIMEOUT_EXPIRED;
}

}  // namespace

GlFence GlFence::insert() {
  GlFence fence;
  fence.sync_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  if (fence.sync_ == nullptr) throw GraphicsError("the graphics driver gives no fence");
  ++gl_detail::live_objects;
  glFlush();
  return fence;
}

bool GlFence::has_passed() const {
  return wait_for(sync_, 0);
}

void GlFence::wait() const {
  constexpr GLuint64 kTenthOfASecond = 100'000'000;
  while (!wait_for(sync_, kTenthOfASecond)) {
  }
}

void GlFence::reset() {
  if (sync_ == nullptr) return;
  glDeleteSync(sync_);
  sync_ = nullptr;
  --gl_detail::live_objects;
}

GlTexture make_texture_2d(GLenum internal_format, int width, int height, int levels) {
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &id);
  GlTexture texture(id);
  glTextureStorage2D(id, levels, internal_format, width, height);
  set_nearest_clamped(id);
  return texture;
}

GlTexture make_texture_2d_array(GLenum internal_format, int width, int height, int layers, int levels) {
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &id);
  GlTexture texture(id);
  glTextureStorage3D(id, levels, internal_format, width, height, layers);
  set_nearest_clamped(id);
  return texture;
}

GlSampler make_clamped_sampler(GLenum minification) {
  GlSampler sampler = GlSampler::create();
  glSamplerParameteri(sampler.id(), GL_TEXTURE_MIN_FILTER, static_cast<GLint>(minification));
  glSamplerParameteri(sampler.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glSamplerParameteri(sampler.id(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glSamplerParameteri(sampler.id(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return sampler;
}

GlFramebuffer make_framebuffer(GLuint color_texture, GLuint depth_texture, int level) {
  GlFramebuffer framebuffer = GlFramebuffer::create();
  if (color_texture != 0) {
    glNamedFramebufferTexture(framebuffer.id(), GL_COLOR_ATTACHMENT0, color_texture, level);
  }
  if (depth_texture != 0) glNamedFramebufferTexture(framebuffer.id(), GL_DEPTH_ATTACHMENT, depth_texture, 0);
  return checked(std::move(framebuffer), color_texture);
}

GlFramebuffer make_layer_framebuffer(GLuint color_texture, int layer, int level) {
  GlFramebuffer framebuffer = GlFramebuffer::create();
  glNamedFramebufferTextureLayer(framebuffer.id(), GL_COLOR_ATTACHMENT0, color_texture, level, layer);
  return checked(std::move(framebuffer), color_texture);
}

GlProgram make_program(const char* vertex_file, const char* fragment_file, const char* defines) {
  const Shader vertex(GL_VERTEX_SHADER), fragment(GL_FRAGMENT_SHADER);
  compile(vertex, load_shader(vertex_file, defines));
  compile(fragment, load_shader(fragment_file, defines));
  GlProgram program(glCreateProgram());
  glAttachShader(program.id(), vertex.id);
  glAttachShader(program.id(), fragment.id);
  link(program.id(), std::string(vertex_file) + " + " + fragment_file);
  glDetachShader(program.id(), vertex.id);
  glDetachShader(program.id(), fragment.id);
  return program;
}

GlProgram make_compute_program(const char* compute_file, const char* defines) {
  const Shader compute(GL_COMPUTE_SHADER);
  compile(compute, load_shader(compute_file, defines));
  GlProgram program(glCreateProgram());
  glAttachShader(program.id(), compute.id);
  link(program.id(), compute_file);
  glDetachShader(program.id(), compute.id);
  return program;
}

}  // namespace foreview
