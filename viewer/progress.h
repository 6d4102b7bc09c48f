#pragma once
#include <cstddef>
#include <string>

namespace foreview {

/// A progress bar on stderr: redrawn in place on a terminal, a line every few seconds elsewhere, silent with --quiet.
class ProgressBar {
 public:
  ProgressBar(std::string label, std::size_t total);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  void update(std::size_t done);
  static void set_quiet(bool quiet);

 private:
  std::string label_;
  std::size_t total_, done_ = 0;
  double started_, last_drawn_ = 0;
  bool terminal_;
};

}  // namespace foreview
