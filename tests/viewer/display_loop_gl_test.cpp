#include "foreview/viewer/display_loop.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "gpu/gl_test_fixture.h"
#include "gpu/test_model.h"
#include "viewer/simulated_loop.h"

namespace foreview {
namespace {

using test::ms;

/// A loop in simulated time: GL is there, but costs nothing.
class DisplayLoopTest : public GlTest {
 protected:
  DisplayLoopTest() {
    options_.period = ms(20);
    callbacks_.poll = [this] { return ++polls_ <= most_polls_; };
    callbacks_.draw = [this](const FrameMoment& moment) {
      EXPECT_FALSE(platform_.extraction_is_current);
      EXPECT_EQ(moment.now, platform_.time);
      moments_.push_back(moment);
      newest_.push_back(moment.newest != nullptr ? std::optional(moment.newest->record) : std::nullopt);
      platform_.time = platform_.time + drawing_;
    };
    callbacks_.frame_completed = [this](const FrameRecord& frame) { frames_.push_back(frame); };
    callbacks_.displayed = [this](const PictureRecord& picture) { displayed_.push_back(picture); };
    callbacks_.slice_completed = [this](const SliceRecord& slice) { slices_.push_back(slice); };
    callbacks_.restart = [this] {
      EXPECT_TRUE(platform_.extraction_is_current);
      ++restarts_;
      extraction_.clear();
    };
  }

  DisplayLoop& loop() {
    if (!loop_) {
      loop_.emplace(platform_, options_, store_, source_, callbacks_);
      loop_->set_extraction(&extraction_);
    }
    return *loop_;
  }
  void add_pictures(Duration interval, std::size_t count) {
    Timestamp when = platform_.time;
    for (std::size_t i = 0; i < count; ++i, when = when + interval) source_.add(when, i);
  }
  void run_for(Duration duration) { loop().run_until(platform_.time + duration); }

  const PolygonModel model_ = rows_of_quads({2});
  test::SimulatedPlatform platform_;
  TextureStore store_{model_, tight_layout(model_, {{16, 16}}, 64), Publishing::buffered};
  test::SimulatedSource source_{platform_};
  test::SimulatedExtraction extraction_{platform_, store_};
  DisplayLoop::Options options_;
  DisplayLoop::Callbacks callbacks_;
  Duration drawing_ = ms(5);
  std::size_t polls_ = 0, most_polls_ = 1'000'000, restarts_ = 0;
  std::vector<FrameMoment> moments_;                  ///< without what they point to
  std::vector<std::optional<PictureRecord>> newest_;  ///< of each moment
  std::vector<FrameRecord> frames_;
  std::vector<PictureRecord> displayed_;
  std::vector<SliceRecord> slices_;
  std::optional<DisplayLoop> loop_;
};

TEST_F(DisplayLoopTest, FramesAreInTimeBesideExtraction) {
  add_pictures(ms(40), 100);
  run_for(ms(4000));
  const DisplayLoop::Statistics statistics = loop().statistics();
  EXPECT_NEAR(static_cast<double>(statistics.schedule.due), 200, 1);
  // Until costs are learnt, what was declared holds: twice what it is for slices, as much for frames.
  EXPECT_EQ(statistics.schedule.late, 0);
  EXPECT_EQ(statistics.schedule.skipped, 0);
  EXPECT_EQ(statistics.schedule.missed, 0);
  EXPECT_EQ(statistics.pictures_finished, 100U);
  EXPECT_NEAR(statistics.frames_per_second, 50, 1);
  EXPECT_NEAR(statistics.pictures_per_second, 25, 1);
  for (const FrameRecord& frame : frames_) {
    EXPECT_LE(frame.completed, frame.due);
    EXPECT_GE(frame.completed, frame.due - ms(0.6)) << "it could have shown newer input";
  }
}

TEST_F(DisplayLoopTest, SlicesAreAsLongAsTheyMayBeAndNoLonger) {
  add_pictures(ms(40), 100);
  run_for(ms(2000));
  slices_.clear();
  run_for(ms(2000));
  ASSERT_FALSE(slices_.empty());
  std::size_t full = 0;
  for (const SliceRecord& slice : slices_) {
    EXPECT_LE(slice.completed - slice.started, options_.slice + ms(0.01));
    full += slice.completed - slice.started > options_.slice + ms(-0.2) ? 1 : 0;
  }
  // 20 ms of work a picture: 9 whole slices, one that is left, one that hands over; now and then one cut at a frame.
  EXPECT_GT(full, slices_.size() / 2);
}

TEST_F(DisplayLoopTest, ExtractionNeverStarvesHoweverLongFramesTake) {
  drawing_ = ms(19.4);
  add_pictures(ms(40), 1000);
  run_for(ms(20000));
  EXPECT_GT(loop().statistics().pictures_finished, 20U);
  EXPECT_GT(loop().statistics().schedule.skipped, 100);
  EXPECT_GT(frames_.size(), 400U);
}

TEST_F(DisplayLoopTest, SaysWhichPictureAFrameShowsAndWhenItWasFirstSeen) {
  add_pictures(ms(40), 50);
  run_for(ms(2500));
  ASSERT_EQ(displayed_.size(), 50U);
  std::uint64_t last = 0;
  for (const FrameMoment& moment : moments_) {
    EXPECT_GE(moment.picture, last);
    last = moment.picture;
    const std::optional<PictureRecord>& newest = newest_[static_cast<std::size_t>(moment.number)];
    ASSERT_EQ(newest.has_value(), moment.picture > 0);
    if (newest) {
      EXPECT_EQ(newest->picture, moment.picture);
      EXPECT_EQ(newest->index + 1, moment.picture);
    }
  }
  for (std::size_t i = 0; i < displayed_.size(); ++i) {
    const PictureRecord& picture = displayed_[i];
    EXPECT_EQ(picture.index, i);
    const auto first = std::ranges::find_if(frames_, [&](const auto& f) { return f.picture >= picture.picture; });
    ASSERT_NE(first, frames_.end());
    EXPECT_EQ(picture.displayed, first->completed);
    EXPECT_EQ(picture.age_when_displayed, picture.displayed - picture.captured);
    EXPECT_GE(first->started, picture.finished);
    EXPECT_GE(picture.slices, 9U);
    // 0.2 ms a slice and 1 ms a unit.
    EXPECT_NEAR(picture.step_ms[static_cast<std::size_t>(ExtractionStep::normalisation)],
                20 + 0.2 * static_cast<double>(picture.slices - 1), 0.01);
    EXPECT_NEAR(picture.step_ms[static_cast<std::size_t>(ExtractionStep::publishing)], 0.5, 0.01);
  }
}

TEST_F(DisplayLoopTest, KnowsTheNewestPictureOfEachCameraByCapture) {
  std::vector<std::size_t> seen_of_camera[2];
  std::vector<std::size_t> newest;
  const auto draw = callbacks_.draw;
  callbacks_.draw = [&](const FrameMoment& moment) {
    draw(moment);
    for (const ShownPicture& picture : moment.pictures) {
      EXPECT_EQ(picture.frame.state.stamp, picture.record.captured);
      seen_of_camera[picture.record.camera].push_back(picture.record.index);
    }
    if (moment.newest != nullptr) newest.push_back(moment.newest->record.index);
  };
  // The second picture of camera 0 comes last, though it was captured first: it only fills.
  for (const std::size_t index : {2U, 3U, 1U}) {
    source_.add(platform_.time + ms(50.0 * static_cast<double>(source_.arrivals.size())), index);
    source_.arrivals.back().frame.camera = index == 3 ? 1 : 0;
    source_.arrivals.back().frame.frame.state.stamp = platform_.time + ms(static_cast<double>(index));
  }
  run_for(ms(400));
  EXPECT_EQ(displayed_.size(), 3U);
  ASSERT_FALSE(seen_of_camera[0].empty());
  ASSERT_FALSE(seen_of_camera[1].empty());
  EXPECT_EQ(std::ranges::count(seen_of_camera[0], 2U), static_cast<std::ptrdiff_t>(seen_of_camera[0].size()));
  EXPECT_EQ(std::ranges::count(seen_of_camera[1], 3U), static_cast<std::ptrdiff_t>(seen_of_camera[1].size()));
  EXPECT_EQ(newest.back(), 3U);
}

TEST_F(DisplayLoopTest, AsksForInputWhenTheFrameBeginsAndSaysWhenItWillBeSeen) {
  platform_.oversleep = ms(0.05);
  run_for(ms(1000));
  ASSERT_EQ(moments_.size(), frames_.size());
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    EXPECT_EQ(moments_[i].now, frames_[i].started);
    if (i >= 40) {  // what frames cost is known
      EXPECT_EQ(moments_[i].seen, frames_[i].due);
    }
  }
}

TEST_F(DisplayLoopTest, WithoutAnythingToExtractFramesGoOn) {
  loop().set_extraction(nullptr);
  add_pictures(ms(40), 10);
  run_for(ms(1000));
  EXPECT_NEAR(static_cast<double>(frames_.size()), 50, 1);
  EXPECT_EQ(source_.taken, 0U);
  EXPECT_EQ(platform_.switches, 0U);
}

TEST_F(DisplayLoopTest, APictureThatComesWhileWaitingIsTakenUpAtOnce) {
  source_.add(platform_.time + ms(103), 0);
  run_for(ms(200));
  ASSERT_EQ(displayed_.size(), 1U);
  EXPECT_LE(displayed_[0].begun - displayed_[0].received, ms(1));
}

TEST_F(DisplayLoopTest, AnotherRateHoldsFromTheNextFrameOn) {
  add_pictures(ms(40), 200);
  run_for(ms(1000));
  loop().set_period(ms(10));
  frames_.clear();
  run_for(ms(1000));
  EXPECT_NEAR(static_cast<double>(frames_.size()), 100, 1);
  EXPECT_EQ(loop().statistics().schedule.missed, 0);
  EXPECT_EQ(loop().statistics().period, ms(10));
}

TEST_F(DisplayLoopTest, WhatPresentTakesIsPartOfTheFrameUnlessItWaits) {
  callbacks_.present = [this] { platform_.time = platform_.time + ms(3); };
  run_for(ms(2000));
  EXPECT_GE(loop().statistics().frame_cost, ms(8));
  for (std::size_t i = 40; i < frames_.size(); ++i) EXPECT_LE(frames_[i].completed, frames_[i].due);

  loop_.reset();
  options_.present_waits = true;
  run_for(ms(2000));
  EXPECT_LE(loop().statistics().frame_cost, ms(5.1));
}

TEST_F(DisplayLoopTest, EndsWhenAskedTo) {
  most_polls_ = 10;
  EXPECT_NO_THROW(run_for(ms(10000)));
  EXPECT_EQ(frames_.size(), 10U);
  EXPECT_FALSE(loop().run_frame());
  most_polls_ = 100;
  EXPECT_TRUE(loop().run_frame());
}

TEST_F(DisplayLoopTest, ThrowsWhatCallbacksThrowAndCanGoOn) {
  add_pictures(ms(40), 500);
  const auto draw = callbacks_.draw;
  bool fails_in_draw = false, fails_in_poll = false, fails_in_present = false;
  const auto fail = [](bool& fails, const char* what) {
    if (std::exchange(fails, false)) throw std::runtime_error(what);
  };
  callbacks_.draw = [&](const FrameMoment& moment) {
    draw(moment);
    fail(fails_in_draw, "draw");
  };
  callbacks_.poll = [&] {
    fail(fails_in_poll, "poll");
    return true;
  };
  callbacks_.present = [&] { fail(fails_in_present, "present"); };
  for (bool* fails : {&fails_in_draw, &fails_in_poll, &fails_in_present}) {
    run_for(ms(200));
    *fails = true;
    EXPECT_THROW(run_for(ms(200)), std::runtime_error);
    EXPECT_FALSE(platform_.extraction_is_current);
  }
  const std::size_t before = frames_.size(), pictures = displayed_.size();
  run_for(ms(1000));
  EXPECT_GE(frames_.size(), before + 48);
  // A set that was not released could never be written again.
  EXPECT_GE(displayed_.size(), pictures + 20);
}

TEST_F(DisplayLoopTest, ALostContextEndsItWithAMessage) {
  add_pictures(ms(40), 500);
  run_for(ms(500));
  for (const char* lost : {"a frame", "extracting textures"}) {
    platform_.on_finish = [&](const char* what) {
      if (std::string(what) == lost) throw ContextLost(std::string("lost with ") + what);
    };
    try {
      run_for(ms(500));
      FAIL() << "not noticed";
    } catch (const ContextLost& error) {
      EXPECT_EQ(error.what(), std::string("lost with ") + lost);
    }
    EXPECT_FALSE(platform_.extraction_is_current);
  }
}

TEST_F(DisplayLoopTest, PicturesThatCannotBeExtractedFromAreLeftOut) {
  add_pictures(ms(40), 50);
  std::size_t begun = 0;
  extraction_.on_begin = [&](const CameraFrame&) {
    if (++begun % 2 == 0) throw InputError("picture", "is no good; expected a good one");
  };
  run_for(ms(2500));
  EXPECT_EQ(loop().statistics().pictures_refused, 25U);
  EXPECT_EQ(loop().statistics().pictures_finished, 25U);
  EXPECT_EQ(displayed_.size(), 25U);
  EXPECT_EQ(loop().statistics().schedule.late, 0);
}

TEST_F(DisplayLoopTest, ANewGenerationOfTheSourceBeginsAfresh) {
  add_pictures(ms(40), 20);
  run_for(ms(400));
  while (!loop().is_extracting()) ASSERT_TRUE(loop().run_frame());
  const std::uint64_t shown = moments_.back().picture;
  ++source_.current_generation;
  newest_.clear();
  run_for(ms(100));
  EXPECT_EQ(restarts_, 1U);
  EXPECT_FALSE(loop().is_extracting());
  // What is still on its way belongs to the generation before.
  for (const auto& newest : newest_) EXPECT_FALSE(newest) << newest->index;
  source_.arrivals.clear();
  source_.add(platform_.time, 1000);
  run_for(ms(200));
  ASSERT_TRUE(newest_.back());
  EXPECT_EQ(newest_.back()->index, 1000U);
  EXPECT_GT(moments_.back().picture, shown);
  EXPECT_EQ(loop().statistics().restarts, 1U);
}

TEST_F(DisplayLoopTest, ExtractionCanBeExchanged) {
  add_pictures(ms(40), 200);
  run_for(ms(400));
  while (!loop().is_extracting()) ASSERT_TRUE(loop().run_frame());
  in_extraction_context(platform_, [&] { extraction_.clear(); });
  loop().set_extraction(nullptr);
  const auto before = loop().statistics();
  test::SimulatedExtraction other(platform_, store_);
  other.units = 5;
  loop().set_extraction(&other);
  run_for(ms(1000));
  EXPECT_GE(loop().statistics().pictures_finished, before.pictures_finished + 20);
  EXPECT_GT(loop().statistics().schedule.frames, before.schedule.frames + 40);
  EXPECT_EQ(loop().statistics().schedule.late, 0);
  loop().set_extraction(nullptr);
}

}  // namespace
}  // namespace foreview
