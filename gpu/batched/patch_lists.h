#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "foreview/gpu/batched/chart_geometry.h"
#include "foreview/gpu/batched/chart_tables.h"
#include "foreview/gpu/batched/page_targets.h"
#include "foreview/gpu/batched/picture_bounds.h"
#include "foreview/gpu/batched/picture_setup.h"
#include "foreview/gpu/gl_objects.h"

namespace foreview::batched {

/// A part of something that is counted.
struct Run {
  std::size_t first = 0, count = 0;
};

/// The patches that a picture concerns, listed by the GPU for the GPU: nobody waits for the lists.
class PatchLists {
 public:
  enum List : GLuint {
    touched = 0,  ///< texels may have changed
    renewed = 1,  ///< levels 1 to 3 must be made anew
    holed = 2,    ///< of those, with holes at level 0
  };

  PatchLists(const ChartGeometry& geometry, const ChartTables& tables, int page_size);
  /// No patch was ever touched.
  void clear();
  /// Begins a picture: all patches of `charts`, which must have all of setup.charts(), are candidates.
  void begin(const PictureSetup& setup, const std::vector<std::uint32_t>& charts, const CameraModel& camera);
  /// Lists as touched, of the candidates, those that may take something from the picture; all of them can be filled
  /// anew. For all candidates, in any number of calls. The setup must be bound.
  void touch(const CameraModel& camera, double near_plane, const PictureBounds& bounds, const Run& candidates);
  /// Lists all patches there are as touched.
  void touch_all();
  /// After touch(): lists what must be filled anew, and gives level 4 of `pages` its colours. `filled` and `pulled` are
  /// level 4 of the fill (alpha 1: changed) and of what was observed. As often as touch().
  void renew(GLuint filled, GLuint pulled, GLuint pages, const Run& candidates);
  /// Draws a list's patches as squares at a level of the pages with the program in use, into all pages. Locations 0 to
  /// 4 of its uniforms are batched_patch.vert.glsl's. All of them, or a run of the list.
  void draw(List list, int level, const LayerTargets& into, const std::optional<Run>& patches = {});
  /// Runs the program in use over the touched patches: a group for each kPatchesPerGroup of them. Location 10 is the
  /// first group. All of them, or a run of such groups.
  void dispatch_touched(const std::optional<Run>& groups = {}) const;
  static constexpr GLuint kPatchesPerGroup = 16;
  /// Has the lists' lengths, and which patches were touched, copied to where the CPU can read them once the GPU has
  /// done all that was issued so far.
  void fetch();
  /// What fetch() brought.
  [[nodiscard]] std::array<std::size_t, 3> fetched_lengths() const;
  [[nodiscard]] std::span<const std::uint32_t> fetched_touched() const;
  /// Binds what batched_patches.glsl reads.
  void bind() const;
  /// Patches that touch() asked about; batched_patches' candidates.
  [[nodiscard]] GLuint candidate_count() const { return static_cast<GLuint>(candidates_.size()); }
  [[nodiscard]] GLuint picture_number() const { return picture_number_; }
  /// How long the lists are. Waits for the GPU.
  [[nodiscard]] std::array<std::size_t, 3> lengths() const;

 private:
  struct DrawCommand {
    GLuint count = 0, instances = 1, first = 0, base = 0;
  };
  struct Commands {
    std::array<DrawCommand, 3> draws;
    std::array<GLuint, 3> touched_groups{0, 1, 1};  ///< of a dispatch
  };
  [[nodiscard]] static std::array<std::size_t, 3> lengths_of(const std::array<DrawCommand, 3>& commands);
  void set_commands(const Commands& commands);
  [[nodiscard]] const Commands& fetched_commands() const;
  void dispatch_candidates(const Run& candidates) const;

  const ChartGeometry& geometry_;
  const ChartTables& tables_;
  int page_size_;
  GlProgram touch_, renew_;
  GlBuffer flags_, commands_, lists_, candidate_buffer_, slack_buffer_, fetched_;
  const std::byte* fetched_bytes_ = nullptr;  ///< of fetched_: Commands, then the touched patches
  GlVertexArray no_vertices_;
  std::vector<std::uint32_t> candidates_;
  GLuint picture_number_ = 0;
};

}  // namespace foreview::batched
