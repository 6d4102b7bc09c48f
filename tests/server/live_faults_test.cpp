#include <dds/dds.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "fault_stream.h"
#include "foreview/server/dds/wire.h"

#ifdef __SANITIZE_ADDRESS__
// AddressSanitizer keeps 256 MB of what was freed from being used again: resident memory would grow by that much
// whether messages are kept or not. Eight are enough to see what is used soon after it was freed. ASAN_OPTIONS are read
// after these, and those that name no quarantine leave it so.
extern "C" const char* __asan_default_options() {
  return "quarantine_size_mb=8";
}
#endif

// What goes wrong between robots and displays, each on a real topic: sender and receiver are two processes. All that
// arrives is used or counted, every picture has its own pose, the reader waits for nobody.
namespace foreview {
namespace {

using test::Child;
using test::FaultRobot;
using test::milliseconds;
using test::RobotCounts;
using test::SharedWithChildren;
using test::Watcher;

constexpr Duration seconds(std::int64_t count) {
  return {count * 1'000'000'000};
}

/// Sends `count` pictures, `period_ms` apart, stamped with the time.
void send_pictures(int domain, RobotCounts& counts, int count, int period_ms,
                   const std::function<void(CompressedImageMessage&, int)>& change = {}) {
  FaultRobot robot(domain, counts);
  for (int i = 0; i < count; ++i) {
    robot.send(FaultRobot::now(), i, 0, [&](CompressedImageMessage& message) {
      if (change) change(message, i);
    });
    FaultRobot::wait(period_ms);
  }
  counts.ended = true;
  FaultRobot::wait(1000);
}

class LiveFaults : public testing::Test {
 protected:
  SharedWithChildren<RobotCounts> counts;
  const int domain = test::dds_domain() + 10;
};

TEST_F(LiveFaults, AFifthLost) {
  Child robot([&] { send_pictures(domain, *counts, 200, 10); });
  LiveSource::Options options;
  options.link.loss = 0.2;
  Watcher watcher(domain, options);
  watcher.ask_to_the_end(*counts);
  watcher.expect_sums(200);
  const SourceStatus status = watcher.source.status();
  EXPECT_NEAR(static_cast<double>(status.lost), 40, 23);  // four standard deviations
  EXPECT_EQ(status.stateless + status.damaged + status.duplicated, 0U);
  EXPECT_GE(status.used, 80U);
  EXPECT_EQ(status.generation, 0U);
  watcher.report(200);
}

TEST_F(LiveFaults, JitterOf200Milliseconds) {
  Child robot([&] { send_pictures(domain, *counts, 200, 20); });
  LiveSource::Options options;
  options.link.delay = milliseconds(300);
  options.link.jitter = milliseconds(200);
  Watcher watcher(domain, options);
  watcher.ask_to_the_end(*counts);
  watcher.ask_for(milliseconds(1000));
  watcher.expect_sums(200);
  const SourceStatus status = watcher.source.status();
  EXPECT_EQ(status.stateless + status.damaged + status.duplicated, 0U);
  EXPECT_GE(status.used, 100U);
  EXPECT_EQ(status.generation, 0U);
  // Pictures come in another order than they were taken in; each is offered with its own pose (expect_sums).
  std::size_t late = 0;
  for (std::size_t i = 1; i < watcher.seen.size(); ++i) late += watcher.seen[i].stamp < watcher.seen[i - 1].stamp;
  EXPECT_GE(late, 20U);
  EXPECT_LT(watcher.staleness, milliseconds(2500));
  std::printf("%zu of %zu late\n", late, watcher.seen.size());
  watcher.report(200);
}

TEST_F(LiveFaults, Reordering) {
  Child robot([&] { send_pictures(domain, *counts, 200, 10); });
  LiveSource::Options options;
  options.link.delay = milliseconds(20);
  options.link.reordering = 0.3;
  options.link.reordering_delay = milliseconds(60);
  Watcher watcher(domain, options);
  watcher.ask_to_the_end(*counts);
  watcher.expect_sums(200);
  const SourceStatus status = watcher.source.status();
  EXPECT_EQ(status.stateless + status.damaged + status.duplicated, 0U);
  EXPECT_GE(status.used, 100U);
  EXPECT_EQ(status.generation, 0U);
  std::set<int> indices;
  for (const Watcher::Seen& seen : watcher.seen) EXPECT_TRUE(indices.insert(seen.index).second) << "twice";
  watcher.report(200);
}

TEST_F(LiveFaults, EveryPictureTwice) {
  Child robot([&] {
    FaultRobot sender(domain, *counts);
    for (int i = 0; i < 100; ++i) {
      const Timestamp stamp = FaultRobot::now();
      sender.send(stamp, i);
      if (i % 2 == 0) FaultRobot::wait(10);
      sender.send(stamp, i);
      FaultRobot::wait(10);
    }
    counts->ended = true;
    FaultRobot::wait(1000);
  });
  Watcher watcher(domain);
  watcher.ask_to_the_end(*counts);
  watcher.expect_sums(200);
  const SourceStatus status = watcher.source.status();
  EXPECT_NEAR(static_cast<double>(status.duplicated), 100, static_cast<double>(watcher.receiver.lost()));
  std::set<int> indices;
  for (const Watcher::Seen& seen : watcher.seen) EXPECT_TRUE(indices.insert(seen.index).second) << "twice";
  EXPECT_GE(indices.size(), 80U);
  watcher.report(200);
}

TEST_F(LiveFaults, EveryTenthJpegCorrupted) {
  Child robot([&] {
    send_pictures(domain, *counts, 200, 20, [](CompressedImageMessage& message, int i) {
      if (i % 10 != 3) return;
      switch (i / 10 % 3) {
        case 0:
          message.data.resize(message.data.size() / 2);
          break;
        case 1:
          std::fill(message.data.begin() + 20, message.data.begin() + 200, 0x5a);
          break;
        default:
          std::fill(message.data.begin(), message.data.end(), 0xff);
          break;
      }
    });
  });
  Watcher watcher(domain);
  watcher.ask_to_the_end(*counts);
  watcher.expect_sums(200);
  const SourceStatus status = watcher.source.status();
  // Whether a picture is damaged is found out by decoding it: not so of one that a newer one overtook before.
  EXPECT_NEAR(static_cast<double>(status.damaged), 20,
              static_cast<double>(watcher.receiver.lost() + status.overwritten));
  EXPECT_EQ(status.stateless + status.duplicated, 0U);
  // All others: used, but for those that a newer one overtook while this process did not run.
  EXPECT_GE(status.used, 160U);
  for (const Watcher::Seen& seen : watcher.seen) EXPECT_NE(seen.index % 10, 3);
  watcher.report(200);
}

TEST_F(LiveFaults, ThirtySecondsOfSilenceThenReturn) {
  Child robot([&] {
    FaultRobot sender(domain, *counts);
    for (int i = 0; !counts->ended; ++i) {
      sender.send(FaultRobot::now(), i);
      FaultRobot::wait(50);
    }
  });
  Watcher watcher(domain);
  ASSERT_TRUE(watcher.ask_until([&] { return watcher.seen.size() >= 20; }));
  // Not a word, also not of those that say that it is there: DDS takes it for gone after 10 s.
  robot.send_signal(SIGSTOP);
  watcher.ask_for(milliseconds(500));
  const std::size_t before = watcher.seen.size();
  const Timestamp begun = steady_now();
  watcher.staleness = {};
  watcher.ask_for(seconds(30));
  EXPECT_EQ(watcher.seen.size(), before);
  EXPECT_GT(watcher.staleness, milliseconds(29'500));
  EXPECT_LT(watcher.staleness, milliseconds(33'000));
  EXPECT_NE(watcher.receiver.missing(), "");
  robot.send_signal(SIGCONT);
  const Timestamp returned = steady_now();
  ASSERT_TRUE(watcher.ask_until([&] { return watcher.seen.size() >= before + 40; }));
  const Duration back = watcher.seen[before].at - returned;
  EXPECT_EQ(watcher.receiver.missing(), "");
  counts->ended = true;
  watcher.ask_for(milliseconds(500));
  EXPECT_LT(back, seconds(8));
  // The same robot with the same clock: nothing that was seen is void.
  EXPECT_EQ(watcher.source.generation(), 0U);
  std::printf("silent for %.1f s; first picture %.3f s after the return\n", (returned - begun).seconds(),
              back.seconds());
  RecordProperty("back_after_ms", static_cast<int>(back.nanoseconds / 1'000'000));
  // What was sent before DDS knew us again was never on its way to us: only what came can be summed.
  watcher.expect_sums(static_cast<int>(watcher.source.status().pictures_in + watcher.receiver.lost()));
  watcher.report(counts->pictures);
}

/// A sender is killed, and begins again with other stamps and poses.
void restart(int domain, SharedWithChildren<RobotCounts>& counts, Duration back, bool expects_new_generation) {
  const Timestamp base = FaultRobot::now();
  struct Go {
    std::atomic<bool> goes{false};
    std::atomic<std::int64_t> stamp{0};
  };
  const SharedWithChildren<Go> go;
  const auto send = [&](FaultRobot& robot, Timestamp first, int run) {
    const Timestamp begun = FaultRobot::now();
    for (int i = 0; !counts->ended; ++i) {
      robot.send(first + (FaultRobot::now() - begun), i, run);
      if (run == 0) go->stamp = (first + (FaultRobot::now() - begun)).nanoseconds;
      FaultRobot::wait(33);
    }
  };
  Child first([&] {
    FaultRobot robot(domain, *counts);
    send(robot, base, 0);
  });
  Child second([&] {
    if (!test::comes_true([&] { return go->goes.load(); })) _exit(1);
    FaultRobot robot(domain, *counts);
    send(robot, Timestamp{go->stamp.load()} - back, 1);
  });
  Watcher watcher(domain);
  ASSERT_TRUE(watcher.ask_until([&] { return watcher.seen.size() >= 30; }));
  first.end(SIGKILL);
  const int sent_before = counts->pictures;
  go->goes = true;
  watcher.ask_until([&] { return counts->pictures > sent_before; });
  const Timestamp began = steady_now();
  ASSERT_TRUE(watcher.ask_until([&] { return !watcher.seen.empty() && watcher.seen.back().run == 1; }));
  const Duration until_seen = steady_now() - began;
  // Nothing of the first one afterwards, and nothing in between them.
  const std::size_t switched = watcher.seen.size() - 1;
  watcher.ask_for(milliseconds(1000));
  counts->ended = true;
  watcher.ask_for(milliseconds(500));
  for (std::size_t i = switched; i < watcher.seen.size(); ++i) EXPECT_EQ(watcher.seen[i].run, 1);
  EXPECT_GE(watcher.seen.size() - switched, 15U);
  EXPECT_EQ(watcher.source.generation(), expects_new_generation ? 1U : 0U);
  EXPECT_EQ(watcher.seen[switched].generation, expects_new_generation ? 1U : 0U);
  EXPECT_LT(until_seen, seconds(3));
  std::printf("stamps %.1f s back: seen %.3f s after its first picture\n", back.seconds(), until_seen.seconds());
  testing::Test::RecordProperty("seen_after_ms", static_cast<int>(until_seen.nanoseconds / 1'000'000));
  watcher.expect_sums(static_cast<int>(watcher.source.status().pictures_in + watcher.source.status().duplicated +
                                       watcher.receiver.lost()));
  watcher.report(counts->pictures);
}

TEST_F(LiveFaults, SenderRestartedStampsGoOn) {
  restart(domain, counts, milliseconds(-1500), false);
}
TEST_F(LiveFaults, SenderRestartedStampsHalfASecondBack) {
  restart(domain, counts, milliseconds(500), true);
}
TEST_F(LiveFaults, SenderRestartedStampsAThousandSecondsBack) {
  restart(domain, counts, seconds(1000), true);
}

TEST_F(LiveFaults, ClockJumps) {
  // Run r is sent for two seconds with the clock set to something else.
  const std::vector<Duration> jumps{{}, milliseconds(-1500), seconds(3600), seconds(-7200), milliseconds(700)};
  Child robot([&] {
    FaultRobot sender(domain, *counts);
    Duration offset;
    for (std::size_t run = 0; run < jumps.size(); ++run) {
      offset = offset + jumps[run];
      for (int i = 0; i < 80; ++i) {
        sender.send(FaultRobot::now() + offset, i, static_cast<int>(run));
        FaultRobot::wait(25);
      }
    }
    counts->ended = true;
    FaultRobot::wait(1000);
  });
  Watcher watcher(domain);
  watcher.ask_to_the_end(*counts);
  for (std::size_t run = 0; run < jumps.size(); ++run) {
    std::vector<int> indices;
    for (const Watcher::Seen& seen : watcher.seen) {
      if (seen.run == static_cast<int>(run)) indices.push_back(seen.index);
    }
    ASSERT_FALSE(indices.empty()) << run;
    // From 1 s after the jump on, all go through.
    const auto late = std::count_if(indices.begin(), indices.end(), [](int index) { return index >= 40; });
    std::printf("clock set by %.1f s: %zu of 80 pictures used, the first is number %d\n", jumps[run].seconds(),
                indices.size(), indices.front());
    EXPECT_GE(late, 30) << run;
  }
  // Set back twice; set forward, the stream goes on.
  EXPECT_EQ(watcher.source.generation(), 2U);
  const SourceStatus status = watcher.source.status();
  // The clock's estimate follows: what is shown is as old as it is, not hours.
  EXPECT_LT(std::abs((status.now - watcher.seen.back().stamp).seconds()), 5);
  watcher.expect_sums(400);
  watcher.report(400);
}

TEST_F(LiveFaults, CameraInfoChangesSizeInMidStream) {
  Child robot([&] {
    FaultRobot sender(domain, *counts);
    for (int i = 0; i < 120; ++i) {
      if (i == 40) sender.size = {96, 64};
      if (i == 80) sender.size = {32, 96};
      sender.send(FaultRobot::now(), i);
      FaultRobot::wait(20);
    }
    counts->ended = true;
    FaultRobot::wait(1000);
  });
  Watcher watcher(domain);
  watcher.ask_to_the_end(*counts);
  watcher.expect_sums(120);
  const SourceStatus status = watcher.source.status();
  // A picture and its camera_info are two messages: between them one may be taken for the other's.
  EXPECT_LE(status.damaged, 4U);
  EXPECT_EQ(status.stateless, 0U);
  std::map<int, int> of_width;
  for (const Watcher::Seen& seen : watcher.seen) {
    ++of_width[seen.size.width];
    EXPECT_EQ(seen.size.width, seen.index < 40 ? 64 : seen.index < 80 ? 96 : 32);
  }
  for (const int width : {64, 96, 32}) EXPECT_GE(of_width[width], 30) << width;
  watcher.report(120);
}

/// Sends garbage for five seconds, 100 Mbit/s together: random bytes as pictures, pictures of random bytes that begin
/// as a JPEG does, and messages that are not decodable, being of another type by the same name.
void send_garbage(int domain, RobotCounts& counts, int kind) {
  constexpr std::size_t kBytes = 60'000;
  constexpr double kRate = 100e6 / 8 / 3;
  const DdsNode node({domain});  // sets up the domain
  std::mt19937 random(static_cast<unsigned>(kind));
  std::vector<std::uint8_t> noise(kBytes * 2);
  for (auto& byte : noise) byte = static_cast<std::uint8_t>(random());
  const dds_entity_t participant = dds_create_participant(static_cast<dds_domainid_t>(domain), nullptr, nullptr);
  dds_topic_descriptor_t descriptor =
      kind == 2 ? wire::Type<ImageMessage>::descriptor() : wire::Type<CompressedImageMessage>::descriptor();
  descriptor.m_typename = wire::Type<CompressedImageMessage>::descriptor().m_typename;
  const std::string name = std::string("rt") + test::kFaultTopic;
  const dds_entity_t topic = dds_create_topic(participant, &descriptor, name.c_str(), nullptr, nullptr);
  dds_qos_t* qos = dds_create_qos();
  const dds_data_representation_id_t representation = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos, 1, &representation);
  dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
  const dds_entity_t writer = dds_create_writer(participant, topic, qos, nullptr);
  dds_delete_qos(qos);
  const bool heard = test::comes_true([&] {
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writer, &status);
    return status.current_count > 0;
  });
  if (writer < 0 || !heard) _exit(1);
  FaultRobot::wait(200);
  const Timestamp begun = steady_now();
  std::int64_t bytes = 0;
  while (steady_now() - begun < seconds(5)) {
    const std::size_t first = random() % kBytes;
    const std::vector<std::uint8_t> data(noise.begin() + static_cast<std::ptrdiff_t>(first),
                                         noise.begin() + static_cast<std::ptrdiff_t>(first + kBytes));
    const MessageHeader header{{FaultRobot::now().nanoseconds + static_cast<std::int64_t>(random()) - (1LL << 31)},
                               "optical"};
    wire::Lending lending;
    if (kind == 2) {
      const ImageMessage message{header, 4'000'000'000U, 77, "jpeg", false, 1, data};
      const auto sample = wire::Type<ImageMessage>::lend(message, lending);
      dds_write(writer, &sample);
    } else {
      CompressedImageMessage message{header, "jpeg", data};
      if (kind == 1) message.data[0] = 0xff, message.data[1] = 0xd8, message.data[2] = 0xff;
      const auto sample = wire::Type<CompressedImageMessage>::lend(message, lending);
      dds_write(writer, &sample);
    }
    bytes += static_cast<std::int64_t>(kBytes);
    ++counts.garbage;
    const Duration ahead{static_cast<std::int64_t>(static_cast<double>(bytes) / kRate * 1e9) -
                         (steady_now() - begun).nanoseconds};
    if (ahead.nanoseconds > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(ahead.nanoseconds));
  }
  counts.garbage_bytes += bytes;
  counts.garbage_nanoseconds = (steady_now() - begun).nanoseconds;
  FaultRobot::wait(500);
}

TEST_F(LiveFaults, HundredMegabitsOfGarbagePerSecondOnTheTopic) {
  const auto& shared = *counts;
  Child robot([&] {
    FaultRobot sender(domain, *counts);
    // Before, during and after the garbage.
    for (int i = 0; i < 320; ++i) {
      sender.send(FaultRobot::now(), i);
      FaultRobot::wait(25);
    }
    counts->ended = true;
    FaultRobot::wait(1000);
  });
  const auto garbage = [&](int kind) {
    if (!test::comes_true([&] { return counts->pictures > 60; })) _exit(1);
    send_garbage(domain, *counts, kind);
  };
  Child noise([&] { garbage(0); });
  Child almost_jpegs([&] { garbage(1); });
  Child undecodable([&] { garbage(2); });
  Watcher watcher(domain);
  ASSERT_TRUE(watcher.ask_until([&] { return shared.pictures > 50; }));
  const std::int64_t before = test::resident_kib();
  std::int64_t most = before;
  ASSERT_TRUE(watcher.ask_until([&] {
    most = std::max(most, test::resident_kib());
    return shared.ended.load();
  }));
  watcher.ask_to_the_end(shared);
  EXPECT_TRUE(noise.wait() && almost_jpegs.wait() && undecodable.wait());
  const double rate = static_cast<double>(shared.garbage_bytes) * 8 / static_cast<double>(shared.garbage_nanoseconds);
  const SourceStatus status = watcher.source.status();
  std::printf("garbage: %d messages, %.0f Mbit/s; resident memory grew by %.1f MiB; %zu good pictures of 320 used\n",
              shared.garbage.load(), rate * 1e3, static_cast<double>(most - before) / 1024, watcher.seen.size());
  RecordProperty("garbage_mbit_per_s", static_cast<int>(rate * 1e3));
  RecordProperty("resident_growth_kib", static_cast<int>(most - before));
  EXPECT_GE(rate * 1e3, 90);
  EXPECT_LT(most - before, 48 * 1024);
  EXPECT_EQ(status.generation, 0U);
  EXPECT_GE(watcher.seen.size(), 240U);
  EXPECT_GE(status.damaged, 200U);
  watcher.report(320 + shared.garbage);
  watcher.expect_sums(320 + shared.garbage);
}

}  // namespace
}  // namespace foreview
