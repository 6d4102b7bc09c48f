// embedding RECORDING OUT.png: what the operator of a recorded robot would have seen at its end, had every picture but
// the last been there. foreview inside a program of one's own.
#include <cstdio>
#include <exception>
#include <opencv2/imgcodecs.hpp>

#include "foreview/gpu/offscreen_context.h"
#include "foreview/gpu/per_polygon/per_polygon_extraction.h"
#include "foreview/recordings/recording.h"
#include "foreview/viewer/predicted_view.h"

int main(int argc, char** argv) try {
  if (argc != 3) return std::fprintf(stderr, "usage: embedding RECORDING OUT.png\n"), 2;
  foreview::Recording recording = foreview::Recording::open(argv[1]);
  const foreview::PolygonModel model =
      foreview::import_model(recording.scene_file().value(), recording.import_options());

  foreview::OffscreenContext context;
  const foreview::ChartOptions charts{.texels_per_metre = 200, .group_polygons = false};
  foreview::TextureStore store(model, foreview::lay_out_charts(model, charts));
  foreview::PerPolygonExtraction extraction(store, charts, {});
  foreview::PredictedView view(store);

  const std::size_t pictures = recording.cameras()[0].pictures.size();
  for (std::size_t i = 0; i + 1 < pictures; ++i) {
    if (const auto frame = recording.read_frame(0, i, model)) extraction.extract(*frame);
  }
  const auto now = recording.predicted_state(0, recording.last_stamp(), model);
  cv::imwrite(argv[2], view.render(recording.cameras()[0].model.undistorted(), now.value()));
  std::printf("%zu polygons, %zu pictures: %s\n", model.polygons().size(), pictures, argv[2]);
} catch (const std::exception& error) {
  return std::fprintf(stderr, "embedding: %s\n", error.what()), 2;
}
