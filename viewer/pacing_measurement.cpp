#include "foreview/viewer/pacing_measurement.h"

#include <algorithm>
#include <vector>

namespace foreview {
namespace {

FrameSchedule::Statistics difference(const FrameSchedule::Statistics& now, const FrameSchedule::Statistics& before) {
  FrameSchedule::Statistics result = now;
  result.due -= before.due;
  result.frames -= before.frames;
  result.late -= before.late;
  result.skipped -= before.skipped;
  result.missed -= before.missed;
  result.slices -= before.slices;
  result.oversize_slices -= before.oversize_slices;
  result.frame_overruns -= before.frame_overruns;
  result.slice_overruns -= before.slice_overruns;
  result.stops -= before.stops;
  result.extraction = result.extraction + Duration{-before.extraction.nanoseconds};
  return result;
}

/// Since the interval before.
PacingRun::Interval interval_of(const PacingRun& run, const FrameSchedule::Statistics& schedule, Timestamp now) {
  PacingRun::Interval interval;
  const Timestamp from =
      run.intervals.empty() ? run.started : run.started + Duration::from_seconds(run.intervals.back().seconds);
  std::vector<double> completions;
  for (const FrameRecord& frame : run.frames) {
    if (frame.completed <= from) continue;
    completions.push_back(1e-6 * static_cast<double>((frame.completed - frame.due).nanoseconds));
  }
  for (const PictureRecord& picture : run.pictures) interval.pictures += picture.displayed > from ? 1 : 0;
  const PacingSummary::Spread spread = spread_of(std::move(completions));
  interval.seconds = (now - run.started).seconds();
  interval.frames = static_cast<std::size_t>(schedule.frames);
  interval.late = schedule.late;
  interval.skipped = schedule.skipped;
  interval.missed = schedule.missed;
  interval.median_ms = spread.median;
  interval.p99_ms = spread.p99;
  interval.worst_ms = spread.worst;
  interval.resources = count_resources();
  return interval;
}

PacingRun begin_run(LiveScene& scene, const PacingRequest& request) {
  PacingRun run;
  run.slice_bound_ms = 1e-6 * static_cast<double>(request.loop.slice.nanoseconds);
  for (const SliceKind& kind : scene.extraction().slice_kinds()) run.slices.push_back({kind.name});
  return run;
}

void count(PacingRun& run, const SliceRecord& slice) {
  PacingRun::Kind& kind = run.slices[slice.kind];
  const double ms = 1e-6 * static_cast<double>((slice.completed - slice.started).nanoseconds);
  ++kind.slices;
  kind.over_bound += ms > run.slice_bound_ms ? 1 : 0;
  kind.total_ms += ms;
  kind.worst_ms = std::max(kind.worst_ms, ms);
}

}  // namespace

PacingRun measure_pacing(LiveScene& scene, FrameSource& source, const PacingRequest& request) {
  PacingRun run = begin_run(scene, request);
  run.name = request.extraction ? "both" : "display alone";
  run.period = request.period;
  DisplayLoop::Options options = request.loop;
  options.period = request.period;
  bool counts = false;
  DisplayLoop::Callbacks callbacks;
  callbacks.draw = request.draw;
  callbacks.poll = request.poll;
  callbacks.restart = [&] { scene.restart(); };
  callbacks.frame_completed = [&](const FrameRecord& frame) {
    if (counts) run.add(frame);
  };
  callbacks.displayed = [&](const PictureRecord& picture) {
    if (counts) run.add(picture);
    if (request.displayed) request.displayed(picture);
  };
  callbacks.slice_completed = [&](const SliceRecord& slice) {
    if (counts) count(run, slice);
  };
  LoopPlatform& platform = request.platform != nullptr ? *request.platform : scene.platform();
  DisplayLoop loop(platform, options, scene.store(), source, callbacks);
  if (request.extraction) loop.set_extraction(&scene.extraction());
  const Timestamp begun = platform.now();
  loop.run_until(begun + request.warm_up);
  const DisplayLoop::Statistics before = loop.statistics();
  run.started = platform.now();
  counts = true;
  const Timestamp end = run.started + request.duration;
  FrameSchedule::Statistics last = before.schedule;
  bool goes_on = true;
  for (Timestamp interval = run.started; goes_on && interval < end;) {
    interval = std::min(interval + PacingRun::kInterval, end);
    loop.run_until(interval);
    goes_on = platform.now() >= interval;  // else poll() asked for the end
    const FrameSchedule::Statistics now = loop.statistics().schedule;
    run.intervals.push_back(interval_of(run, difference(now, last), platform.now()));
    last = now;
    if (request.interval_ended) request.interval_ended(run.intervals.back());
  }
  run.ended = platform.now();
  run.schedule = difference(last, before.schedule);
  run.restarts = loop.statistics().restarts - before.restarts;
  if (request.at_end) request.at_end();
  in_extraction_context(platform, [&] { scene.extraction().clear(); });
  return run;
}

PacingRun measure_extraction_alone(LiveScene& scene, FrameSource& source, const PacingRequest& request) {
  PacingRun run = begin_run(scene, request);
  run.name = "extraction alone";
  LoopPlatform& platform = scene.platform();
  ExtractionPipeline& extraction = scene.extraction();
  in_extraction_context(platform, [&] {
    const Timestamp begun = platform.now();
    run.started = begun + request.warm_up;
    const Timestamp end = run.started + request.duration;
    Timestamp now = begun;
    while (now < end && (!request.poll || request.poll())) {
      std::optional<IncomingFrame> incoming = source.take();
      if (!incoming) {
        platform.sleep_until(now + Duration{1'000'000});
        now = platform.now();
        continue;
      }
      PictureRecord picture;
      picture.index = incoming->index;
      picture.begun = now;
      extraction.begin(std::move(incoming->frame));
      while (extraction.is_busy()) {
        scene.store().wait_for_free_set();
        const auto slice = extraction.pending_slice();
        if (slice) static_cast<void>(extraction.run_slice(slice->size));
      }
      platform.finish("extracting textures");
      now = picture.finished = platform.now();
      if (picture.begun >= run.started) run.pictures.push_back(picture);
    }
    run.ended = std::max(now, run.started);
    extraction.clear();
  });
  return run;
}

}  // namespace foreview
