#include "foreview/viewer/replayer.h"

#include <epoxy/gl.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "foreview/scene/errors.h"
#include "foreview/viewer/replay_input.h"
#include "foreview/viewer/undistortion.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;

/// A picture by its place in the recording. Capture order; of pictures taken at once, the first camera's goes first.
struct PictureId {
  Timestamp stamp;
  std::size_t camera = 0;
  std::size_t index = 0;
  auto operator<=>(const PictureId&) const = default;  // NOLINT(modernize-use-nullptr): the compiler's own 0
};

ChartLayout lay_out(const PolygonModel& model, const ChartOptions& options) {
  ChartLayout layout = lay_out_charts(model, options);
  for (const std::string& note : layout.notes) spdlog::info("textures: {}", note);
  return layout;
}

}  // namespace

struct Replayer::State : ReplayInput {
  explicit State(const ReplayOptions& from)
      : ReplayInput(from),
        operator_camera(recording.cameras()[camera].model.undistorted()),
        undistortion(recording.cameras()[camera].model),
        store(model, lay_out(model, charts)),
        extraction(make_extraction_pipeline(options.pipeline, store, charts, options.extraction)),
        view(store) {
    const ReplaySpan span = find_span(*this);
    first = span.first;
    last = span.last;
    extraction->set_counting(options.stats);
    if (options.registration) rays.emplace(model);
    begin_afresh();
    store.spread_to_never_seen();
  }

  const Recording::Camera& own() const { return recording.cameras()[camera]; }

  /// To what the textures were before the first picture.
  void begin_afresh() {
    extraction->clear();
    store.clear();
    used.clear();
    last_used.reset();
    last_used_by_operator.reset();
    registrations.clear();
    for (std::size_t c = 0; rays && c < recording.cameras().size(); ++c) registrations.emplace_back(model, *rays);
    const auto initial = options.load_textures ? options.load_textures : recording.initial_textures();
    if (!initial || initial_unfit) return;
    try {
      load_textures(store, *initial);
      extraction->adopt_store();
    } catch (const InputError& error) {
      // The user's own must fit; what the recording begins with does not fit every model and density.
      if (options.load_textures) throw;
      spdlog::warn("beginning without the recording's textures: {}", error.what());
      initial_unfit = true;
      store.clear();
    }
  }

  /// All pictures that a display at time t may know, in capture order, without those found damaged.
  [[nodiscard]] std::vector<PictureId> wanted_at(Timestamp t) const {
    std::vector<PictureId> wanted;
    for (std::size_t c = 0; c < recording.cameras().size(); ++c) {
      const auto newest = recording.newest_before(c, t - options.delay);
      if (!newest) continue;
      std::size_t left = options.history.value_or(*newest + 1);
      for (std::size_t i = *newest + 1; i-- > 0 && left > 0;) {
        const PictureId id{recording.cameras()[c].pictures[i].stamp, c, i};
        if (damaged.count(id) != 0) continue;
        wanted.push_back(id);
        --left;
      }
    }
    std::sort(wanted.begin(), wanted.end());
    return wanted;
  }

  std::size_t advance_to(Timestamp t, const std::function<void(std::size_t, std::size_t)>& progress) {
    std::size_t extracted = 0;
    bool changed = false, again = true;
    while (again) {
      again = false;
      const std::vector<PictureId> wanted = wanted_at(t);
      if (used.size() > wanted.size() || !std::equal(used.begin(), used.end(), wanted.begin())) {
        begin_afresh();
        changed = true;
      }
      const std::size_t todo = wanted.size() - used.size();
      for (std::size_t done = 0; done < todo && !again; ++done) {
        if (progress) progress(done, todo);
        const PictureId id = wanted[used.size()];
        auto frame = recording.read_frame(id.camera, id.index, model);
        if (frame) {
          if (rays) registrations[id.camera].correct(*frame);
          extract(*frame);
          used.push_back(id);
          last_used = UsedPicture{id.camera, id.index, frame->camera.undistorted(), frame->state};
          if (id.camera == camera) last_used_by_operator = last_used;
          ++extracted;
        } else {
          // With --history, an older picture takes its place: the operator's site would never have got it.
          damaged.insert(id);
          again = true;
        }
      }
      if (progress && !again && todo > 0) progress(todo, todo);
    }
    if (changed || extracted > 0) store.spread_to_never_seen();
    return extracted;
  }

  void extract(const CameraFrame& frame) {
    glFinish();
    const auto start = std::chrono::steady_clock::now();
    statistics += extraction->extract(frame);
    glFinish();
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    ++pictures_extracted;
  }

  CameraModel operator_camera;
  Undistortion undistortion;
  TextureStore store;
  std::unique_ptr<ExtractionPipeline> extraction;
  PredictedView view;
  Timestamp first, last;
  std::optional<RayCaster> rays;            ///< with registration
  std::vector<Registration> registrations;  ///< of each camera, or none
  std::optional<UsedPicture> last_used, last_used_by_operator;
  std::vector<PictureId> used;  ///< since the textures were last begun afresh, in the order of their extraction
  std::set<PictureId> damaged;
  bool initial_unfit = false;
  ExtractionStatistics statistics;
  std::size_t pictures_extracted = 0;
  double seconds = 0;
};

Replayer::Replayer(const ReplayOptions& options) : state_(std::make_unique<State>(options)) {}
Replayer::~Replayer() = default;

Recording& Replayer::recording() {
  return state_->recording;
}
const PolygonModel& Replayer::model() const {
  return state_->model;
}
TextureStore& Replayer::store() {
  return state_->store;
}
PredictedView& Replayer::view() {
  return state_->view;
}
std::size_t Replayer::camera() const {
  return state_->camera;
}
const CameraModel& Replayer::operator_camera() const {
  return state_->operator_camera;
}
const ChartOptions& Replayer::chart_options() const {
  return state_->charts;
}
Timestamp Replayer::first() const {
  return state_->first;
}
Timestamp Replayer::last() const {
  return state_->last;
}

std::size_t Replayer::advance_to(Timestamp t, const std::function<void(std::size_t, std::size_t)>& progress) {
  return state_->advance_to(t, progress);
}

std::optional<PredictedState> Replayer::predicted_state(Timestamp t) const {
  auto state = state_->recording.predicted_state(state_->camera, t, state_->model);
  if (state && !state_->registrations.empty()) {
    state->world_from_camera =
        state_->registrations[state_->camera].registered_from_recorded() * state->world_from_camera;
  }
  return state;
}

CameraModel Replayer::registered_camera() const {
  return state_->last_used_by_operator ? state_->last_used_by_operator->model : state_->operator_camera;
}

std::optional<std::size_t> Replayer::newest_used() const {
  for (auto id = state_->used.rbegin(); id != state_->used.rend(); ++id) {
    if (id->camera == state_->camera) return id->index;
  }
  return std::nullopt;
}

const std::optional<Replayer::UsedPicture>& Replayer::last_used() const {
  return state_->last_used;
}

const std::optional<Replayer::UsedPicture>& Replayer::last_used_by_operator() const {
  return state_->last_used_by_operator;
}

std::optional<RegistrationStatus> Replayer::registration() const {
  if (state_->registrations.empty()) return std::nullopt;
  return state_->registrations[state_->camera].status();
}

cv::Mat Replayer::undistorted_picture(std::size_t index) const {
  return state_->undistortion.undistort(state_->recording.read_picture(state_->camera, index));
}

const cv::Mat& Replayer::usable_pixels() const {
  return state_->undistortion.usable();
}

const ExtractionStatistics& Replayer::statistics() const {
  return state_->statistics;
}
std::size_t Replayer::pictures_extracted() const {
  return state_->pictures_extracted;
}
std::size_t Replayer::pictures_damaged() const {
  return state_->damaged.size();
}
RunCounters Replayer::counters() const {
  RunCounters counters;
  counters.pictures_extracted = state_->pictures_extracted;
  counters.pictures_damaged = state_->damaged.size();
  counters.sum = state_->statistics;
  counters.observed_counted = state_->options.stats;
  counters.describe(state_->store);
  return counters;
}
double Replayer::extraction_seconds() const {
  return state_->seconds;
}

void Replayer::save_textures_if_asked() const {
  if (state_->options.save_textures) save_textures(state_->store, *state_->options.save_textures);
}

}  // namespace foreview
