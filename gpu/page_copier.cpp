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
  assert(from != to);
  if (groups.empty()) return;
  if (method_ == Method::commands) {
    copy_by_commands(groups, sets_[from], sets_[to]);
  } else {
    copy_by_dispatch(groups, from, sets_[to]);
  }
}

void PageCopier::copy_level(int level, GLuint from, GLuint to, int first_page, int pages) const {
  const int size = layout_.page_size >> level;
  glCopyImageSubData(from, GL_TEXTURE_2D_ARRAY, level, 0, 0, first_page, to, GL_TEXTURE_2D_ARRAY, level, 0, 0,
                     first_page, size, size, pages);
}

void PageCopier::copy_all(std::size_t from, std::size_t to) const {
  assert(from != to);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  for (int level = 0; level < kChartLevels; ++level) {
    copy_level(level, sets_[from], sets_[to], 0, static_cast<int>(layout_.pages));
  }
}

void PageCopier::copy_by_commands(const std::vector<std::uint32_t>& groups, GLuint from, GLuint to) {
  // GL names no barrier bit for this command alone.
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
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
      if (is_whole(shares_[page], level)) copy_level(level, from, to, static_cast<int>(page), 1);
    }
  }
  for (const std::uint32_t index : groups) {
    const ChartGroup& group = layout_.groups[index];
    const auto page = static_cast<int>(group.page);
    for (int level = 0; level < kChartLevels && !is_whole(shares_[group.page], level); ++level) {
      const int x = group.origin.x >> level, y = group.origin.y >> level;
      glCopyImageSubData(from, GL_TEXTURE_2D_ARRAY, level, x, y, page, to, GL_TEXTURE_2D_ARRAY, level, x, y, page,
                         group.size.x >> level, group.size.y >> level, 1);
    }
  }
}

void PageCopier::copy_by_dispatch(const std::vector<std::uint32_t>& groups, std::size_t from, GLuint to) {
  blocks_.list(groups);
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
  glUseProgram(program_.id());
  glBindTextureUnit(0, bits_[from].id());
  glBindSampler(0, 0);
  for (int level = 0; level < kChartLevels; ++level) {
    glBindImageTexture(static_cast<GLuint>(level), to, level, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32UI);
  }
  blocks_.dispatch();
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
