#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "foreview/gpu/gl_objects.h"
#include "foreview/gpu/page_copier.h"
#include "foreview/scene/chart_layout.h"
#include "foreview/scene/timestamp.h"

namespace foreview {

/// How finished textures reach the display (spec 10, design 4).
enum class Publishing {
  direct,    ///< one set of textures: what extraction writes is what the display reads (same thread, in turn)
  buffered,  ///< three sets: shown (frames in flight), newest complete, being written; two threads, two contexts
};
/// Sets of textures that this takes: a budget for all texture memory is divided by it to get
/// ChartOptions::memory_budget, which counts one set.
[[nodiscard]] constexpr std::size_t set_count(Publishing publishing) {
  return publishing == Publishing::direct ? 1 : 3;
}

/// What a constructor makes.
enum class Making {
  whole,
  in_part,  ///< as little as a display needs to show that nothing has been seen; the rest is made later
};

/// A time of capture that is none; in shaders the same in capture_times.glsl.
inline constexpr std::int32_t kNeverCaptured = std::numeric_limits<std::int32_t>::min();

/// The sets of textures behind a TextureStore, and who may use which. Textures are created once; while running, only
/// fences come and go.
///
/// Pictures are written one after the other, each into a set that neither the display nor the newest picture needs; it
/// is first brought up to what the newest picture holds. A picture is *complete* when the fence behind its commands has
/// passed. The display takes the newest complete one and guards it with a fence behind each frame. Both sides only ask
/// whether fences have passed, under a mutex that is never held while waiting for anything; so neither can hold up the
/// other, and because a set changes hands only after its fence was seen to have passed, no server-side wait is needed.
class TextureSets {
 public:
  /// All sets hold nothing seen. Errors as TextureStore's constructor; `layout` must outlive this. May wait for the
  /// GPU.
  TextureSets(const ChartLayout& layout, std::size_t polygons, Publishing publishing, Making making = Making::whole);
  ~TextureSets();
  TextureSets(const TextureSets&) = delete;
  TextureSets& operator=(const TextureSets&) = delete;

  // Extraction's side: one thread, its context current.

  /// See TextureStore::make_rest().
  void make_rest();
  /// The set being written, else the newest.
  [[nodiscard]] GLuint pages() const { return sets_[current_].pages.id(); }
  [[nodiscard]] GLuint polygon_states() const { return sets_[current_].polygon_states.id(); }
  [[nodiscard]] GLuint exposure() const { return sets_[current_].exposure.id(); }
  [[nodiscard]] GLuint capture_times() const { return sets_[current_].capture_times.id(); }
  [[nodiscard]] bool is_writing() const { return writing_; }
  [[nodiscard]] Publishing publishing() const { return publishing_; }
  [[nodiscard]] std::uint64_t pictures_ended() const { return pictures_; }
  [[nodiscard]] std::size_t memory_bytes() const;

  enum class Begin {
    update,   ///< bring the set up to what the newest one holds
    later,    ///< the same, but by catch_up()
    replace,  ///< all of it is going to be written: leave its contents as they are
  };
  /// See TextureStore::begin_picture().
  bool begin(Begin how);
  /// See TextureStore::catch_up().
  void catch_up(std::size_t bytes);
  [[nodiscard]] std::size_t catch_up_left() const;
  /// See TextureStore::abandon_picture().
  void abandon();
  [[nodiscard]] bool has_free_set();
  void wait_for_free_set();
  /// Ends what begin() began; `touched` are the polygons whose charts were written. `is_picture`: Shown counts it.
  void end(const std::vector<std::uint32_t>& touched, bool is_picture, const std::optional<Timestamp>& captured = {});
  /// See TextureStore::capture_time_of().
  [[nodiscard]] std::int32_t capture_time_of(Timestamp stamp);
  [[nodiscard]] Timestamp epoch() const { return epoch_.value_or(Timestamp()); }
  /// From now to the end, every chart counts as touched.
  void touch_all();
  /// Nothing seen: all texels transparent black, all polygons mid grey, all gains 1, no time of capture, in the set
  /// that pages() means.
  void clear();
  /// No time of capture in the set that pages() means.
  void forget_capture_times();

  // Display's side: one thread, its context current.

  struct Shown {
    GLuint pages = 0, polygon_states = 0, exposure = 0, capture_times = 0;
    std::uint64_t picture = 0;
    std::optional<Timestamp> newest_capture;
    Timestamp epoch;
  };
  Shown acquire();
  void release();

  /// How sets are brought up to date; of Publishing::buffered only.
  [[nodiscard]] PageCopier& copier() { return *copier_; }

 private:
  struct Set {
    // Fixed once made; then, guarded by the mutex, given to the display.
    GlTexture pages, capture_times;
    GlBuffer polygon_states, exposure;
    // Extraction's own: the groups whose charts changed since this set was last written.
    std::vector<std::uint32_t> stale;
    std::vector<bool> is_stale;
    bool all_stale = false;
    // Both sides', guarded by the mutex.
    std::uint64_t turn = 0;     ///< when it was last written: larger is newer
    std::uint64_t picture = 0;  ///< Shown::picture
    std::optional<Timestamp> newest_capture;
    Timestamp epoch;
    bool complete = false;
    std::shared_ptr<GlFence> written;  ///< behind its picture, until it is known to have passed
    std::shared_ptr<GlFence> read;     ///< behind the last frame that read it, until it is known to have passed
  };
  using Fences = std::vector<std::shared_ptr<GlFence>>;
  // With the mutex held; fences no longer needed are moved to `done`, to be deleted after it was let go.
  void poll(Fences& done);
  [[nodiscard]] std::size_t newest_complete() const;
  [[nodiscard]] std::optional<std::size_t> find_free() const;

  void make_pages(Set& set);
  void copy_small_things();
  static void forget_stale(Set& set);
  static void forget_capture_times(const GlTexture& capture_times);
  static void clear_pages(const GlTexture& pages);
  static void clear_small_things(const Set& set);

  const ChartLayout& layout_;
  const std::size_t polygons_;
  const Publishing publishing_;
  std::vector<Set> sets_;
  /// Until make_rest(): one texel that nobody has seen, shown in the place of the first set's. Polygons that no picture
  /// has shown have colours without it.
  GlTexture no_pages_, no_capture_times_;
  std::unique_ptr<PageCopier> copier_;

  // Extraction's own.
  std::size_t current_ = 0;  ///< being written, else newest
  std::size_t source_ = 0;   ///< the set that the one being written is brought up to
  bool small_things_left_ = false;
  bool writing_ = false, touching_all_ = false;
  std::uint64_t pictures_ = 0;
  std::optional<Timestamp> newest_capture_, epoch_;

  // Guarded by the mutex.
  mutable std::mutex mutex_;
  std::size_t newest_ = 0;  ///< last ended, complete or not
  std::size_t shown_ = 0;
  unsigned acquired_ = 0;  ///< acquire() less release()
};

}  // namespace foreview
