// How long frames take to draw: every view and overlay on a built-in recording. Not a test; run it on a quiet machine:
//   build/tests/viewer/frame_composer_bench [RECORDING [FRAMES [VIEW]]]
#include <epoxy/gl.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "foreview/gpu/offscreen_context.h"
#include "foreview/viewer/frame_composer.h"
#include "foreview/viewer/polygon_probe.h"
#include "foreview/viewer/replay_frames.h"
#include "foreview/viewer/replayer.h"

namespace foreview {
namespace {

std::vector<std::pair<std::string, ViewChoice>> choices() {
  std::vector<std::pair<std::string, ViewChoice>> result;
  const auto add = [&](const char* name, auto&& change) {
    ViewChoice choice;
    change(choice);
    result.emplace_back(name, choice);
  };
  for (const ViewMode mode : kViewModes) {
    add(to_string(mode), [&](ViewChoice& c) { c.mode = mode; });
  }
  add("predicted, fast", [](ViewChoice& c) { c.quality = ViewQuality::fast; });
  add("age, fast", [](ViewChoice& c) {
    c.quality = ViewQuality::fast;
    c.overlays.age = true;
  });
  add("holes", [](ViewChoice& c) { c.overlays.holes = true; });
  add("never seen", [](ViewChoice& c) { c.overlays.never_seen = true; });
  add("age", [](ViewChoice& c) { c.overlays.age = true; });
  add("density", [](ViewChoice& c) { c.overlays.density = true; });
  add("wireframe", [](ViewChoice& c) { c.overlays.wireframe = true; });
  add("cone", [](ViewChoice& c) { c.overlays.cone = true; });
  add("polygon", [](ViewChoice& c) { c.polygon = 3; });
  add("all", [](ViewChoice& c) {
    c.overlays = {true, true, true, true, true, true, true};
    c.polygon = 3;
  });
  add("overview, cone", [](ViewChoice& c) {
    c.camera = CameraMode::overview;
    c.overlays.cone = true;
  });
  return result;
}

void measure(const std::string& recording, int frames, const std::string& only) {
  const OffscreenContext context(OffscreenContext::Options{});
  ReplayOptions options;
  options.recording = recording;
  options.to = "2.2";
  Replayer replayer(options);
  const Timestamp t = replayer.last();
  replayer.advance_to(t);
  FrameComposer composer(replayer.view(), replayer.recording().cameras()[replayer.camera()].model, 0.02);
  ReplayFrames inputs(replayer, options.delay);
  std::printf("%s, %s\n%-16s %9s %9s %9s\n", recording.c_str(), context.renderer().c_str(), "ms per frame", "least",
              "median", "worst");
  for (const auto& [name, choice] : choices()) {
    if (!only.empty() && name != only) continue;
    std::vector<double> ms;
    const FrameInput& input = inputs.at(t, choice);
    for (int i = -3; i < frames; ++i) {
      const auto start = std::chrono::steady_clock::now();
      composer.compose(input, choice, composer.native_size(ViewMode::predicted));
      (void)composer.framebuffer();
      glFinish();
      const auto end = std::chrono::steady_clock::now();
      if (i >= 0) ms.push_back(std::chrono::duration<double, std::milli>(end - start).count());
    }
    std::sort(ms.begin(), ms.end());
    std::printf("%-16s %9.2f %9.2f %9.2f\n", name.c_str(), ms.front(), ms[ms.size() / 2], ms.back());
  }
  // What asking for the polygon under the cursor holds the display's thread up, before a frame of its own is drawn.
  PolygonProbe probe(replayer.view(), replayer.recording().cameras()[replayer.camera()].model, 0.02);
  std::vector<double> ms;
  const ViewChoice choice;
  const FrameInput& input = inputs.at(t, choice);
  const FrameComposer::Size size = composer.native_size(ViewMode::predicted);
  for (int i = 0; i < frames; ++i) {
    const auto start = std::chrono::steady_clock::now();
    probe.update(input, choice, size, glm::dvec2(300 + i, 250));
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    composer.compose(input, choice, size);
    glFinish();
  }
  std::sort(ms.begin(), ms.end());
  std::printf("%-16s %9.2f %9.2f %9.2f\n", "probe, call only", ms.front(), ms[ms.size() / 2], ms.back());
}

}  // namespace
}  // namespace foreview

int main(int argc, char** argv) {
  foreview::measure(argc > 1 ? argv[1] : "workcell", argc > 2 ? std::atoi(argv[2]) : 20, argc > 3 ? argv[3] : "");
}
