#pragma once
#include <vector>

#include "foreview/gpu/gl_objects.h"

namespace foreview {

/// Fills gaps in a predicted view from the colours around them, as they are seen (the pyramid over holes of spec 9,
/// taken from the polygon to the picture): holes of the mesh, shadows of occluders and the rim of what was seen so far
/// go over many polygons, or lie on none.
///
/// Alpha tells what is known of a pixel (view_known.glsl). What was never seen of a polygon takes the colours around it
/// where they lie on a surface that goes on there (as 1/z tells), and keeps its chart's fill beside a silhouette. What
/// lies behind everything (backdrop, back faces, nothing at all) stays where it is wide; where it shows through a crack
/// it is what the mesh lacks, and gives way. How wide a crack may be goes with the view's height: about a thirtieth.
/// Pixels that are known stay as they are, to the bit.
///
/// Every fill is a mean that reaches as far as it has to: levels of half the size, each the mean of what is known below
/// (pull), and down again where nothing is (push). Needs a current context in every member.
class GapFiller {
 public:
  GapFiller();

  /// Of a framebuffer, these columns (from `first_x` up to, not with, `end_x`) and rows. Its colour is RGBA8, its depth
  /// reversed 32F, with any number of samples: of each pixel their mean decides, and all get what is filled. Leaves
  /// alpha at 1, and no state behind. `unseen`: also
  /// what was never seen of polygons, else cracks alone.
  void fill(GLuint framebuffer, int first_x, int end_x, int y, int height, bool unseen);

 private:
  void resize(int width, int height);
  struct Level {
    GlTexture pulled, pulled_depth, filled;
    GlFramebuffer into_pulled, into_filled;
    int width = 0, height = 0;
  };
  GlProgram first_pull_, pull_, push_, finish_;
  GlSampler sampler_;
  GlVertexArray no_vertices_;
  GlTexture view_, view_depth_;
  GlFramebuffer into_view_;
  int width_ = 0, height_ = 0;
  std::vector<Level> levels_;  ///< from half the view's size on
};

}  // namespace foreview
