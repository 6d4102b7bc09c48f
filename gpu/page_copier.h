#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "foreview/gpu/chart_blocks.h"
#include "foreview/gpu/gl_objects.h"
#include "foreview/scene/chart_layout.h"

namespace foreview {

/// Copies blocks of chart groups, all levels, between sets of atlas pages of one layout (RGBA8 array textures). Texels
/// arrive bit by bit as they were. In two ways, because neither is good everywhere: a copy command per rectangle moves
/// memory at full speed on a software rasteriser, where a dispatch costs many times more per texel; a graphics card
/// does all in one dispatch, where thousands of commands would keep its driver busy.
class PageCopier {
 public:
  enum class Method { commands, dispatch };

  /// Needs a current context, as do all members. Begins with Method::commands. Layout and textures must outlive the
  /// copier.
  PageCopier(const ChartLayout& layout, std::vector<GLuint> sets);
  /// `groups` are indices into layout.groups; `from` and `to` indices of sets. What else
  /// lies in the same pages may be copied too: `from` must nowhere be older than `to`. Waits for nothing; issues the
  /// barriers that writers before and readers after it need; changes the program and bindings (see TextureStore).
  void copy(const std::vector<std::uint32_t>& groups, std::size_t from, std::size_t to);
  /// The same in pieces: begin() or begin_all() issues nothing, run() does, until nothing is left().
  void begin(const std::vector<std::uint32_t>& groups, std::size_t from, std::size_t to);
  /// Whole pages, by commands.
  void begin_all(std::size_t from, std::size_t to);
  /// Bytes, with what a command costs beside its own.
  [[nodiscard]] std::size_t left() const { return left_; }
  /// About so many bytes of what is left, at least one command or block.
  void run(std::size_t bytes);
  [[nodiscard]] Method method() const { return method_; }
  void set_method(Method method) { method_ = method; }
  /// Times both methods with some groups of the layout and keeps the faster one. Takes some milliseconds and waits for
  /// the GPU. Both sets must hold the same.
  void choose_method(std::size_t from, std::size_t to);

 private:
  struct Command {
    int level = 0, page = 0;
    int x = 0, y = 0, width = 0, height = 0;  ///< texels at the level
    [[nodiscard]] std::size_t cost() const;
  };
  void restart(std::size_t from, std::size_t to);
  void add(const Command& command);
  void add_level(int level, int page);
  void list_commands(const std::vector<std::uint32_t>& groups);
  void run_commands(std::size_t bytes);
  void run_dispatch(std::size_t bytes);

  const ChartLayout& layout_;
  std::vector<GLuint> sets_;
  std::vector<GlTexture> bits_;  ///< the sets seen as R32UI
  Method method_ = Method::commands;
  GlProgram program_;
  ChartBlocks blocks_;
  struct Share {
    std::size_t groups = 0, texels = 0;
  };
  std::vector<Share> shares_;  ///< of a page in one copy
  // What is being copied.
  std::size_t from_ = 0, to_ = 0, left_ = 0;
  bool by_commands_ = true;
  std::vector<Command> commands_;
  std::size_t next_ = 0;  ///< command or block
};

}  // namespace foreview
