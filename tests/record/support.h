#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "record/recorder.h"
#include "tests/support/scratch_folder.h"

namespace takt::record {

using TestFolder = takt::test::ScratchFolder;

inline std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A small run with one channel of each kind; every number is a function of cycle, so tests can tell what belongs
/// where.
class SampleRun {
 public:
  explicit SampleRun(Recorder& recorder) : recorder_(recorder) {
    joints_ = recorder.add_joint_states("/left/joints", {"a1", "a2", "a3"});
    frames_ = recorder.add_transforms("/frames", {{"world", "base"}, {"base", "tool"}});
    wrench_ = recorder.add_wrench("/left/wrench", "tool");
    samples_ = recorder.add_samples("/net/probe", {"speed", "force.z", "contact"}, {"m/s", "N"});
    state_ = recorder.add_state("/sim/state", {"q0", "q1", "v0"});
    digest_ = recorder.add_digest("/digest");
    events_ = recorder.add_events("/events");
    log_ = recorder.add_log("/log");
  }

  static double position(std::uint64_t cycle, int joint) {
    return std::sin(0.003 * static_cast<double>(cycle) + joint);
  }

  void cycle(std::uint64_t k, double disturbance = 0.0) {
    recorder_.begin_cycle(static_cast<Nanoseconds>(k) * kMillisecond, k);
    const double x = static_cast<double>(k);
    const std::vector<double> q{position(k, 0) + disturbance, position(k, 1), position(k, 2)};
    const std::vector<double> dq{0.1 * x, 0.2 * x, 0.3 * x};
    recorder_.write_joints(joints_, q, dq, {});
    recorder_.write(frames_, std::vector<double>{0, 0, 0.5, 1, 0, 0, 0, x, 2 * x, 3 * x, 0.5, 0.5, 0.5, 0.5});
    recorder_.write(wrench_, std::vector<double>{x, -x, 5, 0.1, 0.2, 0.3});
    recorder_.write(samples_, std::vector<double>{0.25 * x, k % 2 == 0 ? NAN : x, k > 50 ? 1.0 : 0.0});
    recorder_.write(state_, std::vector<double>{x, x + 1, x + 2});
    recorder_.digest(digest_, 0x9E3779B97F4A7C15ull * (k + 1) + (disturbance != 0.0 ? 1 : 0));
    const char* step = k % 80 == 0 ? "a / b (2)" : "";
    if (k % 40 == 0) recorder_.event(events_, "net", "started", "cycle " + std::to_string(k), step);
    if (k % 70 == 0) recorder_.log(log_, LogLevel::kWarning, "left", "line " + std::to_string(k));
  }

 private:
  Recorder& recorder_;
  ChannelId joints_, frames_, wrench_, samples_, state_, digest_, events_, log_;
};

/// Records `cycles` cycles into `path`; what `options` hold decides the rest.
inline RecorderStatus record_run(const std::filesystem::path& path, std::uint64_t cycles,
                                 RecorderOptions options = {}) {
  auto recorder = Recorder::open(path, std::move(options)).value();
  SampleRun run(*recorder);
  for (std::uint64_t k = 0; k < cycles; ++k) run.cycle(k);
  return recorder->close();
}

}  // namespace takt::record
