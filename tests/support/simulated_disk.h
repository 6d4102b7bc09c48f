#pragma once
#include <fcntl.h>

#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "foreview/scene/disk.h"

namespace foreview::test {

/// A disk in memory that remembers what was done to it in which order, can be full, and can lose its power.
///
/// After a power cut a file holds what it held at its last sync; of what came since, as the cut likes: all of it, a
/// part, zeros, or nothing. Names (made, renamed, removed) are there for good once their directory was synced after
/// that; the others may be there or not, each for itself, whatever became of the content. This is less than what any
/// file system in use promises.
class SimulatedDisk final : public Disk {
 public:
  /// From the call of this number on, writes find the disk full; none: it never is.
  std::optional<std::size_t> full_from;
  /// The call of this number, if it is a sync, fails: EIO.
  std::optional<std::size_t> failing_sync;

  [[nodiscard]] std::size_t calls() const {
    const std::lock_guard lock(mutex_);
    return calls_.size();
  }

  int open(const std::filesystem::path& file, int flags) override {
    const std::lock_guard lock(mutex_);
    const std::string path = file.string();
    Open opened;
    opened.is_directory = (flags & O_DIRECTORY) != 0;
    opened.path = path;
    if (!opened.is_directory) {
      const auto place = names_.find(path);
      if (place != names_.end()) {
        opened.file = place->second;
        if ((flags & O_TRUNC) != 0) {
          content_[opened.file].clear();
          add({Kind::content, opened.file, path, ""});
        }
      } else {
        if ((flags & O_CREAT) == 0) return -ENOENT;
        if (is_full()) return add({Kind::nothing, 0, path, ""}), -ENOSPC;
        opened.file = content_.size();
        content_.emplace_back();
        names_[path] = opened.file;
        add({Kind::name, opened.file, path, ""});
      }
    }
    open_[++last_descriptor_] = opened;
    return last_descriptor_;
  }
  ssize_t write(int file, const void* data, std::size_t size) override {
    const std::lock_guard lock(mutex_);
    const Open& opened = open_.at(file);
    std::string& content = content_[opened.file];
    // A full disk takes a part.
    const bool full = is_full();
    if (full && size < 8) return add({Kind::nothing, 0, opened.path, ""}), -ENOSPC;
    content.append(static_cast<const char*>(data), full ? size / 2 : size);
    add({Kind::content, opened.file, opened.path, content});
    return static_cast<ssize_t>(full ? size / 2 : size);
  }
  std::int64_t size(int file) override {
    const std::lock_guard lock(mutex_);
    return static_cast<std::int64_t>(content_[open_.at(file).file].size());
  }
  int truncate(int file, std::int64_t size) override {
    const std::lock_guard lock(mutex_);
    const Open& opened = open_.at(file);
    content_[opened.file].resize(static_cast<std::size_t>(size));
    add({Kind::content, opened.file, opened.path, content_[opened.file]});
    return 0;
  }
  int sync(int file) override {
    const std::lock_guard lock(mutex_);
    const Open& opened = open_.at(file);
    if (failing_sync == calls_.size()) return add({Kind::nothing, 0, opened.path, ""}), -EIO;
    add({opened.is_directory ? Kind::sync_names : Kind::sync_content, opened.file, opened.path, ""});
    return 0;
  }
  int close(int file) override {
    const std::lock_guard lock(mutex_);
    open_.erase(file);
    return 0;
  }
  int rename(const std::filesystem::path& from, const std::filesystem::path& to) override {
    const std::lock_guard lock(mutex_);
    const auto place = names_.find(from.string());
    if (place == names_.end()) return -ENOENT;
    const std::size_t file = place->second;
    names_.erase(place);
    names_[to.string()] = file;
    add({Kind::rename, file, to.string(), from.string()});
    return 0;
  }
  int unlink(const std::filesystem::path& file) override {
    const std::lock_guard lock(mutex_);
    if (names_.erase(file.string()) == 0) return -ENOENT;
    add({Kind::remove, 0, file.string(), ""});
    return 0;
  }
  int make_directory(const std::filesystem::path& directory) override {
    const std::lock_guard lock(mutex_);
    if (!directories_.try_emplace(directory.string(), true).second) return -EEXIST;
    if (is_full()) return add({Kind::nothing, 0, directory.string(), ""}), -ENOSPC;
    add({Kind::directory, 0, directory.string(), ""});
    return 0;
  }

  /// What the cut takes of what was not synced.
  enum class Luck { nothing_stays, all_stays, names_stay, content_stays, zeros, random };

  /// Writes into `target` what is left when the power is cut after so many calls. Paths are those of this disk, below
  /// `root`.
  void write_remainder(std::size_t calls, Luck luck, unsigned seed, const std::filesystem::path& root,
                       const std::filesystem::path& target) const {
    const std::lock_guard lock(mutex_);
    std::mt19937 random(seed);
    const auto stays = [&](bool is_name) {
      switch (luck) {
        case Luck::nothing_stays:
          return false;
        case Luck::all_stays:
          return true;
        case Luck::names_stay:
        case Luck::zeros:
          return is_name;
        case Luck::content_stays:
          return !is_name;
        default:
          return random() % 2 == 0;
      }
    };
    std::map<std::string, std::size_t> names;
    std::map<std::string, bool> directories;
    std::vector<std::string> synced(content_.size()), last(content_.size());
    for (std::size_t i = 0; i < calls; ++i) {
      const Call& call = calls_[i];
      if (call.kind == Kind::content) last[call.file] = call.content;
      if (call.kind == Kind::sync_content) synced[call.file] = last[call.file];
      const bool is_name = call.kind == Kind::name || call.kind == Kind::rename || call.kind == Kind::remove ||
                           call.kind == Kind::directory;
      if (!is_name || (!are_names_synced(call.path, i, calls) && !stays(true))) continue;
      if (call.kind == Kind::directory) directories[call.path] = true;
      if (call.kind == Kind::name) names[call.path] = call.file;
      if (call.kind == Kind::remove) names.erase(call.path);
      if (call.kind == Kind::rename) {
        names.erase(call.content);
        names[call.path] = call.file;
      }
    }
    for (const auto& [path, unused] : directories) {
      if (is_below(path, root) && has_all_above(path, root, directories)) {
        std::filesystem::create_directories(target / std::filesystem::path(path).lexically_relative(root));
      }
    }
    for (const auto& [path, file] : names) {
      const std::filesystem::path own(path);
      if (!is_below(path, root) || !has_all_above(path, root, directories)) continue;
      std::string content = synced[file];
      if (last[file] != content && last[file].starts_with(content)) {
        const std::string tail = last[file].substr(content.size());
        if (luck == Luck::zeros) {
          content += std::string(tail.size(), '\0');
        } else if (luck == Luck::random) {
          const std::string part = tail.substr(0, random() % (tail.size() + 1));
          content += random() % 3 == 0 ? part + std::string(tail.size() - part.size(), '\0') : part;
        } else if (stays(false)) {
          content += tail;
        }
      } else if (last[file] != content && stays(false)) {
        content = last[file];
      }
      std::ofstream(target / own.lexically_relative(root), std::ios::binary) << content;
    }
  }

 private:
  enum class Kind { nothing, directory, name, rename, remove, content, sync_content, sync_names };
  struct Call {
    Kind kind;
    std::size_t file;
    std::string path;
    std::string content;  ///< content: all of it from then on; rename: the old name
  };
  struct Open {
    std::size_t file = 0;
    bool is_directory = false;
    std::string path;
  };
  void add(Call call) { calls_.push_back(std::move(call)); }
  [[nodiscard]] bool is_full() const { return full_from && calls_.size() >= *full_from; }
  static bool is_below(const std::string& path, const std::filesystem::path& root) {
    return path.starts_with(root.string() + "/");
  }
  /// Whether the directory that holds `path` was synced between two calls.
  [[nodiscard]] bool are_names_synced(const std::string& path, std::size_t from, std::size_t to) const {
    const std::string parent = std::filesystem::path(path).parent_path().string();
    for (std::size_t i = from; i < to; ++i) {
      if (calls_[i].kind == Kind::sync_names && calls_[i].path == parent) return true;
    }
    return false;
  }
  static bool has_all_above(const std::string& path, const std::filesystem::path& root,
                            const std::map<std::string, bool>& directories) {
    for (auto above = std::filesystem::path(path).parent_path(); above != root; above = above.parent_path()) {
      if (directories.count(above.string()) == 0) return false;
    }
    return true;
  }

  mutable std::mutex mutex_;
  std::vector<Call> calls_;
  std::vector<std::string> content_;          ///< by file
  std::map<std::string, std::size_t> names_;  ///< of files
  std::map<std::string, bool> directories_;
  std::map<int, Open> open_;
  int last_descriptor_ = 100;
};

}  // namespace foreview::test
