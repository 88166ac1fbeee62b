#include "record/recorder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <thread>

#include "record/recording.h"
#include "record/schemas.h"
#include "tests/record/support.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/reports.h"

namespace takt::record {
namespace {

using takt::test::Reports;

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// 5 s at 1 kHz, of which the last second is kept if `keep_at` (a cycle) is within them.
RecorderStatus record_last_second(const std::filesystem::path& path, std::uint64_t keep_at) {
  RecorderOptions options;
  options.keep_last = kSecond;
  auto recorder = Recorder::open(path, options).value();
  SampleRun run(*recorder);
  for (std::uint64_t k = 0; k < 5000; ++k) {
    run.cycle(k);
    if (k == keep_at) recorder->keep();
  }
  if (keep_at == 5000) recorder->keep();
  return recorder->close();
}

TEST(Recorder, TheLastSecondsAreWrittenIfSomethingHappens) {
  TestFolder folder("last");
  EXPECT_TRUE(record_last_second(folder / "a.mcap", 9999).removed);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.mcap")) << "nothing happened";

  const RecorderStatus status = record_last_second(folder / "b.mcap", 3000);
  EXPECT_FALSE(status.removed);
  EXPECT_EQ(status.error, "");
  const Table kept = Recording::open(folder / "b.mcap").value().table("/left/joints").value();
  EXPECT_LE(kept.time.front(), 2 * kSecond);
  EXPECT_GT(kept.time.front(), 2 * kSecond - 250 * kMillisecond) << "and little more";
  EXPECT_EQ(kept.time.back(), 4 * kSecond) << "a second of what came of it";
  EXPECT_EQ(kept.time.size(), static_cast<std::size_t>((kept.time.back() - kept.time.front()) / kMillisecond) + 1);
  EXPECT_EQ(kept.values[1][10], SampleRun::position(static_cast<std::uint64_t>(kept.time[10] / kMillisecond), 1));

  EXPECT_FALSE(record_last_second(folder / "c.mcap", 5000).removed);
  const Recording end = Recording::open(folder / "c.mcap").value();
  EXPECT_EQ(end.end_time(), 4999 * kMillisecond);
  EXPECT_GT(end.start_time(), 3700 * kMillisecond);
  EXPECT_THAT(end.damage(), IsEmpty());
}

TEST(Recorder, EachFaultHasAStretchOfItsOwn) {
  TestFolder folder("stretches");
  RecorderOptions options;
  options.keep_last = kSecond;
  auto recorder = Recorder::open(folder / "a.mcap", options).value();
  SampleRun run(*recorder);
  for (std::uint64_t k = 0; k < 20000; ++k) {
    run.cycle(k);
    // The second within what follows the first; the third later, before its second is over again.
    if (k == 3000 || k == 3500 || k == 10000 || k == 11500) recorder->keep();
  }
  EXPECT_FALSE(recorder->close().removed);
  const Recording recording = Recording::open(folder / "a.mcap").value();
  EXPECT_THAT(recording.damage(), IsEmpty());
  const std::vector<Nanoseconds> time = recording.table("/left/joints").value().time;
  std::vector<std::pair<Nanoseconds, Nanoseconds>> stretches{{time.front(), time.front()}};
  for (const Nanoseconds at : time) {
    if (at - stretches.back().second > kMillisecond) stretches.emplace_back(at, at);
    EXPECT_LE(at - stretches.back().second, kMillisecond) << "whole";
    stretches.back().second = at;
  }
  ASSERT_EQ(stretches.size(), 2u);
  EXPECT_NEAR(to_seconds(stretches[0].first), 1.9, 0.11);
  EXPECT_EQ(stretches[0].second, 4500 * kMillisecond);
  EXPECT_NEAR(to_seconds(stretches[1].first), 8.9, 0.11);
  EXPECT_EQ(stretches[1].second, 12500 * kMillisecond);
}

TEST(Recorder, WhatIsKeptIsOnTheDiskBeforeTheEnd) {
  TestFolder folder("kept_early");
  RecorderOptions options;
  options.keep_last = kSecond;
  auto recorder = Recorder::open(folder / "a.mcap", options).value();
  SampleRun run(*recorder);
  for (std::uint64_t k = 0; k < 2000; ++k) run.cycle(k);
  EXPECT_EQ(Recording::open(folder / "a.mcap").value().rows("/left/joints"), 0u) << "nothing has happened";
  recorder->keep();
  run.cycle(2000);
  std::this_thread::sleep_for(std::chrono::milliseconds(400));  // as if it were killed now
  EXPECT_GE(Recording::open(folder / "a.mcap").value().rows("/left/joints"), 1000u);
}

TEST(Recorder, AConstantMessageIsTheFirst) {
  TestFolder folder("constant");
  auto recorder = Recorder::open(folder / "a.mcap").value();
  recorder->add_constant("/scene", kSceneUpdateSchema, "some bytes");
  SampleRun run(*recorder);
  for (std::uint64_t k = 0; k < 10; ++k) run.cycle(k + 7);
  EXPECT_EQ(recorder->close().error, "");
  const Recording recording = Recording::open(folder / "a.mcap").value();
  std::vector<std::string> topics;
  std::string first;
  recording.for_each([&](const MessageView& message) {
    topics.push_back(message.channel->topic);
    if (topics.size() == 1) first.assign(reinterpret_cast<const char*>(message.data.data()), message.data.size());
    return true;
  });
  EXPECT_EQ(topics.front(), "/scene");
  EXPECT_EQ(first, "some bytes");
  EXPECT_EQ(std::ranges::count(topics, "/scene"), 1);
  EXPECT_EQ(recording.start_time(), 7 * kMillisecond);
  EXPECT_EQ(recording.find_channel("/scene")->schema, "foxglove.SceneUpdate");
}

TEST(Recorder, ComesBackAsWritten) {
  TestFolder folder("round");
  RecorderOptions options;
  options.metadata = {{"scenario", "touch"}, {"seed", "7"}};
  options.fingerprint = fingerprint({{"mujoco", "4.0.1"}});
  options.attachments = {{"touch.json", "application/json", "{\"seed\": 7}"}};
  const RecorderStatus status = record_run(folder / "a.mcap", 300, options);
  EXPECT_EQ(status.error, "");
  EXPECT_EQ(status.refused_rows, 0u);
  EXPECT_EQ(status.messages, 300u * 6 + 8 + 5);

  const Recording recording = Recording::open(folder / "a.mcap").value();
  EXPECT_THAT(recording.damage(), IsEmpty());
  EXPECT_FALSE(recording.truncated_at());
  EXPECT_EQ(recording.message_count(), status.messages);
  EXPECT_EQ(recording.end_time(), 299 * kMillisecond);
  EXPECT_EQ(recording.metadata().at("takt.run").at("seed"), "7");
  EXPECT_EQ(recording.metadata().at("takt.run").at("hash:touch.json"), content_hash("{\"seed\": 7}"));
  EXPECT_EQ(recording.metadata().at("takt.fingerprint").at("mujoco"), "4.0.1");
  EXPECT_EQ(recording.attachment("touch.json"), "{\"seed\": 7}");
  EXPECT_FALSE(recording.attachment("other.json"));

  const Table joints = recording.table("/left/joints").value();
  EXPECT_THAT(joints.columns, ElementsAre("a1.position", "a2.position", "a3.position", "a1.velocity", "a2.velocity",
                                          "a3.velocity", "a1.effort", "a2.effort", "a3.effort"));
  ASSERT_EQ(joints.time.size(), 300u);
  EXPECT_EQ(joints.time[123], 123 * kMillisecond);
  EXPECT_EQ(joints.values[1][123], SampleRun::position(123, 1));
  EXPECT_EQ(joints.values[5][123], 0.3 * 123);
  EXPECT_TRUE(std::isnan(joints.values[7][123])) << "no effort was given: null";

  const Table frames = recording.table("/frames").value();
  EXPECT_EQ(frames.columns[7], "tool.x");
  EXPECT_EQ(frames.values[9][10], 30.0);
  EXPECT_EQ(frames.columns[3], "base.qw");
  EXPECT_EQ(frames.values[3][10], 1.0);
  EXPECT_EQ(frames.values[4][10], 0.0);

  const Table wrench = recording.table("/left/wrench").value();
  EXPECT_EQ(wrench.values[1][20], -20.0);
  EXPECT_EQ(wrench.values[5][20], 0.3);
  EXPECT_EQ(wrench.units[5], "Nm");

  const Table samples = recording.table("/net/probe").value();
  EXPECT_THAT(samples.columns, ElementsAre("speed", "force.z", "contact"));
  EXPECT_THAT(samples.units, ElementsAre("m/s", "N", ""));
  EXPECT_EQ(samples.values[1][7], 7.0);
  EXPECT_TRUE(std::isnan(samples.values[1][8]));

  const Table state = recording.table("/sim/state").value();
  EXPECT_THAT(state.columns, ElementsAre("q0", "q1", "v0"));
  EXPECT_EQ(state.values[2][299], 301.0);

  const auto events = recording.events("/events").value();
  ASSERT_EQ(events.size(), 8u);
  EXPECT_EQ(events[2].cycle, 80u);
  EXPECT_EQ(events[2].source, "net");
  EXPECT_EQ(events[2].name, "started");
  EXPECT_EQ(events[2].text, "cycle 80");
  EXPECT_EQ(events[2].step, "a / b (2)");
  EXPECT_EQ(events[1].step, "");
  const auto log = recording.events("/log").value();
  EXPECT_EQ(log[1].name, "WARNING");
  EXPECT_EQ(log[1].source, "left");
  EXPECT_EQ(log[1].text, "line 70");

  const auto digests = recording.digests();
  ASSERT_EQ(digests.size(), 300u);
  EXPECT_EQ(digests[5].digest, 0x9E3779B97F4A7C15ull * 6);
  EXPECT_EQ(digests[5].cycle, 5u);
}

TEST(Recorder, TimeStampsOfEverySizeComeBack) {
  TestFolder folder("stamps");
  // Seconds and nanoseconds are varints: each of these has another size on the wire.
  const std::vector<Nanoseconds> times{0,
                                       1,
                                       127,
                                       128,
                                       70'000,
                                       3 * kMillisecond,
                                       500 * kMillisecond,
                                       kSecond,
                                       200 * kSecond + 1,
                                       70'000 * kSecond + 999'999'999};
  {
    auto recorder = Recorder::open(folder / "a.mcap").value();
    const ChannelId frames = recorder->add_transforms("/frames", {{"w", "b"}});
    for (std::size_t k = 0; k < times.size(); ++k) {
      recorder->begin_cycle(times[k], k);
      recorder->write(frames, std::vector<double>{1.0 * static_cast<double>(k), 2, 3, 4, 5, 6, 7});
    }
  }
  const Table table = Recording::open(folder / "a.mcap").value().table("/frames").value();
  EXPECT_EQ(table.time, times);
  for (std::size_t k = 0; k < times.size(); ++k) {
    for (std::size_t i = 1; i < 7; ++i) EXPECT_EQ(table.values[i][k], static_cast<double>(i + 1));
    EXPECT_EQ(table.values[0][k], static_cast<double>(k));
  }
}

TEST(Recorder, PosesGoInAsIsometries) {
  TestFolder folder("poses");
  {
    auto recorder = Recorder::open(folder / "a.mcap").value();
    const ChannelId frames = recorder->add_transforms("/frames", {{"w", "b"}});
    recorder->begin_cycle(0, 0);
    Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
    X_WB.translation() << 1, 2, 3;
    X_WB.linear() = Eigen::AngleAxisd(3.5, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    recorder->write_transforms(frames, std::array{X_WB});
  }
  const Table table = Recording::open(folder / "a.mcap").value().table("/frames").value();
  EXPECT_EQ(table.values[1][0], 2.0);
  EXPECT_NEAR(table.values[3][0], -std::cos(1.75), 1e-12) << "w is not negative";
  EXPECT_NEAR(table.values[6][0], -std::sin(1.75), 1e-12);
}

TEST(Recorder, QuaternionsGoOnWithoutAJump) {
  TestFolder folder("turns");
  {
    auto recorder = Recorder::open(folder / "a.mcap").value();
    const ChannelId frames = recorder->add_transforms("/frames", {{"w", "b"}});
    for (int k = 0; k < 1000; ++k) {  // three turns
      recorder->begin_cycle(k * kMillisecond, static_cast<std::uint64_t>(k));
      Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
      X_WB.linear() = Eigen::AngleAxisd(0.02 * k, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
      recorder->write_transforms(frames, std::array{X_WB});
    }
  }
  const Table table = Recording::open(folder / "a.mcap").value().table("/frames").value();
  for (std::size_t i = 3; i < 7; ++i)
    for (std::size_t k = 1; k < 1000; ++k)
      ASSERT_LT(std::abs(table.values[i][k] - table.values[i][k - 1]), 0.0101) << table.columns[i] << " in row " << k;
}

TEST(Recorder, TheSameRunGivesTheSameBytes) {
  TestFolder folder("bytes");
  RecorderOptions options;
  options.chunk_time = 20 * kMillisecond;
  record_run(folder / "quiet.mcap", 200, options);
  // A slow run: what gathers is flushed again and again before its chunk is complete, and leaves no trace.
  options.flush_wall_time = kMillisecond / 2;
  {
    auto recorder = Recorder::open(folder / "slow.mcap", options).value();
    SampleRun run(*recorder);
    for (std::uint64_t k = 0; k < 200; ++k) {
      run.cycle(k);
      if (k % 7 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(3));
    }
  }
  EXPECT_EQ(bytes_of(folder / "quiet.mcap"), bytes_of(folder / "slow.mcap"));
  EXPECT_EQ(Recording::open(folder / "quiet.mcap").value().table("/sim/state")->time.size(), 200u);
}

TEST(Recorder, BlockingLosesNothingThroughATinyRing) {
  TestFolder folder("block");
  RecorderOptions options;
  options.ring_bytes = 4096;
  const RecorderStatus status = record_run(folder / "a.mcap", 2000, options);
  EXPECT_EQ(status.dropped_cycles, 0u);
  EXPECT_EQ(Recording::open(folder / "a.mcap").value().table("/left/joints")->time.size(), 2000u);
}

TEST(Recorder, DroppingLeavesOutWholeCyclesAndCountsThem) {
  TestFolder folder("drop");
  RecorderOptions options;
  options.policy = FullPolicy::kDrop;
  options.ring_bytes = 4096;
  const RecorderStatus status = record_run(folder / "a.mcap", 5000, options);
  EXPECT_GT(status.dropped_cycles, 0u) << "the writer cannot follow a loop without work";
  const Recording recording = Recording::open(folder / "a.mcap").value();
  const std::size_t kept = recording.digests().size();
  EXPECT_EQ(kept + status.dropped_cycles, 5000u);
  for (const std::string& topic : recording.table_topics()) EXPECT_EQ(recording.table(topic)->time.size(), kept);
}

TEST(Recorder, TheCycleAllocatesNothing) {
  TestFolder folder("heap");
  auto recorder = Recorder::open(folder / "a.mcap").value();
  const ChannelId joints = recorder->add_joint_states("/joints", {"a1", "a2"});
  const ChannelId frames = recorder->add_transforms("/frames", {{"w", "b"}});
  const ChannelId samples = recorder->add_samples("/samples", {"x", "y"});
  const ChannelId digest = recorder->add_digest("/digest");
  const ChannelId events = recorder->add_events("/events");
  const ChannelId log = recorder->add_log("/log");
  const std::array<double, 2> q{1, 2};
  const std::array<Eigen::Isometry3d, 1> poses{Eigen::Isometry3d::Identity()};
  const test::AllocationGuard guard;
  for (std::uint64_t k = 0; k < 100; ++k) {
    recorder->begin_cycle(static_cast<Nanoseconds>(k) * kMillisecond, k);
    recorder->write_joints(joints, q, q, {});
    recorder->write_transforms(frames, poses);
    recorder->write(samples, q);
    recorder->digest(digest, k);
    recorder->event(events, "a source with a long name", "and a name that fits in no small string", "text");
    recorder->log(log, LogLevel::kInfo, "source", "a line that is longer than a small string can be");
  }
  EXPECT_EQ(guard.count(), 0u);
}

TEST(Recorder, RefusesWrongCallsAndSaysSo) {
  TestFolder folder("wrong");
  std::vector<std::string> said;
  RecorderOptions options;
  options.on_error = [&](const std::string& text) { said.push_back(text); };
  auto recorder = Recorder::open(folder / "a.mcap", options).value();
  const ChannelId wrench = recorder->add_wrench("/w", "tool");
  recorder->write(wrench, std::vector<double>(6));  // before the first cycle
  recorder->begin_cycle(0, 0);
  recorder->write(wrench, std::vector<double>(5));
  recorder->digest(wrench, 1);
  recorder->write_joints(wrench, std::vector<double>(7), {}, {});
  recorder->write(ChannelId{}, std::vector<double>(3));  // an empty id is no mistake
  EXPECT_EQ(recorder->status().refused_rows, 4u);
  EXPECT_TRUE(recorder->status().recording);
  EXPECT_EQ(recorder->add_samples("/late", {"x"}).value, 0u);
  EXPECT_THAT(recorder->status().error, HasSubstr("'/late': channels are added before the first cycle"));
  EXPECT_EQ(recorder->add_samples("/w", {"x"}).value, 0u);
  EXPECT_EQ(said.size(), 1u);
}

TEST(Recorder, AFolderThatIsNotThereIsAFinding) {
  const auto recorder = Recorder::open("/nowhere/at/all.mcap");
  ASSERT_FALSE(recorder);
  EXPECT_THAT(recorder, Reports(Code::kFileNotWritable, "", {"/nowhere/at/all.mcap"}));
}

TEST(Recorder, AFullDeviceIsAFinding) {
  const auto recorder = Recorder::open("/dev/full");
  ASSERT_FALSE(recorder);
  EXPECT_THAT(recorder, Reports(Code::kFileNotWritable, ""));
}

TEST(Recorder, ADiskThatFillsUpStopsTheRecordingNotTheRun) {
  TestFolder folder("full");
  const std::string path = folder / "a.mcap";
  // The limit is the process's own, so a child meets it.
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{64 << 10, 64 << 10};
    setrlimit(RLIMIT_FSIZE, &limit);
    int said = 0;
    RecorderOptions options;
    options.ring_bytes = 16 << 10;
    options.on_error = [&](const std::string&) { ++said; };
    const RecorderStatus status = record_run(path, 20'000, options);
    const bool right = said == 1 && !status.recording && status.error.find("File too large") != std::string::npos;
    _exit(right ? 0 : 1);
  }
  int result = 0;
  waitpid(child, &result, 0);
  EXPECT_EQ(result, 0) << "the run ended, with one message that says why the recording stopped";
  const Recording recording = Recording::open(path).value();
  EXPECT_TRUE(recording.truncated_at());
  EXPECT_EQ(recording.truncated_at(), std::filesystem::file_size(path)) << "nothing torn stays behind";
  EXPECT_GT(recording.digests().size(), 100u);
}

/// Records at 1 kHz of wall time until somebody kills it.
[[noreturn]] void record_until_killed(const std::string& path, int progress, Nanoseconds chunk_time) {
  RecorderOptions options;
  options.chunk_time = chunk_time;
  options.flush_wall_time = 20 * kMillisecond;
  auto recorder = Recorder::open(path, options).value();
  SampleRun run(*recorder);
  auto next = std::chrono::steady_clock::now();
  for (std::uint64_t k = 0;; ++k) {
    run.cycle(k);
    if (write(progress, &k, sizeof(k)) < 0) _exit(1);
    next += std::chrono::milliseconds(1);
    std::this_thread::sleep_until(next);
  }
}

TEST(Recorder, KilledItLeavesAReadableFile) {
  TestFolder folder("kill");
  // The second sort of run never completes a chunk: all that can be had was flushed.
  for (const Nanoseconds chunk_time : {30 * kMillisecond, 10 * kSecond}) {
    for (int round = 0; round < 3; ++round) {
      const std::string path = folder / "a.mcap";
      int ends[2];
      ASSERT_EQ(pipe(ends), 0);
      const pid_t child = fork();
      if (child == 0) record_until_killed(path, ends[1], chunk_time);
      close(ends[1]);
      std::uint64_t last = 0;
      const auto kill_at = static_cast<std::uint64_t>(211 + 67 * round);
      while (last < kill_at && read(ends[0], &last, sizeof(last)) == sizeof(last)) {
      }
      kill(child, SIGKILL);
      waitpid(child, nullptr, 0);
      while (read(ends[0], &last, sizeof(last)) == sizeof(last)) {
      }
      close(ends[0]);

      const Recording recording = Recording::open(path).value();
      ASSERT_TRUE(recording.truncated_at());
      EXPECT_THAT(recording.damage(), ElementsAre(HasSubstr("truncated at byte")));
      const auto digests = recording.digests();
      ASSERT_FALSE(digests.empty());
      for (std::size_t k = 0; k < digests.size(); ++k) ASSERT_EQ(digests[k].cycle, k) << "no gap";
      EXPECT_GE(digests.back().time + kSecond, static_cast<Nanoseconds>(last) * kMillisecond);
      EXPECT_EQ(recording.table("/left/joints")->time.size(), digests.size());
    }
  }
}

}  // namespace
}  // namespace takt::record
