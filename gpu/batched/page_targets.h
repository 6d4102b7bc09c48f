#pragma once
#include <map>
#include <vector>

#include "foreview/gpu/gl_objects.h"
#include "foreview/gpu/texture_store.h"

namespace foreview::batched {

/// Where a pass draws: all layers of an array texture at once, where a vertex shader may choose the layer, else one
/// framebuffer a layer.
using LayerTargets = std::vector<GlFramebuffer>;

/// Whether vertex shaders may choose the layer (GL_ARB_shader_viewport_layer_array).
[[nodiscard]] bool can_draw_layers();
/// For tests: pipelines made from now on draw layer by layer, as on drivers that cannot do otherwise.
void forbid_drawing_layers(bool forbidden);
/// What shaders that draw into layers are compiled with.
[[nodiscard]] const char* layer_defines();
[[nodiscard]] LayerTargets make_layer_targets(GLuint texture, int layers, int level = 0);

/// A store's sets of pages as targets, and as textures of one level each, so that one level can be read while another
/// is drawn.
class PageTargets {
 public:
  explicit PageTargets(const TextureStore& store) : store_(store) {}
  struct Level {
    GlTexture view;
    LayerTargets targets;
    LayerTargets together;
  };
  /// A level of the set that the store's pages() means now.
  [[nodiscard]] const Level& level(int level);
  /// Both at once: a texture of the level's size and as many layers (colour 0), which must be the same at every call
  /// for this level, and the level itself (colour 1).
  [[nodiscard]] const LayerTargets& together(GLuint texture, int level);

 private:
  [[nodiscard]] Level& find(int level);

  const TextureStore& store_;
  std::map<GLuint, std::vector<Level>> sets_;  ///< by the set's pages; at most three
};

}  // namespace foreview::batched
