#include "foreview/viewer/predicted_view.h"

#include <array>
#include <cassert>
#include <glm/ext/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <span>

#include "foreview/viewer/render_target.h"
#include "foreview/viewer/view_geometry.h"

namespace foreview {
namespace {

constexpr GLuint kPartsBinding = 0, kChartsBinding = 1, kPolygonStatesBinding = 2;
constexpr GLuint kExposureBinding = 0;  // of uniform buffers
constexpr GLuint kPagesUnit = 0;
constexpr glm::vec3 kLineColour{0.25F, 1.0F, 0.35F};

template <class T>
GlBuffer make_buffer(const std::vector<T>& content, GLbitfield flags = 0) {
  GlBuffer buffer = GlBuffer::create();
  // A buffer cannot be empty; nothing is ever read from this stand-in.
  static constexpr std::array<char, 64> kNothing{};
  const auto bytes = static_cast<GLsizeiptr>(content.size() * sizeof(T));
  glNamedBufferStorage(buffer.id(), bytes > 0 ? bytes : 64,
                       bytes > 0 ? static_cast<const void*>(content.data()) : kNothing.data(), flags);
  return buffer;
}

void set_attribute(GLuint vao, GLuint index, GLint components, std::size_t offset, bool integer) {
  glEnableVertexArrayAttrib(vao, index);
  if (integer) {
    glVertexArrayAttribIFormat(vao, index, components, GL_UNSIGNED_INT, static_cast<GLuint>(offset));
  } else {
    glVertexArrayAttribFormat(vao, index, components, GL_FLOAT, GL_FALSE, static_cast<GLuint>(offset));
  }
  glVertexArrayAttribBinding(vao, index, 0);
}

/// Integer and float attachments of render_surface.
struct SurfaceTarget {
  int width = 0, height = 0;
  GlTexture polygon, inverse_z, provenance, depth;
  GlFramebuffer framebuffer;

  void resize(int new_width, int new_height) {
    if (width == new_width && height == new_height) return;
    polygon = make_texture_2d(GL_R32I, new_width, new_height);
    inverse_z = make_texture_2d(GL_R32F, new_width, new_height);
    provenance = make_texture_2d(GL_R8UI, new_width, new_height);
    depth = make_texture_2d(GL_DEPTH_COMPONENT32F, new_width, new_height);
    framebuffer = make_framebuffer(polygon.id(), depth.id());
    glNamedFramebufferTexture(framebuffer.id(), GL_COLOR_ATTACHMENT1, inverse_z.id(), 0);
    glNamedFramebufferTexture(framebuffer.id(), GL_COLOR_ATTACHMENT2, provenance.id(), 0);
    constexpr std::array<GLenum, 3> kBuffers{GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
    glNamedFramebufferDrawBuffers(framebuffer.id(), 3, kBuffers.data());
    width = new_width;
    height = new_height;
  }

  void clear() const {
    constexpr std::array<GLint, 4> kNoPolygon{-1, -1, -1, -1};
    constexpr std::array<GLfloat, 4> kNothing{0, 0, 0, 0};
    constexpr std::array<GLuint, 4> kNeverSeen{0, 0, 0, 0};
    glClearNamedFramebufferiv(framebuffer.id(), GL_COLOR, 0, kNoPolygon.data());
    glClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 1, kNothing.data());
    glClearNamedFramebufferuiv(framebuffer.id(), GL_COLOR, 2, kNeverSeen.data());
    glClearNamedFramebufferfv(framebuffer.id(), GL_DEPTH, 0, kNothing.data());
  }

  [[nodiscard]] cv::Mat read(GLenum attachment, GLenum format, GLenum type, int cv_type) const {
    cv::Mat result(height, width, cv_type);
    glNamedFramebufferReadBuffer(framebuffer.id(), attachment);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer.id());
    glReadPixels(0, 0, width, height, format, type, result.data);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    return result;
  }
};

}  // namespace

struct PredictedView::State {
  const TextureStore& store;
  ViewGeometry geometry;
  GlBuffer vertices, triangles, edges, charts, parts;
  GlVertexArray vao;
  GlSampler sampler;
  GlProgram polygon_program, surface_program, depth_program, edge_program;
  AntialiasedTarget target;
  SurfaceTarget surface_target;

  explicit State(const TextureStore& texture_store)
      : store(texture_store),
        geometry(texture_store.model(), texture_store.layout()),
        vertices(make_buffer(geometry.vertices)),
        triangles(make_buffer(geometry.triangles)),
        edges(make_buffer(geometry.edges)),
        charts(make_buffer(geometry.charts)),
        parts(make_buffer(std::vector<glm::mat4>(geometry.part_centres.size()), GL_DYNAMIC_STORAGE_BIT)),
        vao(GlVertexArray::create()),
        sampler(make_clamped_sampler(GL_LINEAR_MIPMAP_NEAREST)),
        polygon_program(make_program("view_polygons.vert.glsl", "view_polygons.frag.glsl")),
        surface_program(make_program("view_polygons.vert.glsl", "view_polygons.frag.glsl", "#define SURFACE 1\n")),
        depth_program(make_program("view_polygons.vert.glsl", "view_wireframe.frag.glsl")),
        edge_program(make_program("view_wireframe.vert.glsl", "view_wireframe.frag.glsl")) {
    glVertexArrayVertexBuffer(vao.id(), 0, vertices.id(), 0, sizeof(ViewGeometry::Vertex));
    set_attribute(vao.id(), 0, 3, offsetof(ViewGeometry::Vertex, position), false);
    set_attribute(vao.id(), 1, 2, offsetof(ViewGeometry::Vertex, texel), false);
    set_attribute(vao.id(), 2, 1, offsetof(ViewGeometry::Vertex, polygon), true);
    set_attribute(vao.id(), 3, 1, offsetof(ViewGeometry::Vertex, part), true);
    // The shader asks for whole levels only, because each level has a clamp of its own.
    glProgramUniform3fv(edge_program.id(), glGetUniformLocation(edge_program.id(), "line_colour"), 1,
                        glm::value_ptr(kLineColour));
  }

  /// Places the parts; matrices are multiplied in double, so that a model far from the origin does not tremble.
  void place_parts(const CameraModel& camera, const Pose& world_from_camera, std::span<const Pose> world_from_part,
                   double near_plane, bool flip) {
    assert(world_from_part.size() == geometry.part_centres.size());
    glm::dmat4 clip_from_camera = camera.clip_from_camera(near_plane);
    if (flip) {
      clip_from_camera = glm::scale(glm::dmat4(1.0), glm::dvec3(1, -1, 1)) * clip_from_camera;
    }
    const Pose camera_from_world = world_from_camera.inverse();
    std::vector<glm::mat4> clip_from_part;
    for (std::size_t i = 0; i < world_from_part.size(); ++i) {
      const glm::dmat4 part_from_centre = glm::translate(glm::dmat4(1.0), geometry.part_centres[i]);
      clip_from_part.emplace_back(clip_from_camera * (camera_from_world * world_from_part[i]).matrix() *
                                  part_from_centre);
    }
    glNamedBufferSubData(parts.id(), 0, static_cast<GLsizeiptr>(clip_from_part.size() * sizeof(glm::mat4)),
                         clip_from_part.data());
    // Counter-clockwise polygons turn clockwise where the picture's top is at y = -1.
    glFrontFace(flip ? GL_CCW : GL_CW);
  }

  void begin(GLuint framebuffer, const Viewport& viewport) const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(viewport.x, viewport.y, viewport.width, viewport.height);
    glScissor(viewport.x, viewport.y, viewport.width, viewport.height);
    glEnable(GL_SCISSOR_TEST);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glBindVertexArray(vao.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kPartsBinding, parts.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kChartsBinding, charts.id());
    const TextureStore::Shown shown = store.acquire();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kPolygonStatesBinding, shown.polygon_states);
    glBindBufferBase(GL_UNIFORM_BUFFER, kExposureBinding, shown.exposure);
    glBindTextureUnit(kPagesUnit, shown.pages);
    glBindSampler(kPagesUnit, sampler.id());
  }

  static void clear(bool colour) {
    glClearDepth(0.0);
    glClearColor(0, 0, 0, 1);
    glClear(GL_DEPTH_BUFFER_BIT | (colour ? GL_COLOR_BUFFER_BIT : 0U));
  }

  void end() const {
    store.release();
    glBindSampler(kPagesUnit, 0);
    glBindVertexArray(0);
    glUseProgram(0);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glFrontFace(GL_CCW);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
  }

  void draw_polygons(const GlProgram& program) const {
    glUseProgram(program.id());
    glVertexArrayElementBuffer(vao.id(), triangles.id());
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(geometry.triangles.size()), GL_UNSIGNED_INT, nullptr);
  }

  void draw_depth_only() const {
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    draw_polygons(depth_program);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  }

  void draw_edges() const {
    glUseProgram(edge_program.id());
    glVertexArrayElementBuffer(vao.id(), edges.id());
    glDrawElements(GL_LINES, static_cast<GLsizei>(geometry.edges.size()), GL_UNSIGNED_INT, nullptr);
  }

  void draw(const CameraModel& camera, const Pose& world_from_camera, std::span<const Pose> world_from_part,
            const Style& style, GLuint framebuffer, const Viewport& viewport, bool flip) {
    if (viewport.width < 1 || viewport.height < 1) return;
    place_parts(fit_camera(camera, viewport.width, viewport.height), world_from_camera, world_from_part,
                style.near_plane, flip);
    begin(framebuffer, viewport);
    clear(style.textures);
    if (style.textures) {
      glProgramUniform1i(polygon_program.id(), glGetUniformLocation(polygon_program.id(), "holes_pink"),
                         style.holes_pink ? 1 : 0);
      draw_polygons(polygon_program);
    } else if (style.wireframe) {
      draw_depth_only();
    }
    if (style.wireframe) draw_edges();
    end();
  }

  Surface surface(const CameraModel& camera, const Pose& world_from_camera, std::span<const Pose> world_from_part) {
    const int width = camera.width, height = camera.height;
    target.resize(width, height, "camera");  // for its check of the driver's limits
    surface_target.resize(width, height);
    place_parts(camera.undistorted(), world_from_camera, world_from_part, Style().near_plane, false);
    begin(surface_target.framebuffer.id(), {0, 0, width, height});
    surface_target.clear();
    draw_polygons(surface_program);
    end();
    return {surface_target.read(GL_COLOR_ATTACHMENT0, GL_RED_INTEGER, GL_INT, CV_32S),
            surface_target.read(GL_COLOR_ATTACHMENT1, GL_RED, GL_FLOAT, CV_32F),
            surface_target.read(GL_COLOR_ATTACHMENT2, GL_RED_INTEGER, GL_UNSIGNED_BYTE, CV_8U)};
  }
};

PredictedView::PredictedView(const TextureStore& store) : state_(std::make_unique<State>(store)) {}
PredictedView::~PredictedView() = default;

void PredictedView::draw(const CameraModel& camera, const PredictedState& state, const Style& style, GLuint framebuffer,
                         const Viewport& viewport, bool flip) {
  state_->draw(camera, state.world_from_camera, state.world_from_part, style, framebuffer, viewport, flip);
}

void PredictedView::draw_edges(const CameraModel& camera, const CaptureState& state, GLuint framebuffer,
                               const Viewport& viewport, bool flip, double near_plane) {
  Style style;
  style.textures = false;
  style.wireframe = true;
  style.near_plane = near_plane;
  state_->draw(camera, state.world_from_camera, state.world_from_part, style, framebuffer, viewport, flip);
}

cv::Mat PredictedView::render(const CameraModel& camera, const PredictedState& state, const Style& style) {
  AntialiasedTarget& target = state_->target;
  target.resize(camera.width, camera.height, "camera");
  if (!style.textures) {
    constexpr std::array<GLfloat, 4> kBlack{0, 0, 0, 1};
    glClearNamedFramebufferfv(target.framebuffer(), GL_COLOR, 0, kBlack.data());
  }
  draw(camera, state, style, target.framebuffer(), {0, 0, camera.width, camera.height}, false);
  return target.read();
}

PredictedView::Surface PredictedView::render_surface(const CameraModel& camera, const PredictedState& state) {
  return state_->surface(camera, state.world_from_camera, state.world_from_part);
}

PredictedView::Surface PredictedView::render_surface(const CameraModel& camera, const CaptureState& state) {
  return state_->surface(camera, state.world_from_camera, state.world_from_part);
}

}  // namespace foreview
