#include "foreview/gpu/page_copier.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <chrono>
#include <limits>
#include <utility>

#include "foreview/gpu/draw_tally.h"

namespace foreview {

static_assert(kChartAlignment == 16 && kChartLevels == 5, "copy_blocks.comp.glsl copies levels 0..4 of 16 x 16 blocks");

namespace {

/// What a copy command costs beside its bytes, expressed in bytes: about 1 us at 10 GB/s.
constexpr std::size_t kBytesPerCommand = 10'000;
/// Of a block, with all its levels.
constexpr std::size_t kBytesPerBlock = (256 + 64 + 16 + 4 + 1) * 4;
/// Whole pages are copied in bands of so many rows.
constexpr int kBandRows = 32;

std::size_t blocks_of(const ChartGroup& group) {
  return static_cast<std::size_t>(group.size.x / kChartAlignment) *
         static_cast<std::size_t>(group.size.y / kChartAlignment);
}

}  // namespace

PageCopier::PageCopier(const ChartLayout& layout, std::vector<GLuint> sets)
    : layout_(layout),
      sets_(std::move(sets)),
      program_(make_compute_program("copy_blocks.comp.glsl")),
      blocks_(layout),
      shares_(layout.pages) {
  for (const GLuint set : sets_) {
    GLuint id = 0;
    glGenTextures(1, &id);
    glTextureView(id, GL_TEXTURE_2D_ARRAY, set, GL_R32UI, 0, kChartLevels, 0, layout.pages);
    bits_.emplace_back(id);
    // Integers cannot be filtered; asking for it would make the texture unreadable.
    glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_NEAREST_MIPMAP_NEAREST);
    glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  }
}

void PageCopier::copy(const std::vector<std::uint32_t>& groups, std::size_t from, std::size_t to) {
  begin(groups, from, to);
  if (left_ > 0) run(left_);
}

std::size_t PageCopier::Command::cost() const {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4 + kBytesPerCommand;
}

void PageCopier::restart(std::size_t from, std::size_t to) {
  assert(from != to);
  from_ = from;
  to_ = to;
  left_ = next_ = 0;
  commands_.clear();
}

void PageCopier::begin(const std::vector<std::uint32_t>& groups, std::size_t from, std::size_t to) {
  restart(from, to);
  by_commands_ = method_ == Method::commands;
  if (groups.empty()) return;
  if (by_commands_) {
    list_commands(groups);
  } else {
    blocks_.list(groups);
    left_ = blocks_.size() * kBytesPerBlock;
  }
}

void PageCopier::begin_all(std::size_t from, std::size_t to) {
  restart(from, to);
  by_commands_ = true;
  for (int page = 0; page < static_cast<int>(layout_.pages); ++page) {
    for (int level = 0; level < kChartLevels; ++level) add_level(level, page);
  }
}

void PageCopier::add(const Command& command) {
  commands_.push_back(command);
  left_ += command.cost();
}

void PageCopier::add_level(int level, int page) {
  const int size = layout_.page_size >> level;
  for (int row = 0; row < size; row += kBandRows) add({level, page, 0, row, size, std::min(kBandRows, size - row)});
}

void PageCopier::list_commands(const std::vector<std::uint32_t>& groups) {
  std::ranges::fill(shares_, Share{});
  for (const std::uint32_t index : groups) {
    const ChartGroup& group = layout_.groups[index];
    Share& share = shares_[group.page];
    ++share.groups;
    share.texels += static_cast<std::size_t>(group.size.x) * static_cast<std::size_t>(group.size.y);
  }
  const std::size_t page_texels =
      static_cast<std::size_t>(layout_.page_size) * static_cast<std::size_t>(layout_.page_size);
  // Coarse levels of many groups are quicker copied as a whole page than one by one. If that holds for a level, it
  // holds for all coarser ones.
  const auto is_whole = [&](const Share& share, int level) {
    return ((page_texels - std::min(page_texels, share.texels)) * 4 >> 2 * level) < share.groups * kBytesPerCommand;
  };
  for (std::uint32_t page = 0; page < layout_.pages; ++page) {
    for (int level = 0; level < kChartLevels && shares_[page].groups > 0; ++level) {
      if (is_whole(shares_[page], level)) add_level(level, static_cast<int>(page));
    }
  }
  for (const std::uint32_t index : groups) {
    const ChartGroup& group = layout_.groups[index];
    for (int level = 0; level < kChartLevels && !is_whole(shares_[group.page], level); ++level) {
      add({level, static_cast<int>(group.page), group.origin.x >> level, group.origin.y >> level, group.size.x >> level,
           group.size.y >> level});
    }
  }
}

void PageCopier::run(std::size_t bytes) {
  assert(left_ > 0);
  // GL names no barrier bit for copies between images alone.
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  if (by_commands_) {
    run_commands(bytes);
  } else {
    run_dispatch(bytes);
  }
}

void PageCopier::run_commands(std::size_t bytes) {
  for (std::size_t done = 0; left_ > 0;) {
    const Command& c = commands_[next_];
    if (done > 0 && done + c.cost() > bytes) break;
    glCopyImageSubData(sets_[from_], GL_TEXTURE_2D_ARRAY, c.level, c.x, c.y, c.page, sets_[to_], GL_TEXTURE_2D_ARRAY,
                       c.level, c.x, c.y, c.page, c.width, c.height, 1);
    done += c.cost();
    left_ -= c.cost();
    ++next_;
  }
}

void PageCopier::run_dispatch(std::size_t bytes) {
  glUseProgram(program_.id());
  glBindTextureUnit(0, bits_[from_].id());
  glBindSampler(0, 0);
  for (int level = 0; level < kChartLevels; ++level) {
    glBindImageTexture(static_cast<GLuint>(level), sets_[to_], level, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32UI);
  }
  const std::size_t count = std::clamp<std::size_t>(bytes / kBytesPerBlock, 1, blocks_.size() - next_);
  blocks_.dispatch(next_, count);
  next_ += count;
  left_ -= count * kBytesPerBlock;
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

void PageCopier::choose_method(std::size_t from, std::size_t to) {
  // A part of a picture, spread over the layout.
  constexpr std::size_t kGroups = 256, kBlocks = 4096;
  std::vector<std::uint32_t> some;
  const std::size_t step = std::max<std::size_t>(layout_.groups.size() / kGroups, 1);
  std::size_t blocks = 0;
  for (std::size_t i = 0; i < layout_.groups.size() && blocks < kBlocks; i += step) {
    some.push_back(static_cast<std::uint32_t>(i));
    blocks += blocks_of(layout_.groups[i]);
  }
  std::array<double, 2> best{};
  for (const Method method : {Method::commands, Method::dispatch}) {
    method_ = method;
    double& least = best[static_cast<std::size_t>(method)];
    least = std::numeric_limits<double>::max();
    constexpr int kRuns = 3;  // the first one also pays for the driver's lazy work
    for (int run = 0; run < kRuns; ++run) {
      glFinish();
      const auto start = std::chrono::steady_clock::now();
      copy(some, from, to);
      glFinish();
      least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
  }
  method_ = best[0] <= best[1] ? Method::commands : Method::dispatch;
}

}  // namespace foreview
