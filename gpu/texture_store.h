#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "foreview/gpu/exposure.h"
#include "foreview/gpu/gl_objects.h"
#include "foreview/gpu/texture_sets.h"
#include "foreview/scene/chart_layout.h"
#include "foreview/scene/polygon_model.h"

namespace foreview {

/// The charts of a model in atlas pages on the GPU (design 4). One immutable RGBA8 2D array texture, one layer a page,
/// kChartLevels mip levels. Level 0: colour and provenance (alpha 1 observed, 0 filled or nothing); levels above: the
/// mean of the *filled* level 0's colours, and in alpha the mean of level 0's alpha.
/// Beside it, one state per polygon in a buffer: mean colour and whether a picture has ever shown it.
///
/// With Publishing::buffered all this exists three times, so that a picture's textures appear at once and nobody waits:
/// extraction writes one set between begin_picture() and end_picture(), the display reads another one between acquire()
/// and release(). Each side may have a thread of its own, with a context of its own that shares objects with the other.
/// All members but acquire() and release() are extraction's; construction and destruction must not overlap with either.
class TextureStore {
 public:
  /// Needs a current context, as do all members. Allocates once; nothing but fences is created or deleted until
  /// destruction. Holds copies of `model` and `layout`. Begins as after clear(). With `buffered` it takes some
  /// milliseconds to find out how charts are best copied here. Throws InputError if the driver's limits do not allow
  /// the layout, GraphicsError if it has not the memory.
  /// With Making::in_part (`buffered` only) it is soon done, and only acquire() and release() may be used, which give
  /// nothing seen, until make_rest(): nearly all the time goes into the pages' memory.
  TextureStore(const PolygonModel& model, ChartLayout layout, Publishing publishing = Publishing::direct,
               Making making = Making::whole);
  ~TextureStore();
  TextureStore(const TextureStore&) = delete;
  TextureStore& operator=(const TextureStore&) = delete;

  [[nodiscard]] const ChartLayout& layout() const { return layout_; }
  [[nodiscard]] const PolygonModel& model() const { return model_; }
  /// Of all sets, pages with levels and states. A budget for it is divided by set_count() for lay_out_charts().
  [[nodiscard]] std::size_t memory_bytes() const { return sets_->memory_bytes(); }

  /// After Making::in_part, in any one thread, while the display goes on. Throws GraphicsError as the constructor does.
  void make_rest() { sets_->make_rest(); }

  // Extraction's view: the set being written, else the newest, complete or not. So do all members that read or write.

  /// GL_TEXTURE_2D_ARRAY, RGBA8, kChartLevels levels, page_size x page_size x pages; filter trilinear, clamped.
  [[nodiscard]] GLuint pages() const { return sets_->pages(); }
  /// GL_SHADER_STORAGE_BUFFER of one PolygonState per polygon (std430).
  struct PolygonState {
    float red = 0, green = 0, blue = 0;  ///< mean colour of what was observed, 0..1; or the neighbours', if never seen
    float seen = 0;                      ///< 1 once any texel was observed, else 0; 0.5: colour spread from neighbours
    bool operator==(const PolygonState&) const = default;
  };
  [[nodiscard]] GLuint polygon_states() const { return sets_->polygon_states(); }

  /// Buffer of one Exposure (gpu/exposure.h), by which the display changes colours of textures and states: 1 unless an
  /// extraction writes something else.
  [[nodiscard]] GLuint exposure() const { return sets_->exposure(); }

  /// When what the charts show was captured: GL_TEXTURE_2D_ARRAY, R32I, one texel for each block of kChartAlignment x
  /// kChartAlignment texels of the pages (x / kChartAlignment, y / kChartAlignment, page): the stamp of the newest
  /// picture of which the block took its colours, in milliseconds since epoch(), or kNeverCaptured. Of textures that
  /// were loaded no time is known. Shaders look it up with capture_times.glsl.
  /// The batched pipeline asks for one texel of the block, the one nearest to its middle that lies in a polygon; the
  /// per-polygon pipeline says when it wrote the polygon last.
  [[nodiscard]] GLuint capture_times() const { return sets_->capture_times(); }
  /// A stamp as capture_times() has it. The first one asked for since the store was made, cleared or
  /// loaded becomes the epoch; what is more than 24 days away
  /// from that counts as 24 days.
  [[nodiscard]] std::int32_t capture_time_of(Timestamp stamp) { return sets_->capture_time_of(stamp); }
  [[nodiscard]] Timestamp epoch() const { return sets_->epoch(); }
  /// Sets the blocks of these polygons' charts to a time of capture, in the set being written.
  void set_capture_time(const std::vector<std::uint32_t>& polygons, std::int32_t time);

  /// Chooses a free set and brings it up to what the newest one holds (it copies what changed since the set was last
  /// written); from here to end_picture() it is the set that pages() means. False, and nothing done, if there is none
  /// free: the display still reads both sets that are not the newest, or extraction is two pictures ahead of the GPU.
  /// Try later, or wait_for_free_set(). Waits for nothing. With `direct`: true.
  [[nodiscard]] bool begin_picture();
  /// The same, but the copy is left to catch_up(), which must be called until nothing is left before charts are read or
  /// written: for extraction in slices.
  [[nodiscard]] bool begin_picture_in_pieces();
  /// Bytes still to be copied, with what a copy costs beside them.
  [[nodiscard]] std::size_t catch_up_left() const { return sets_->catch_up_left(); }
  /// Copies about so many of them.
  void catch_up(std::size_t bytes) { sets_->catch_up(bytes); }
  /// Instead of end_picture(): what was written since begin_picture() is never shown, and pages() means the newest set
  /// again. With `direct` it stays as it is: only clear() or write_pages() make that whole.
  void abandon_picture() { sets_->abandon(); }
  /// Whether begin_picture() would be true now. Waits for nothing.
  [[nodiscard]] bool has_free_set() const { return sets_->has_free_set(); }
  /// Until begin_picture() would be true: for the GPU, and a display's frames in flight, not for a display that has
  /// acquired and not yet released.
  void wait_for_free_set();
  /// Hands the picture over, with a fence and a flush: the display takes it once the GPU has carried it out. `touched`
  /// must name all polygons whose charts were written (in any order, also twice). Shaders' writes of charts and states
  /// must have barriers behind them, for buffer updates too, as update_levels() and spread_to_never_seen() leave them.
  /// (None is issued here: a software rasteriser takes any barrier for a reason to finish all drawing, the display's
  /// too.)
  /// `captured` is the picture's stamp, for Shown::newest_capture.
  void end_picture(const std::vector<std::uint32_t>& touched_polygons, const std::optional<Timestamp>& captured = {});
  /// How begin_picture() copies, with `buffered`: for tests and measurements. The result is the same, bit by bit.
  void set_copy_method(PageCopier::Method method) { sets_->copier().set_method(method); }
  [[nodiscard]] PageCopier::Method copy_method() const { return sets_->copier().method(); }
  /// Calls of end_picture() so far.
  [[nodiscard]] std::uint64_t pictures_ended() const { return sets_->pictures_ended(); }

  /// The display's side. `picture`: pictures_ended() of what is shown; 0 before the first one. `newest_capture`: the
  /// greatest stamp of the pictures in it, since it was last cleared or loaded; `epoch`: that of capture_times.
  using Shown = TextureSets::Shown;
  /// What to draw a frame with: the newest picture that the GPU has carried out. Never waits. The pages and states must
  /// be bound anew after each acquire(), even if they are the same as before: else GL does not promise to show what
  /// another context wrote. Calls may nest: an inner one gives what the outermost gave, so that all views of a frame
  /// show the same picture.
  Shown acquire() const { return sets_->acquire(); }
  /// After the frame's commands were issued: flushes them, with a fence behind which the set is free again. All frames
  /// come from one context.
  void release() const { sets_->release(); }

  // Members that compute do so on the GPU, without waiting for it where not said otherwise, and change the current
  // context's program, and its bindings of the first few texture and image units and shader storage buffers. They issue
  // the memory barriers that writers before and readers after them need.
  // With `buffered`, the members below that write textures or states either do so as part of a picture that was begun,
  // or publish what they write themselves (and then wait for a free set); update_levels() is only for the former.

  /// Rebuilds levels 1.. of the blocks of the given polygons' groups from level 0, never across blocks; all in one
  /// dispatch. The colour of a level's texel is the mean of all level 0 texels under it, and so is its alpha.
  void update_levels(const std::vector<std::uint32_t>& polygons);
  /// Gives polygons that no picture has shown their neighbours' colours, through the mesh's adjacency: from the rim of
  /// what was seen inwards, until nothing changes; polygons not connected to any seen one take the mean of all seen.
  /// Reads polygon_states (seen == 1 as sources) and writes the others: the mean of the neighbours coloured so far, and
  /// seen = 0.5. Without any seen polygon: mid grey, seen = 0. Waits for the GPU once every 16 rims.
  void spread_to_never_seen();
  /// The same, for every picture: at most `max_rims` rims deep, and the rest takes the mean of all seen, too. Depends
  /// on the seen polygons' states only. No read-back and no wait; costs a pass for each rim that there is.
  void spread_to_never_seen(unsigned max_rims);
  /// The same in pieces, all in order, within one picture.
  void spread_to_never_seen(unsigned max_rims, unsigned first_piece, unsigned pieces);
  [[nodiscard]] static constexpr unsigned spread_pieces(unsigned max_rims) { return max_rims + 2; }
  static constexpr unsigned kRimsPerPicture = 16;
  /// Nothing seen: all texels transparent black, all polygons mid grey, all gains 1, no time of capture.
  void clear();

  /// Whole pages as CV_8UC4, BGRA order, level 0, as they are kept: exposure() is not in them.
  [[nodiscard]] std::vector<cv::Mat> read_pages() const;
  [[nodiscard]] std::vector<PolygonState> read_polygon_states() const;
  [[nodiscard]] Exposure read_exposure() const;
  /// capture_times(), CV_32S, one a page.
  [[nodiscard]] std::vector<cv::Mat> read_capture_times() const;
  /// Pages and states with the colours that are shown, and so for an exposure of 1.
  struct Contents {
    std::vector<cv::Mat> pages;
    std::vector<PolygonState> states;
  };
  [[nodiscard]] Contents read_as_shown() const;
  /// Replaces all: pages as read_pages() gives them (levels are rebuilt), and the states; the exposure becomes 1, and
  /// no time of capture is known.
  void write_pages(const std::vector<cv::Mat>& pages, const std::vector<PolygonState>& states);
  /// Texels of level 0 with alpha 1, by read-back: for statistics and tests.
  [[nodiscard]] std::size_t count_observed_texels() const;

 private:
  template <class Write>
  void publish(TextureSets::Begin how, const Write& write);
  void spread(unsigned max_rims, bool may_wait);
  void spread_in_current_set(unsigned max_rims, bool may_wait);
  void begin_spreading();
  void spread_rims(unsigned first, unsigned count);
  void end_spreading();
  void bind_for_spreading();

  PolygonModel model_;
  ChartLayout layout_;
  std::unique_ptr<TextureSets> sets_;
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
