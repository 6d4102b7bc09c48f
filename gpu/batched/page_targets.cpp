#include "foreview/gpu/batched/page_targets.h"

namespace foreview::batched {

namespace {

bool layers_forbidden = false;

}  // namespace

void forbid_drawing_layers(bool forbidden) {
  layers_forbidden = forbidden;
}

bool can_draw_layers() {
  return !layers_forbidden && epoxy_has_gl_extension("GL_ARB_shader_viewport_layer_array");
}

const char* layer_defines() {
  return can_draw_layers() ? "#define LAYERED\n" : "";
}

LayerTargets make_layer_targets(GLuint texture, int layers, int level) {
  LayerTargets targets;
  if (can_draw_layers()) {
    targets.push_back(make_framebuffer(texture, 0, level));
  } else {
    for (int layer = 0; layer < layers; ++layer) targets.push_back(make_layer_framebuffer(texture, layer, level));
  }
  return targets;
}

PageTargets::Level& PageTargets::find(int level) {
  const auto [found, is_new] = sets_.try_emplace(store_.pages());
  std::vector<Level>& levels = found->second;
  if (is_new) {
    const std::uint32_t pages = store_.layout().pages;
    for (GLuint i = 0; i < kChartLevels; ++i) {
      GLuint view = 0;
      glGenTextures(1, &view);
      glTextureView(view, GL_TEXTURE_2D_ARRAY, store_.pages(), GL_RGBA8, i, 1, 0, pages);
      glTextureParameteri(view, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
      glTextureParameteri(view, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
      levels.push_back(
          {GlTexture(view), make_layer_targets(store_.pages(), static_cast<int>(pages), static_cast<int>(i)), {}});
    }
  }
  return levels[static_cast<std::size_t>(level)];
}

const PageTargets::Level& PageTargets::level(int level) {
  return find(level);
}

const LayerTargets& PageTargets::together(GLuint texture, int level) {
  Level& own = find(level);
  if (!own.together.empty()) return own.together;
  own.together = make_layer_targets(texture, static_cast<int>(store_.layout().pages));
  static constexpr GLenum kBoth[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  for (std::size_t i = 0; i < own.together.size(); ++i) {
    const GLuint framebuffer = own.together[i].id();
    if (can_draw_layers()) {
      glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT1, store_.pages(), level);
    } else {
      glNamedFramebufferTextureLayer(framebuffer, GL_COLOR_ATTACHMENT1, store_.pages(), level, static_cast<GLint>(i));
    }
    glNamedFramebufferDrawBuffers(framebuffer, 2, kBoth);
  }
  return own.together;
}

}  // namespace foreview::batched
