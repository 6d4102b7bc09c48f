// viewer_pictures DIRECTORY: the pictures of the window in docs/viewer.md, from a scripted session on a virtual
// display. docs/make-images calls it.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "viewer/run_foreview.h"
#include "viewer/virtual_display.h"

namespace foreview::test {
namespace {

namespace fs = std::filesystem;
constexpr const char* kWindow = "foreview";
constexpr double kPatience = 120;  // seconds
const cv::Size kWindowSize{1280, 800}, kTile{512, 384};

void pause(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// The built-in workcell half a second ahead, standing still at a moment at which the arm moves.
class Session {
 public:
  Session()
      : display_(kWindowSize.width, kWindowSize.height),
        running_({"view", "workcell", "--delay", "500ms", "--from", "1s", "--to", "3.4s", "--speed", "0.25", "--rate",
                  "5", "--quiet"},
                 {{"DISPLAY", display_.name()}}) {
    wait_for("| 1.");
    display_.resize(kWindow, kWindowSize.width, kWindowSize.height);
    wait_for("| end");
    settle();
  }
  ~Session() { display_.press(kWindow, "q"); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  void press(const std::vector<std::string>& keys) {
    for (const std::string& key : keys) {
      display_.press(kWindow, key);
      pause(0.2);
    }
  }
  void wheel(int steps) {
    for (int i = 0; i < steps; ++i) {
      display_.mouse_button(kWindow, 4, true);
      display_.mouse_button(kWindow, 4, false);
      pause(0.3);
    }
  }
  void point_at(int x, int y) { display_.move_mouse(kWindow, x, y); }
  /// What is shown after the keys, which are pressed once more afterwards: each of them turns off what it turned on.
  cv::Mat picture_with(const std::vector<std::string>& keys, double patience = 1) {
    press(keys);
    pause(patience);
    settle();
    cv::Mat picture = display_.screenshot(kWindow);
    if (picture.size() != kWindowSize) throw std::runtime_error("the window has not the size that it was given");
    press(keys);
    return picture;
  }

 private:
  void wait_for(const std::string& part) {
    const std::string title = display_.wait_for_title(kWindow, part, kPatience);
    if (title.find(part) == std::string::npos) {
      throw std::runtime_error("the window says \"" + title + "\", not \"" + part + "\": " + running_.standard_error());
    }
  }
  /// Until nothing is being extracted any more.
  void settle() {
    for (int i = 0; i < 600; ++i) {
      pause(0.2);
      const std::string title = display_.title(kWindow).value_or("");
      if (title.find("| end") != std::string::npos && title.find("extracting") == std::string::npos) return;
    }
    throw std::runtime_error("the window does not come to rest: " + display_.title(kWindow).value_or("it is gone") +
                             running_.standard_error());
  }

  VirtualDisplay display_;
  RunningForeview running_;
};

cv::Mat tiles(const std::vector<cv::Mat>& pictures, int columns) {
  const int count = static_cast<int>(pictures.size()), rows = (count + columns - 1) / columns;
  constexpr int kGap = 4;
  cv::Mat sheet(rows * (kTile.height + kGap) - kGap, columns * (kTile.width + kGap) - kGap, CV_8UC3,
                cv::Scalar::all(255));
  for (int i = 0; i < count; ++i) {
    // The frame in the middle of the window, in its own aspect; beside it the window is black.
    const cv::Mat& picture = pictures[static_cast<std::size_t>(i)];
    const cv::Rect inside(0, 0, kTile.width, kTile.height);
    cv::Mat tile = sheet(inside + cv::Point(i % columns * (kTile.width + kGap), i / columns * (kTile.height + kGap)));
    const bool wide = picture.cols * kTile.height > picture.rows * kTile.width;
    const bool is_wide_frame = cv::mean(picture.row(picture.rows / 12))[1] < 1;
    const int height = wide && is_wide_frame ? picture.cols * kTile.height / kTile.width : picture.rows;
    cv::Mat framed(height, height * kTile.width / kTile.height, CV_8UC3, cv::Scalar::all(0));
    const int width = std::min(framed.cols, picture.cols), shown = std::min(height, picture.rows);
    picture(cv::Rect((picture.cols - width) / 2, (picture.rows - shown) / 2, width, shown))
        .copyTo(framed(cv::Rect((framed.cols - width) / 2, (height - shown) / 2, width, shown)));
    cv::resize(framed, tile, kTile, 0, 0, cv::INTER_AREA);
  }
  return sheet;
}

void write(const fs::path& file, const cv::Mat& picture) {
  if (!cv::imwrite(file.string(), picture, {cv::IMWRITE_JPEG_QUALITY, 88})) {
    throw std::runtime_error("cannot write " + file.string());
  }
  std::printf("%s\n", file.c_str());
}

void make_pictures(const fs::path& directory) {
  Session session;
  session.point_at(20, 20);
  write(directory / "viewer.jpg", session.picture_with({}));
  session.press({"p"});
  std::vector<cv::Mat> views;
  session.press({"2"});
  views.push_back(session.picture_with({"m"}));
  for (const char* view : {"3", "4", "5"}) {
    session.press({view});
    views.push_back(session.picture_with({}, 2));
  }
  write(directory / "viewer-views.jpg", tiles(views, 2));
  session.press({"1"});
  std::vector<cv::Mat> overlays;
  for (const char* overlay : {"h", "a", "d", "w"}) overlays.push_back(session.picture_with({overlay}));
  // The overview, to which the camera flies.
  session.press({"c", "c", "c"});
  session.point_at(kWindowSize.width / 2, kWindowSize.height / 2);
  session.wheel(4);
  for (const char* overlay : {"f", "n"}) overlays.push_back(session.picture_with({overlay}, 3));
  write(directory / "viewer-overlays.jpg", tiles(overlays, 3));
}

}  // namespace
}  // namespace foreview::test

int main(int argc, char** argv) {
  try {
    if (argc != 2) throw std::runtime_error("expected a directory");
    if (!foreview::test::VirtualDisplay::installed()) throw std::runtime_error("Xvfb is not installed");
    foreview::test::make_pictures(argv[1]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "viewer_pictures: %s\n", error.what());
    return 1;
  }
}
