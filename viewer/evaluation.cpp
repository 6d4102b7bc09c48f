#include "foreview/viewer/evaluation.h"

#include <epoxy/gl.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "foreview/scene/errors.h"
#include "foreview/scene/output_file.h"
#include "foreview/viewer/rotation_warp.h"
#include "foreview/viewer/silhouettes.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;

constexpr int kObserved = 2, kFilled = 1;  ///< PredictedView::Surface::provenance

/// The four pictures of an instant, each in a directory of its own.
class PictureWriter {
 public:
  explicit PictureWriter(const std::optional<fs::path>& directory) : directory_(directory) {}
  void write(const char* kind, const std::string& stem, const cv::Mat& picture) const {
    if (!directory_) return;
    const fs::path folder = *directory_ / kind;
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw InputError(folder.string(), "cannot make this directory: " + error.message());
    std::vector<unsigned char> bytes;
    cv::imencode(".png", picture, bytes);
    write_file_whole(folder / (stem + ".png"), bytes);
  }

 private:
  std::optional<fs::path> directory_;
};

double part_of(const cv::Mat& chosen, const cv::Mat& usable) {
  return static_cast<double>(cv::countNonZero(chosen & usable)) / std::max(1, cv::countNonZero(usable));
}

class InstantEvaluator {
 public:
  InstantEvaluator(Replayer& replayer, const EvaluationOptions& options)
      : replayer_(replayer),
        writer_(options.images),
        usable_(replayer.usable_pixels()),
        all_usable_(cv::countNonZero(usable_) == static_cast<int>(usable_.total())) {}

  /// The replayer has been advanced to `state`'s time, and has used a picture.
  [[nodiscard]] InstantScore evaluate(std::size_t picture, const cv::Mat& truth, const PredictedState& state) const {
    const Recording::Camera& own = replayer_.recording().cameras()[replayer_.camera()];
    const CameraModel camera = replayer_.registered_camera(), &recorded_camera = replayer_.operator_camera();
    const auto recorded = replayer_.recording().capture_state(replayer_.camera(), state.stamp, replayer_.model());
    InstantScore score;
    score.picture = picture;
    score.stem = own.pictures[picture].stem;
    score.seconds = (own.pictures[picture].stamp - own.pictures.front().stamp).seconds();
    score.delayed_picture = *replayer_.newest_used();
    const Timestamp delayed_stamp = own.pictures[score.delayed_picture].stamp;
    score.age = (state.stamp - delayed_stamp).seconds();

    ViewStyle style;
    style.gaps = gaps_to_fill(camera, recorded_camera);
    const cv::Mat predicted = replayer_.view().render(camera, state, style);
    const cv::Mat delayed = replayer_.undistorted_picture(score.delayed_picture);
    const cv::Mat rotation = warp_by_rotation(delayed, recorded_camera, *own.world_from_camera.at(delayed_stamp),
                                              recorded_camera, recorded->world_from_camera);
    score.predicted = compare("predicted", score.stem, predicted, truth);
    score.delayed = compare("delayed", score.stem, delayed, truth);
    score.rotation = compare("rotation", score.stem, rotation, truth);
    writer_.write("truth", score.stem, truth);

    const PredictedView::Surface surface = replayer_.view().render_surface(camera, state);
    const cv::Mat seen = surface.provenance == kObserved;
    score.seen = part_of(seen, usable_);
    score.filled = part_of(surface.provenance == kFilled, usable_);
    score.never_seen = 1 - score.seen - score.filled;
    score.over_seen = pixel_error(predicted, truth, seen & usable_);
    const cv::Mat beyond = beyond_silhouettes(camera, state, {surface.polygon, surface.inverse_z});
    writer_.write("beyond-silhouettes", score.stem, beyond & usable_);
    score.beyond_silhouettes = pixel_error(predicted, truth, beyond & usable_);
    score.ghosts = displaced_error(predicted, truth, beyond & usable_, kGhostDisplacement);
    return score;
  }

 private:
  [[nodiscard]] ViewScore compare(const char* kind, const std::string& stem, const cv::Mat& shown,
                                  const cv::Mat& truth) const {
    writer_.write(kind, stem, shown);
    const cv::Mat mask = all_usable_ ? cv::Mat() : usable_;
    return {pixel_error(shown, truth, mask).psnr().value_or(0), structural_similarity(shown, truth, mask)};
  }
  [[nodiscard]] cv::Mat beyond_silhouettes(const CameraModel& camera, const PredictedState& state,
                                           const SurfaceMap& predicted) const {
    const Replayer::UsedPicture& used = *replayer_.last_used();
    const PredictedView::Surface surface = replayer_.view().render_surface(used.model, used.state);
    return pixels_beyond_silhouettes(replayer_.model(), camera, state, predicted, used.model, used.state,
                                     {surface.polygon, surface.inverse_z});
  }

  Replayer& replayer_;
  PictureWriter writer_;
  cv::Mat usable_;
  bool all_usable_;
};

std::vector<std::size_t> pictures_to_evaluate(Replayer& replayer, std::size_t every) {
  const auto& pictures = replayer.recording().cameras()[replayer.camera()].pictures;
  std::vector<std::size_t> result;
  std::size_t within = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (pictures[i].stamp < replayer.first() || pictures[i].stamp > replayer.last()) continue;
    if (within++ % every == 0) result.push_back(i);
  }
  return result;
}

/// The undistorted true picture, or none where its file is damaged.
std::optional<cv::Mat> true_picture(const Replayer& replayer, std::size_t picture) {
  try {
    return replayer.undistorted_picture(picture);
  } catch (const InputError& error) {
    spdlog::warn("left out: {}", error.what());
    return std::nullopt;
  }
}

}  // namespace

Evaluation evaluate(Replayer& replayer, const EvaluationOptions& options,
                    const std::function<void(std::size_t, std::size_t)>& progress) {
  if (options.every < 1) throw InputError("--every", "expected a number of pictures from 1 on");
  const Recording& recording = replayer.recording();
  const Recording::Camera& own = recording.cameras()[replayer.camera()];
  Evaluation evaluation;
  evaluation.renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  evaluation.recording = recording.name();
  evaluation.camera = own.name;
  evaluation.width = own.model.width;
  evaluation.height = own.model.height;
  evaluation.polygons = replayer.model().polygons().size();
  evaluation.texels_per_metre = replayer.chart_options().texels_per_metre;
  evaluation.max_texels = replayer.chart_options().max_texels;

  const InstantEvaluator evaluator(replayer, options);
  const std::vector<std::size_t> pictures = pictures_to_evaluate(replayer, options.every);
  try {
    for (std::size_t done = 0; done < pictures.size(); ++done) {
      const auto tell = [&](std::size_t = 0, std::size_t = 0) {
        if (progress) progress(done, pictures.size());
      };
      tell();
      const Timestamp now = own.pictures[pictures[done]].stamp;
      const auto truth = replayer.predicted_state(now) ? true_picture(replayer, pictures[done]) : std::nullopt;
      if (!truth) {
        ++evaluation.instants_damaged;
        continue;
      }
      replayer.advance_to(now, tell);
      if (!replayer.newest_used()) {
        ++evaluation.instants_without_picture;
        continue;
      }
      evaluation.instants.push_back(evaluator.evaluate(pictures[done], *truth, *replayer.predicted_state(now)));
    }
    if (progress) progress(pictures.size(), pictures.size());
  } catch (const Interrupted&) {
    evaluation.complete = false;
  }
  if (evaluation.complete && evaluation.instants.empty()) {
    throw InputError(recording.directory().string(),
                     "nothing to evaluate: before the pictures from --from to --to no other had arrived, or they are "
                     "damaged; expected a longer recording or a shorter --delay");
  }
  evaluation.registration = replayer.registration();
  evaluation.pictures_extracted = replayer.pictures_extracted();
  evaluation.pictures_damaged = replayer.pictures_damaged();
  evaluation.damage = recording.damage();
  evaluation.extraction_seconds = replayer.extraction_seconds();
  return evaluation;
}

}  // namespace foreview
