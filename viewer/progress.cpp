#include "foreview/viewer/progress.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

namespace foreview {
namespace {

constexpr int kBarCells = 30;
constexpr double kTerminalPeriod = 0.1;  // seconds between redraws
constexpr double kPlainPeriod = 5.0;     // seconds between lines where nobody redraws

bool g_quiet = false;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string remaining(double elapsed, std::size_t done, std::size_t total) {
  if (done == 0 || total <= done || elapsed < 1) return "";
  const double seconds = std::ceil(elapsed / static_cast<double>(done) * static_cast<double>(total - done));
  if (seconds > 360000) return "";
  char text[32];
  std::snprintf(text, sizeof text, ", %d:%02d left", static_cast<int>(seconds) / 60, static_cast<int>(seconds) % 60);
  return text;
}

}  // namespace

ProgressBar::ProgressBar(std::string label, std::size_t total)
    : label_(std::move(label)), total_(total), started_(now()), terminal_(isatty(STDERR_FILENO) == 1) {
  // Elsewhere than on a terminal, work shorter than one period says nothing.
  last_drawn_ = terminal_ ? 0 : started_;
  update(0);
}

ProgressBar::~ProgressBar() {
  if (g_quiet) return;
  if (terminal_) {
    std::fprintf(stderr, "\r\033[K");
    std::fflush(stderr);
  }
}

void ProgressBar::update(std::size_t done) {
  done_ = total_ > 0 ? std::min(done, total_) : done;
  if (g_quiet) return;
  const double time = now();
  if (time - last_drawn_ < (terminal_ ? kTerminalPeriod : kPlainPeriod)) return;
  last_drawn_ = time;
  if (total_ == 0) {
    std::fprintf(stderr, terminal_ ? "\r\033[K%s: %zu" : "%s: %zu\n", label_.c_str(), done_);
    std::fflush(stderr);
    return;
  }
  const double fraction = static_cast<double>(done_) / static_cast<double>(total_);
  const std::string left = remaining(time - started_, done_, total_);
  if (terminal_) {
    const auto full = static_cast<std::size_t>(std::lround(fraction * kBarCells));
    const std::string bar = std::string(full, '#') + std::string(kBarCells - full, '.');
    std::fprintf(stderr, "\r\033[K%s [%s] %zu/%zu%s", label_.c_str(), bar.c_str(), done_, total_, left.c_str());
  } else {
    std::fprintf(stderr, "%s: %zu of %zu (%.0f %%)%s\n", label_.c_str(), done_, total_, 100 * fraction, left.c_str());
  }
  std::fflush(stderr);
}

void ProgressBar::set_quiet(bool quiet) {
  g_quiet = quiet;
}

}  // namespace foreview
