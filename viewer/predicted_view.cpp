#include "foreview/viewer/predicted_view.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/gtc/type_ptr.hpp>
#include <optional>
#include <span>
#include <string>

#include "foreview/viewer/gap_filler.h"
#include "foreview/viewer/model_buffers.h"
#include "foreview/viewer/render_target.h"
#include "foreview/viewer/spotlight.h"
#include "foreview/viewer/surface_target.h"
#include "foreview/viewer/view_geometry.h"

namespace foreview {
namespace {

constexpr GLuint kPartsBinding = 0, kChartsBinding = 1, kPolygonStatesBinding = 2;
constexpr GLuint kSpotlightPartsBinding = 4;
constexpr GLuint kExposureBinding = 0, kOverlayBinding = 1;  // of uniform buffers
constexpr GLuint kPagesUnit = 0, kSpotlightUnit = 1, kCaptureTimesUnit = 3;
constexpr std::int64_t kMostMilliseconds = 2'000'000'000;
constexpr float kKnownBehind = 32.0F / 255.0F;  ///< view_known.glsl: where there is no surface, nothing is seen behind
constexpr glm::vec3 kLineColour{0.25F, 1.0F, 0.35F};

/// Backdrop polygons are the last ones.
std::uint32_t first_backdrop(const PolygonModel& model) {
  const auto& polygons = model.polygons();
  const auto first =
      std::find_if(polygons.begin(), polygons.end(), [](const Polygon& polygon) { return polygon.is_backdrop; });
  return static_cast<std::uint32_t>(first - polygons.begin());
}

/// view_overlays.glsl's uniform block (std140).
struct OverlayBlock {
  std::uint32_t holes = 0, never_seen = 0, age = 0, density = 0;
  std::int32_t polygon = -1, group = -1, moment = 0;
  float age_span = 1;
  std::uint32_t spotlight = 0;
  float orientation = 1;
  std::array<float, 2> padding{};
};
static_assert(sizeof(OverlayBlock) == 48);

}  // namespace

struct PredictedView::State {
  const TextureStore& store;
  ModelBuffers model;
  ModelBuffers::Placement placement;
  GlSampler sampler;
  GlBuffer overlay_block;
  GlProgram surface_program, depth_program, edge_program;
  std::array<std::array<GlProgram, 2>, 2> polygon_programs;  ///< by whether fast, and whether with overlays
  std::optional<Spotlight> spotlight;
  std::optional<GapFiller> gap_filler;
  AntialiasedTarget target;
  SurfaceTarget surface_target;

  explicit State(const TextureStore& texture_store)
      : store(texture_store),
        model(texture_store.model(), texture_store.layout()),
        placement(model.make_placement()),
        sampler(make_clamped_sampler(GL_LINEAR_MIPMAP_NEAREST)),
        overlay_block(GlBuffer::create()),
        surface_program(make_program("view_polygons.vert.glsl", "view_polygons.frag.glsl", "#define SURFACE 1\n")),
        depth_program(make_program("view_polygons.vert.glsl", "view_wireframe.frag.glsl")),
        edge_program(make_program("view_wireframe.vert.glsl", "view_wireframe.frag.glsl")) {
    glNamedBufferStorage(overlay_block.id(), sizeof(OverlayBlock), nullptr, GL_DYNAMIC_STORAGE_BIT);
    // The shader asks for whole levels only, because each level has a clamp of its own.
    glProgramUniform3fv(edge_program.id(), glGetUniformLocation(edge_program.id(), "line_colour"), 1,
                        glm::value_ptr(kLineColour));
    static_cast<void>(polygon_program({}));
  }

  /// Compiled when first asked for: an operator who never needs an overlay does not wait for it.
  [[nodiscard]] const GlProgram& polygon_program(const Style& style) {
    const bool fast = style.quality == ViewQuality::fast, overlays = style.colours_surfaces();
    GlProgram& program = polygon_programs[fast ? 1 : 0][overlays ? 1 : 0];
    if (program.id() == 0) {
      const std::string defines =
          std::string(fast ? "#define FAST 1\n" : "") + (overlays ? "#define OVERLAYS 1\n" : "");
      program = make_program("view_polygons.vert.glsl", "view_polygons.frag.glsl", defines.c_str());
      glProgramUniform1ui(program.id(), 0, first_backdrop(store.model()));
    }
    return program;
  }

  void begin(GLuint framebuffer, const Viewport& viewport, bool flip) const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(viewport.x, viewport.y, viewport.width, viewport.height);
    glScissor(viewport.first_x(), viewport.y, viewport.end_x() - viewport.first_x(), viewport.height);
    glEnable(GL_SCISSOR_TEST);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    // Counter-clockwise polygons turn clockwise where the picture's top is at y = -1.
    glFrontFace(flip ? GL_CCW : GL_CW);
    model.bind();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kPartsBinding, placement.buffer());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kChartsBinding, model.charts());
    const TextureStore::Shown shown = store.acquire();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kPolygonStatesBinding, shown.polygon_states);
    glBindBufferBase(GL_UNIFORM_BUFFER, kExposureBinding, shown.exposure);
    glBindTextureUnit(kPagesUnit, shown.pages);
    glBindSampler(kPagesUnit, sampler.id());
  }

  static void clear(bool colour, float alpha = 1) {
    glClearDepth(0.0);
    glClearColor(0, 0, 0, alpha);
    glClear(GL_DEPTH_BUFFER_BIT | (colour ? GL_COLOR_BUFFER_BIT : 0U));
  }

  void end() const {
    store.release();
    glBindSampler(kPagesUnit, 0);
    glBindVertexArray(0);
    glUseProgram(0);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glFrontFace(GL_CCW);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
  }

  void draw_depth_only() const {
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glUseProgram(depth_program.id());
    model.draw_triangles();
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
  }

  /// Before begin(): draws the spotlight's depth where its picture is a new one.
  void prepare_spotlight(const Style& style) {
    if (style.spotlight == nullptr || style.spotlight_camera == nullptr) return;
    if (!spotlight) spotlight.emplace(model);
    spotlight->set(*style.spotlight_camera, *style.spotlight, style.near_plane);
  }

  void set_overlays(const Style& style, bool flip) const {
    OverlayBlock block;
    block.holes = style.holes_pink ? 1 : 0;
    block.never_seen = style.never_seen ? 1 : 0;
    block.age = style.age ? 1 : 0;
    block.density = style.density ? 1 : 0;
    if (style.polygon && *style.polygon < store.layout().charts.size()) {
      block.polygon = static_cast<std::int32_t>(*style.polygon);
      block.group = static_cast<std::int32_t>(store.layout().charts[*style.polygon].group);
    }
    const TextureStore::Shown shown = store.acquire();
    block.moment = static_cast<std::int32_t>(
        std::clamp((style.moment - shown.epoch).nanoseconds / 1'000'000, -kMostMilliseconds, kMostMilliseconds));
    block.age_span = static_cast<float>(std::max(style.age_span, 1e-3));
    block.spotlight = spotlight && style.spotlight != nullptr ? 1 : 0;
    block.orientation = flip ? -1.0F : 1.0F;
    glNamedBufferSubData(overlay_block.id(), 0, sizeof block, &block);
    glBindBufferBase(GL_UNIFORM_BUFFER, kOverlayBinding, overlay_block.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kSpotlightPartsBinding,
                     block.spotlight != 0 ? spotlight->parts() : placement.buffer());
    glBindTextureUnit(kSpotlightUnit, block.spotlight != 0 ? spotlight->depth() : 0);
    glBindTextureUnit(kCaptureTimesUnit, shown.capture_times);
    store.release();
  }

  void draw(const CameraModel& camera, const Pose& world_from_camera, std::span<const Pose> world_from_part,
            const Style& style, GLuint framebuffer, const Viewport& viewport, bool flip) {
    if (viewport.is_empty()) return;
    const CameraModel fitted = fit_camera(camera, viewport.width, viewport.height);
    if (style.textures) prepare_spotlight(style);
    model.place(placement, fitted, world_from_camera, world_from_part, style.near_plane, flip);
    const bool sorted = style.textures && style.quality == ViewQuality::fast;
    if (sorted) model.sort(world_from_camera, world_from_part);
    begin(framebuffer, viewport, flip);
    // Alpha tells the gap filler what is known; nobody else needs it.
    const bool fills_gaps = style.fills_gaps();
    clear(style.textures, fills_gaps ? kKnownBehind : 1);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, fills_gaps ? GL_TRUE : GL_FALSE);
    if (style.cull_back_faces) glEnable(GL_CULL_FACE);
    if (style.textures) {
      const GlProgram& program = polygon_program(style);
      if (style.colours_surfaces()) set_overlays(style, flip);
      glUseProgram(program.id());
      model.draw_triangles(sorted);
    } else if (style.wireframe) {
      draw_depth_only();
    }
    if (style.wireframe) {
      glUseProgram(edge_program.id());
      model.draw_edges();
    }
    if (style.textures && spotlight && style.spotlight != nullptr) {
      spotlight->draw_frustum(fitted, world_from_camera, style.near_plane, flip);
    }
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    end();
    if (!fills_gaps) return;
    if (!gap_filler) gap_filler.emplace();
    gap_filler->fill(framebuffer, viewport.first_x(), viewport.end_x(), viewport.y, viewport.height,
                     style.gaps == GapFilling::all);
  }

  void draw_surface(const CameraModel& camera, const Pose& world_from_camera, std::span<const Pose> world_from_part,
                    bool cull_back_faces, double near_plane, const SurfaceTarget& into) {
    model.place(placement, camera.undistorted(), world_from_camera, world_from_part, near_plane, false);
    begin(into.framebuffer(), {0, 0, into.width(), into.height()}, false);
    const TextureStore::Shown shown = store.acquire();
    glBindTextureUnit(kCaptureTimesUnit, shown.capture_times);
    store.release();
    into.clear();
    if (cull_back_faces) glEnable(GL_CULL_FACE);
    glUseProgram(surface_program.id());
    model.draw_triangles();
    end();
  }

  Surface surface(const CameraModel& camera, const Pose& world_from_camera, std::span<const Pose> world_from_part) {
    target.resize(camera.width, camera.height, "camera");  // for its check of the driver's limits
    surface_target.resize(camera.width, camera.height);
    draw_surface(camera, world_from_camera, world_from_part, false, Style().near_plane, surface_target);
    return {surface_target.read_polygons(), surface_target.read_inverse_z(), surface_target.read_provenance()};
  }
};

GapFilling gaps_to_fill(const CameraModel& registered, const CameraModel& recorded) {
  // What fits is left as it is, to the bit.
  const bool is_corrected =
      registered.focal_length != recorded.focal_length || registered.principal_point != recorded.principal_point;
  return is_corrected ? GapFilling::all : GapFilling::cracks;
}

PredictedView::PredictedView(const TextureStore& store) : state_(std::make_unique<State>(store)) {}
PredictedView::~PredictedView() = default;

const TextureStore& PredictedView::store() const {
  return state_->store;
}

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

void PredictedView::draw_surface(const CameraModel& camera, const PredictedState& state, const Style& style,
                                 const SurfaceTarget& into) {
  state_->draw_surface(camera, state.world_from_camera, state.world_from_part, style.cull_back_faces, style.near_plane,
                       into);
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
