// What a recording costs: the cycle's side in nanoseconds, the writer's side in MB/s and times real time, a comparison
// in time and memory.
// bench_record [SECONDS OF RECORDED TIME]
#include "record/recorder.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "record/compare.h"
#include "record/recording.h"
#include "tests/support/scratch_folder.h"

using namespace takt;
using namespace takt::record;
using Clock = std::chrono::steady_clock;

namespace {

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// The channels of one arm: 10 messages a cycle, 150 numbers.
struct Arm {
  explicit Arm(Recorder& r)
      : measured(r.add_joint_states("/arm/measured", joints())),
        commanded(
            r.add_joint_states("/arm/commanded", joints(), {.position = true, .velocity = true, .effort = false})),
        frames(r.add_transforms("/frames", {{"w", "b"}, {"b", "f"}, {"f", "t"}, {"w", "o"}})),
        wrench(r.add_wrench("/arm/wrench", "tool")),
        compensated(r.add_wrench("/arm/wrench_compensated", "tool")),
        net(r.add_samples("/net/move", std::vector<std::string>(20, "port"))),
        guard(r.add_samples("/arm/guard", {"speed", "distance", "margin", "scale"})),
        clock(r.add_samples("/arm/clock", {"rate", "target", "time"})),
        state(r.add_state("/sim/state", std::vector<std::string>(30, "q"))),
        digest(r.add_digest("/digest")) {}

  static std::vector<std::string> joints() { return {"a1", "a2", "a3", "a4", "a5", "a6", "a7"}; }

  ChannelId measured, commanded, frames, wrench, compensated, net, guard, clock, state, digest;
};

}  // namespace

int main(int count, char** words) {
  const int cycles = 1000 * (count > 1 ? std::atoi(words[1]) : 30);
  const takt::test::ScratchFolder folder;
  const auto path = folder / "bench.mcap";
  std::vector<double> values(64);
  std::vector<float> costs(static_cast<std::size_t>(cycles));

  const auto start = Clock::now();
  auto recorder = Recorder::open(path).value();
  const Arm arm(*recorder);
  const std::span<const double> all(values);
  for (int k = 0; k < cycles; ++k) {
    // Smooth signals with noise in the last bits, as a run has them.
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::sin(1e-3 * k + static_cast<double>(i));
    const auto before = Clock::now();
    recorder->begin_cycle(k * kMillisecond, static_cast<std::uint64_t>(k));
    recorder->write_joints(arm.measured, all.first(7), all.subspan(7, 7), all.subspan(14, 7));
    recorder->write_joints(arm.commanded, all.subspan(21, 7), all.subspan(28, 7), {});
    recorder->write(arm.frames, all.first(28));
    recorder->write(arm.wrench, all.first(6));
    recorder->write(arm.compensated, all.subspan(6, 6));
    recorder->write(arm.net, all.first(20));
    recorder->write(arm.guard, all.first(4));
    recorder->write(arm.clock, all.first(3));
    recorder->write(arm.state, all.first(30));
    recorder->digest(arm.digest, static_cast<std::uint64_t>(k) * 0x9E3779B97F4A7C15ull);
    costs[static_cast<std::size_t>(k)] = static_cast<float>(1e9 * seconds_since(before));
  }
  const RecorderStatus status = recorder->close();
  const double wall = seconds_since(start);

  std::ranges::sort(costs);
  const auto at = [&](double share) { return costs[static_cast<std::size_t>(share * (cycles - 1))]; };
  fmt::print("cycle's side, 10 channels: p50 {:.0f} ns, p90 {:.0f} ns, p99 {:.0f} ns, p99.9 {:.0f} ns\n", at(0.5),
             at(0.9), at(0.99), at(0.999));
  std::uint64_t raw = 0;
  Recording::open(path)->for_each([&](const MessageView& message) {
    raw += message.data.size() + 31;
    return true;
  });
  fmt::print(
      "writer's side: {:.1f} s recorded in {:.2f} s ({:.0f} times real time), {:.0f} MB/s raw, file {:.1f} MB of "
      "{:.1f} "
      "MB raw, {} messages{}\n",
      1e-3 * cycles, wall, 1e-3 * cycles / wall, 1e-6 * static_cast<double>(raw) / wall,
      1e-6 * static_cast<double>(status.bytes), 1e-6 * static_cast<double>(raw), status.messages,
      status.error.empty() ? "" : ", error: " + status.error);

  const auto begin = Clock::now();
  const auto comparison = compare_recordings(path, path);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  fmt::print("compared with itself: {:.2f} s, {} columns, {}; largest resident memory of all this {} MiB\n",
             seconds_since(begin), comparison->columns.size(), comparison->passed ? "equal" : "different",
             usage.ru_maxrss >> 10);
  return 0;
}
