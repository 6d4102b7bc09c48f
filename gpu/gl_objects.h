#pragma once
#include <epoxy/gl.h>

#include <atomic>
#include <utility>

namespace foreview {

namespace gl_detail {
inline std::atomic<long> live_objects{0};
}  // namespace gl_detail
/// GL objects that GlObjects of this process own at the moment: tests compare it to find leaks.
[[nodiscard]] inline long live_gl_objects() {
  return gl_detail::live_objects.load();
}

/// Owns one GL object name. Movable, not copyable; destroyed with a context of its share group current.
template <void (*Create)(GLuint*), void (*Delete)(GLuint)>
class GlObject {
 public:
  GlObject() = default;
  explicit GlObject(GLuint id) : id_(id) {
    if (id_ != 0) ++gl_detail::live_objects;
  }
  ~GlObject() { reset(); }
  GlObject(GlObject&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  GlObject& operator=(GlObject&& other) noexcept {
    if (this != &other) {
      reset();
      id_ = std::exchange(other.id_, 0);
    }
    return *this;
  }
  GlObject(const GlObject&) = delete;
  GlObject& operator=(const GlObject&) = delete;
  [[nodiscard]] GLuint id() const { return id_; }
  void reset() {
    if (id_ == 0) return;
    Delete(id_);
    id_ = 0;
    --gl_detail::live_objects;
  }
  [[nodiscard]] static GlObject create() {
    GLuint id = 0;
    Create(&id);
    return GlObject(id);
  }

 private:
  GLuint id_ = 0;
};

namespace gl_detail {
inline void create_buffer(GLuint* id) {
  glCreateBuffers(1, id);
}
inline void delete_buffer(GLuint id) {
  glDeleteBuffers(1, &id);
}
inline void create_framebuffer(GLuint* id) {
  glCreateFramebuffers(1, id);
}
inline void delete_framebuffer(GLuint id) {
  glDeleteFramebuffers(1, &id);
}
inline void create_vertex_array(GLuint* id) {
  glCreateVertexArrays(1, id);
}
inline void delete_vertex_array(GLuint id) {
  glDeleteVertexArrays(1, &id);
}
inline void no_create(GLuint* id) {
  *id = 0;
}
inline void delete_texture(GLuint id) {
  glDeleteTextures(1, &id);
}
inline void delete_program(GLuint id) {
  glDeleteProgram(id);
}
inline void create_query(GLuint* id) {
  glCreateQueries(GL_ANY_SAMPLES_PASSED, 1, id);
}
inline void create_samples_query(GLuint* id) {
  glCreateQueries(GL_SAMPLES_PASSED, 1, id);
}
inline void delete_query(GLuint id) {
  glDeleteQueries(1, &id);
}
inline void create_sampler(GLuint* id) {
  glCreateSamplers(1, id);
}
inline void delete_sampler(GLuint id) {
  glDeleteSamplers(1, &id);
}
}  // namespace gl_detail

using GlBuffer = GlObject<gl_detail::create_buffer, gl_detail::delete_buffer>;
using GlFramebuffer = GlObject<gl_detail::create_framebuffer, gl_detail::delete_framebuffer>;
using GlVertexArray = GlObject<gl_detail::create_vertex_array, gl_detail::delete_vertex_array>;
using GlSampler = GlObject<gl_detail::create_sampler, gl_detail::delete_sampler>;
using GlOcclusionQuery = GlObject<gl_detail::create_query, gl_detail::delete_query>;
using GlSamplesQuery = GlObject<gl_detail::create_samples_query, gl_detail::delete_query>;
using GlTexture = GlObject<gl_detail::no_create, gl_detail::delete_texture>;
using GlProgram = GlObject<gl_detail::no_create, gl_detail::delete_program>;

/// Owns a fence: a mark in the current context's stream of commands. Movable, not copyable; destroyed with a context of
/// its share group current, which need not be the one that made it. Counts as a live object.
class GlFence {
 public:
  GlFence() = default;
  ~GlFence() { reset(); }
  GlFence(GlFence&& other) noexcept : sync_(std::exchange(other.sync_, nullptr)) {}
  GlFence& operator=(GlFence&& other) noexcept {
    if (this != &other) {
      reset();
      sync_ = std::exchange(other.sync_, nullptr);
    }
    return *this;
  }
  GlFence(const GlFence&) = delete;
  GlFence& operator=(const GlFence&) = delete;
  /// Behind all commands issued so far, and flushes them: without that another context might never see it pass.
  [[nodiscard]] static GlFence insert();
  /// Never waits. Only of a fence that was inserted.
  [[nodiscard]] bool has_passed() const;
  /// Until it has passed.
  void wait() const;

 private:
  void reset();
  GLsync sync_ = nullptr;
};

/// Textures with immutable storage. Filtering nearest, clamped to the edge.
[[nodiscard]] GlTexture make_texture_2d(GLenum internal_format, int width, int height, int levels = 1);
[[nodiscard]] GlTexture make_texture_2d_array(GLenum internal_format, int width, int height, int layers,
                                              int levels = 1);
/// Bilinear magnification, clamped to the edge.
[[nodiscard]] GlSampler make_clamped_sampler(GLenum minification = GL_LINEAR);
/// One colour attachment (level `level` of `color_texture`), draw buffer 0, and depth; either may be 0, for none. Of an
/// array texture all layers are attached (gl_Layer selects). GraphicsError if incomplete.
[[nodiscard]] GlFramebuffer make_framebuffer(GLuint color_texture, GLuint depth_texture = 0, int level = 0);
/// One layer of an array texture as the only attachment.
[[nodiscard]] GlFramebuffer make_layer_framebuffer(GLuint color_texture, int layer, int level = 0);

/// Compiles shaders of gpu/shaders, see load_shader() in shader_source.h. Names are file names,
/// "fullscreen.vert.glsl". `#include "name"` is resolved. GraphicsError with the compiler's log and the numbered
/// source.
[[nodiscard]] GlProgram make_program(const char* vertex_file, const char* fragment_file, const char* defines = "");
[[nodiscard]] GlProgram make_compute_program(const char* compute_file, const char* defines = "");
/// Reads shaders from this directory from now on, for live editing (`--shader-dir`); empty: the embedded ones.
void set_shader_directory(const char* directory);

}  // namespace foreview
