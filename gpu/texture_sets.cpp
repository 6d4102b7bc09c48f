#include "foreview/gpu/texture_sets.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <string>
#include <utility>

#include "foreview/gpu/exposure.h"
#include "foreview/scene/errors.h"

namespace foreview {

namespace {

constexpr std::int64_t kLongestTime = 2'147'000'000;  // milliseconds, 24 days: what 32 bits hold

}  // namespace

TextureSets::TextureSets(const ChartLayout& layout, std::size_t polygons, Publishing publishing, Making making)
    : layout_(layout), polygons_(polygons), publishing_(publishing), sets_(set_count(publishing)) {
  assert(making == Making::whole || publishing == Publishing::buffered);
  for (Set& set : sets_) {
    set.polygon_states = GlBuffer::create();
    glNamedBufferStorage(set.polygon_states.id(), static_cast<GLsizeiptr>(polygons * 4 * sizeof(float)), nullptr,
                         GL_DYNAMIC_STORAGE_BIT);
    set.exposure = GlBuffer::create();
    glNamedBufferStorage(set.exposure.id(), sizeof(Exposure), nullptr, GL_DYNAMIC_STORAGE_BIT);
    clear_small_things(set);
  }
  // The first set is what there is to show before the first picture; the others are free.
  sets_[0].turn = 1;
  sets_[0].complete = true;
  if (making == Making::whole) {
    make_rest();
    return;
  }
  no_pages_ = make_texture_2d_array(GL_RGBA8, 1, 1, 1);
  glClearTexImage(no_pages_.id(), 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  no_capture_times_ = make_texture_2d_array(GL_R32I, 1, 1, 1);
  forget_capture_times(no_capture_times_);
  // The display may look at it before any fence.
  glFinish();
}

void TextureSets::make_pages(Set& set) {
  while (glGetError() != GL_NO_ERROR) {
  }
  GlTexture pages = make_texture_2d_array(GL_RGBA8, layout_.page_size, layout_.page_size,
                                          static_cast<int>(layout_.pages), kChartLevels);
  if (glGetError() == GL_OUT_OF_MEMORY) {
    throw GraphicsError("the graphics memory does not hold " +
                        std::to_string(sets_.size() * layout_.memory_bytes >> 20) +
                        " MiB of texture pages; use a lower density (--density)");
  }
  glTextureParameteri(pages.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(pages.id(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  clear_pages(pages);
  GlTexture capture_times = make_texture_2d_array(GL_R32I, layout_.page_size / kChartAlignment,
                                                  layout_.page_size / kChartAlignment, static_cast<int>(layout_.pages));
  forget_capture_times(capture_times);
  // The display may look at the first set before any fence.
  if (publishing_ == Publishing::buffered) glFinish();
  const std::lock_guard lock(mutex_);
  set.pages = std::move(pages);
  set.capture_times = std::move(capture_times);
}

void TextureSets::make_rest() {
  if (sets_[0].pages.id() != 0) return;
  for (Set& set : sets_) make_pages(set);
  if (publishing_ == Publishing::direct) return;
  std::vector<GLuint> pages;
  for (Set& set : sets_) {
    set.is_stale.resize(layout_.groups.size());
    set.stale.reserve(layout_.groups.size());
    pages.push_back(set.pages.id());
  }
  copier_ = std::make_unique<PageCopier>(layout_, std::move(pages));
  copier_->choose_method(0, 1);
  glFinish();
}

TextureSets::~TextureSets() = default;

std::size_t TextureSets::memory_bytes() const {
  const auto blocks = static_cast<std::size_t>(layout_.page_size / kChartAlignment);
  return sets_.size() * (layout_.memory_bytes + polygons_ * 4 * sizeof(float) +
                         layout_.pages * blocks * blocks * sizeof(std::int32_t));
}

void TextureSets::clear_pages(const GlTexture& pages) {
  for (int level = 0; level < kChartLevels; ++level) {
    glClearTexImage(pages.id(), level, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  }
}

void TextureSets::clear_small_things(const Set& set) {
  constexpr std::array<float, 4> kUnseen{0.5F, 0.5F, 0.5F, 0.0F};
  glClearNamedBufferData(set.polygon_states.id(), GL_RGBA32F, GL_RGBA, GL_FLOAT, kUnseen.data());
  constexpr Exposure kAsTheyAre;
  glNamedBufferSubData(set.exposure.id(), 0, sizeof kAsTheyAre, &kAsTheyAre);
}

void TextureSets::forget_capture_times(const GlTexture& capture_times) {
  constexpr std::int32_t kNever = kNeverCaptured;
  glClearTexImage(capture_times.id(), 0, GL_RED_INTEGER, GL_INT, &kNever);
}

void TextureSets::clear() {
  clear_pages(sets_[current_].pages);
  clear_small_things(sets_[current_]);
  forget_capture_times(sets_[current_].capture_times);
  newest_capture_.reset();
  epoch_.reset();
}

void TextureSets::forget_capture_times() {
  forget_capture_times(sets_[current_].capture_times);
  newest_capture_.reset();
  epoch_.reset();
}

std::int32_t TextureSets::capture_time_of(Timestamp stamp) {
  if (!epoch_) epoch_ = stamp;
  // Each by itself: the difference of two arbitrary stamps need not fit.
  const std::int64_t milliseconds = stamp.nanoseconds / 1'000'000 - epoch_->nanoseconds / 1'000'000;
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(milliseconds, -kLongestTime, kLongestTime));
}

void TextureSets::poll(Fences& done) {
  for (Set& set : sets_) {
    if (set.written && set.written->has_passed()) {
      set.complete = true;
      done.push_back(std::move(set.written));
    }
    if (set.read && set.read->has_passed()) done.push_back(std::move(set.read));
  }
}

std::size_t TextureSets::newest_complete() const {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < sets_.size(); ++i) {
    if (sets_[i].complete && (!best || sets_[i].turn > sets_[*best].turn)) best = i;
  }
  assert(best);  // never free, so never overwritten before another one is complete
  return *best;
}

std::optional<std::size_t> TextureSets::find_free() const {
  // What is newer than the newest complete picture is kept: else an extraction that is faster than the GPU carries it
  // out would write over each picture before the display could take it.
  const std::uint64_t complete = sets_[newest_complete()].turn;
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < sets_.size(); ++i) {
    const Set& set = sets_[i];
    if (i == newest_ || set.turn >= complete || set.read || (acquired_ > 0 && i == shown_)) continue;
    // The one written last lacks least.
    if (!best || set.turn > sets_[*best].turn) best = i;
  }
  return best;
}

bool TextureSets::begin(Begin how) {
  assert(!writing_);
  if (publishing_ == Publishing::direct) {
    writing_ = true;
    return true;
  }
  Fences done;
  std::size_t newest = 0;
  {
    const std::lock_guard lock(mutex_);
    poll(done);
    const std::optional<std::size_t> free = find_free();
    if (!free) return false;
    current_ = *free;
    newest = newest_;
    Set& set = sets_[current_];
    set.complete = false;
    // Superseded before it was complete; the new picture's commands come behind its own.
    done.push_back(std::move(set.written));
  }
  writing_ = true;
  if (how != Begin::replace) {
    source_ = newest;
    small_things_left_ = true;
    if (sets_[current_].all_stale) {
      copier_->begin_all(newest, current_);
    } else {
      copier_->begin(sets_[current_].stale, newest, current_);
    }
  }
  forget_stale(sets_[current_]);
  if (how == Begin::update) catch_up(catch_up_left());
  return true;
}

std::size_t TextureSets::catch_up_left() const {
  return publishing_ == Publishing::direct || !writing_ ? 0 : copier_->left() + (small_things_left_ ? 1 : 0);
}

void TextureSets::catch_up(std::size_t bytes) {
  if (small_things_left_) copy_small_things();
  small_things_left_ = false;
  if (copier_->left() > 0) copier_->run(bytes);
}

void TextureSets::abandon() {
  assert(writing_);
  writing_ = touching_all_ = small_things_left_ = false;
  if (publishing_ == Publishing::direct) return;
  // What it holds is neither one picture nor another.
  sets_[current_].all_stale = true;
  const std::lock_guard lock(mutex_);
  current_ = newest_;
}

void TextureSets::copy_small_things() {
  const Set &from = sets_[source_], &to = sets_[current_];
  glCopyNamedBufferSubData(from.polygon_states.id(), to.polygon_states.id(), 0, 0,
                           static_cast<GLsizeiptr>(polygons_ * 4 * sizeof(float)));
  glCopyNamedBufferSubData(from.exposure.id(), to.exposure.id(), 0, 0, sizeof(Exposure));
  // All of it, less than a hundredth of the pages: cheaper than a command for each chart.
  const int blocks = layout_.page_size / kChartAlignment;
  glCopyImageSubData(from.capture_times.id(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, to.capture_times.id(),
                     GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, blocks, blocks, static_cast<GLsizei>(layout_.pages));
}

void TextureSets::forget_stale(Set& set) {
  for (const std::uint32_t group : set.stale) set.is_stale[group] = false;
  set.stale.clear();
  set.all_stale = false;
}

bool TextureSets::has_free_set() {
  if (publishing_ == Publishing::direct) return true;
  Fences done;
  const std::lock_guard lock(mutex_);
  poll(done);
  return find_free().has_value();
}

void TextureSets::wait_for_free_set() {
  if (publishing_ == Publishing::direct) return;
  for (;;) {
    Fences done;
    std::shared_ptr<GlFence> awaited;
    {
      const std::lock_guard lock(mutex_);
      poll(done);
      if (find_free()) return;
      // Own pictures first: the older ones of those on the way, then the frames that still read.
      const auto take_oldest = [&](std::shared_ptr<GlFence> Set::*fence) {
        std::uint64_t oldest = 0;
        for (const Set& set : sets_) {
          if (!(set.*fence) || (awaited && set.turn > oldest)) continue;
          awaited = set.*fence;
          oldest = set.turn;
        }
      };
      take_oldest(&Set::written);
      if (!awaited) take_oldest(&Set::read);
    }
    // A display holds one set at a time; of two that are not the newest, one has nothing but frames in flight.
    assert(awaited);
    awaited->wait();
  }
}

void TextureSets::touch_all() {
  assert(writing_);
  touching_all_ = true;
}

void TextureSets::end(const std::vector<std::uint32_t>& touched, bool is_picture,
                      const std::optional<Timestamp>& captured) {
  assert(writing_);
  writing_ = false;
  if (is_picture) ++pictures_;
  newest_capture_ = std::max(newest_capture_, captured);  // none is less than any
  if (publishing_ == Publishing::direct) {
    sets_[0].picture = pictures_;
    sets_[0].newest_capture = newest_capture_;
    sets_[0].epoch = epoch();
    touching_all_ = false;
    return;
  }
  for (std::size_t i = 0; i < sets_.size(); ++i) {
    Set& set = sets_[i];
    if (i == current_) continue;
    set.all_stale = set.all_stale || touching_all_;
    for (const std::uint32_t polygon : touched) {
      const std::uint32_t group = layout_.charts[polygon].group;
      if (set.is_stale[group]) continue;
      set.is_stale[group] = true;
      set.stale.push_back(group);
    }
  }
  touching_all_ = false;
  auto fence = std::make_shared<GlFence>(GlFence::insert());
  const std::lock_guard lock(mutex_);
  Set& set = sets_[current_];
  set.turn = sets_[newest_].turn + 1;
  set.picture = pictures_;
  set.newest_capture = newest_capture_;
  set.epoch = epoch();
  set.written = std::move(fence);
  newest_ = current_;
}

TextureSets::Shown TextureSets::acquire() {
  Fences done;
  const std::lock_guard lock(mutex_);
  if (acquired_++ == 0 && publishing_ == Publishing::buffered) {
    poll(done);
    shown_ = newest_complete();
  }
  const Set& set = sets_[shown_];
  const bool made = set.pages.id() != 0;
  return {made ? set.pages.id() : no_pages_.id(),
          set.polygon_states.id(),
          set.exposure.id(),
          made ? set.capture_times.id() : no_capture_times_.id(),
          set.picture,
          set.newest_capture,
          set.epoch};
}

void TextureSets::release() {
  {
    const std::lock_guard lock(mutex_);
    assert(acquired_ > 0);
    if (acquired_ > 1 || publishing_ == Publishing::direct) {
      --acquired_;
      return;
    }
  }
  // Of frames in flight on one set the last fence stands for all: one context's commands are done in order.
  auto fence = std::make_shared<GlFence>(GlFence::insert());
  const std::lock_guard lock(mutex_);
  --acquired_;
  sets_[shown_].read.swap(fence);
}

}  // namespace foreview
