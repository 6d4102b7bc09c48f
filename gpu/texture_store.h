#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/chart_layout.h"
#include "foreview/scene/polygon_model.h"

namespace foreview {

/// The charts of a model in atlas pages on the GPU (design 4). One immutable RGBA8 2D array texture, one layer a page,
/// kChartLevels mip levels. Level 0: colour and provenance (alpha 1 observed, 0 filled or nothing); levels above: the
/// mean of the *filled* level 0's colours, and in alpha the mean of level 0's alpha.
/// Beside it, one state per polygon in a buffer: mean colour and whether a picture has ever shown it.
class TextureStore {
 public:
  /// Needs a current context, as do all members. Allocates once; nothing is created or deleted until destruction. Holds
  /// copies of `model` and `layout`. Begins as after clear(). Throws InputError if the driver's limits do not allow the
  /// layout, GraphicsError if it has not the memory.
  TextureStore(const PolygonModel& model, ChartLayout layout);
  ~TextureStore();
  TextureStore(const TextureStore&) = delete;
  TextureStore& operator=(const TextureStore&) = delete;

  [[nodiscard]] const ChartLayout& layout() const { return layout_; }
  [[nodiscard]] const PolygonModel& model() const { return model_; }
  /// GL_TEXTURE_2D_ARRAY, RGBA8, kChartLevels levels, page_size x page_size x pages; filter trilinear, clamped.
  [[nodiscard]] GLuint pages() const { return pages_.id(); }
  /// GL_SHADER_STORAGE_BUFFER of one PolygonState per polygon (std430).
  struct PolygonState {
    float red = 0, green = 0, blue = 0;  ///< mean colour of what was observed, 0..1; or the neighbours', if never seen
    float seen = 0;                      ///< 1 once any texel was observed, else 0; 0.5: colour spread from neighbours
  };
  [[nodiscard]] GLuint polygon_states() const { return polygon_states_.id(); }

  // The members below that compute do so on the GPU, without waiting for it where not said otherwise, and change the
  // current context's program, and its bindings of the first few texture and image units and shader storage buffers.
  // They issue the memory barriers that writers before and readers after them need.

  /// Rebuilds levels 1.. of the blocks of the given polygons' groups from level 0, never across blocks; all in one
  /// dispatch. The colour of a level's texel is the mean of all level 0 texels under it, and so is its alpha.
  void update_levels(const std::vector<std::uint32_t>& polygons);
  /// Gives polygons that no picture has shown their neighbours' colours, through the mesh's adjacency: from the rim of
  /// what was seen inwards, until nothing changes; polygons not connected to any seen one take the mean of all seen.
  /// Reads polygon_states (seen == 1 as sources) and writes the others: the mean of the neighbours coloured so far, and
  /// seen = 0.5. Without any seen polygon: mid grey, seen = 0. Waits for the GPU once every 16 rims.
  void spread_to_never_seen();
  /// Nothing seen: all texels transparent black, all polygons mid grey.
  void clear();

  /// Whole pages as CV_8UC4, BGRA order, level 0.
  [[nodiscard]] std::vector<cv::Mat> read_pages() const;
  [[nodiscard]] std::vector<PolygonState> read_polygon_states() const;
  /// Replaces all: pages as read_pages() gives them (levels are rebuilt), and the states.
  void write_pages(const std::vector<cv::Mat>& pages, const std::vector<PolygonState>& states);
  /// Texels of level 0 with alpha 1, by read-back: for statistics and tests.
  [[nodiscard]] std::size_t count_observed_texels() const;

 private:
  PolygonModel model_;
  ChartLayout layout_;
  GlTexture pages_;
  GlBuffer polygon_states_;
  struct Tools;
  std::unique_ptr<Tools> tools_;
};

/// Keeps what has been seen between runs: a directory with page-000.png ... (RGBA, lossless, alpha = provenance),
/// polygon-states.csv and textures.yaml (see textures_format.h). Files are written beside and renamed, textures.yaml
/// last; other files of the directory are left alone. Throws InputError naming the file where the disk refuses.
void save_textures(const TextureStore& store, const std::filesystem::path& directory);
/// Throws InputError naming file and expectation where the files are damaged or belong to another model or layout; the
/// store is changed only if all is well.
void load_textures(TextureStore& store, const std::filesystem::path& directory);

/// The textured model as binary glTF 2.0, for any viewer: one mesh per part, one PNG texture per atlas page (embedded,
/// cut to what is used of it), unlit material, colours of never-seen polygons from polygon_states as vertex colours.
/// Nodes are posed by world_from_part (one per part) under a root node that turns our z up into glTF's y up. The
/// backdrop is left out unless asked for. Written beside and renamed; InputError where the disk refuses.
void export_glb(const TextureStore& store, const std::vector<Pose>& world_from_part, const std::filesystem::path& file,
                bool with_backdrop = false);

}  // namespace foreview
