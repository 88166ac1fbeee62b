// Work from the call to START: planning, check and mapping, LOAD, for a PTP, a LIN and a PTP that stops before an
// obstacle comes nearer than a distance (the cases 1 to 3 of the Robotics API, 2013). Prints percentiles of CPU time in
// microseconds, and what the first call of all costs.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/command/actions/motion_action.h"
#include "core/command/mapping.h"
#include "core/device/device_file.h"
#include "core/expression/device_sensors.h"
#include "core/kinematics/chain.h"
#include "core/rcc/control_core.h"
#include "tests/support/fake_arm.h"

namespace takt::command {
namespace {

constexpr int kRuns = 1000;
enum Phase { kPlan, kMap, kLoad, kStart, kWhole };
using Times = std::array<double, 5>;  // us

/// CPU time of this thread: work, whatever else the machine does.
double now_us() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e6 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_nsec);
}

/// A core with an LWR that is always where it was sent.
struct Bench {
  Bench() : model(*device::read_arm("models/lwr4plus")), backend(std::make_shared<test::FakeArm>(model->home)) {
    backend->keep = false;
    expression::MountedArm mounted;
    mounted.device = &core.add(std::make_unique<device::Arm>("arm", model, backend, core.period()));
    mounted.X_FT.translation().z() = 0.15;
    cell.arms["arm"] = mounted;
    (void)cell.frames.add("arm", "world", Eigen::Isometry3d::Identity());
    core.step();
  }
  Eigen::Isometry3d moved(double x, double y, double z) const {
    Eigen::Isometry3d X_BT = model->chain->forward(model->home) * cell.arms.at("arm").X_FT;
    X_BT.translation() += Eigen::Vector3d(x, y, z);
    return X_BT;
  }
  device::JointVector joints() const {
    device::JointVector q = model->home;
    q[0] += 0.6;
    q[3] -= 0.4;
    return q;
  }

  std::shared_ptr<const device::ArmDescription> model;
  std::shared_ptr<test::FakeArm> backend;
  rcc::ControlCore core{{}};
  expression::Cell cell;
};

RuntimeCommand ptp_case(const Bench& bench) { return {"ptp", arm(bench.cell, "arm"), ptp(bench.joints())}; }
RuntimeCommand lin_case(const Bench& bench) { return {"lin", arm(bench.cell, "arm"), lin(bench.moved(0, 0.15, 0.05))}; }
RuntimeCommand guarded_case(const Bench& bench) {
  RuntimeCommand guarded = ptp_case(bench);
  const Eigen::Vector3d obstacle(0.2, 0.8, 0.3);  // in the arm's base, m
  guarded.on_entered(
      expression::is_less(
          expression::distance(expression::position(expression::tool_pose(bench.cell, "arm")), obstacle), 0.2),
      cancel(guarded));
  return guarded;
}

/// From the call to the request to start; then the net is forgotten.
Times once(Bench& bench, const std::function<RuntimeCommand(const Bench&)>& make) {
  Times times{};
  const double begin = now_us();
  const RuntimeCommand command = make(bench);
  const Diagnostics diagnostics = plan(command);
  const double planned = now_us();
  auto mapped = map(command, bench.core.period());
  const double written = now_us();
  const auto net =
      diagnostics.has_errors() || !mapped ? Result<rcc::NetId>(0) : bench.core.load(mapped->net, mapped->options);
  const double loaded = now_us();
  if (!net || *net == 0) {
    fmt::print("a case does not load: {}\n", mapped ? diagnostics.to_string() : mapped.error().to_string());
    std::exit(1);
  }
  bench.core.start(*net);
  const double end = now_us();
  times = {planned - begin, written - planned, loaded - written, end - loaded, end - begin};
  bench.core.step();
  bench.core.abort(*net);
  for (int i = 0; i < 3; ++i) bench.core.step();
  (void)bench.core.unload(*net);
  return times;
}

void print(const char* name, std::vector<Times> runs) {
  static constexpr std::array kNames = {"planning", "check and mapping", "LOAD", "START", "whole"};
  fmt::print("{}\n", name);
  for (std::size_t phase = 0; phase < kNames.size(); ++phase) {
    std::ranges::sort(runs, {}, [phase](const Times& times) { return times[phase]; });
    const auto at = [&](double share) {
      return runs[static_cast<std::size_t>(share * static_cast<double>(runs.size() - 1))][phase];
    };
    fmt::print("  {:18} p50 {:7.1f}  p99 {:7.1f}  max {:7.1f} us\n", kNames[phase], at(0.5), at(0.99), at(1.0));
  }
}

int run() {
  const std::array<std::pair<const char*, std::function<RuntimeCommand(const Bench&)>>, 3> cases = {
      {{"PTP", ptp_case}, {"LIN", lin_case}, {"guarded PTP", guarded_case}}};
  bool first = true;
  for (const auto& [name, make] : cases) {
    std::vector<Times> runs;
    for (int i = 0; i < kRuns; ++i) {
      static Bench bench;  // an aborted motion has hardly moved the arm
      const Times times = once(bench, make);
      if (std::exchange(first, false)) fmt::print("first call of all: {:.0f} us\n", times[kWhole]);
      runs.push_back(times);
    }
    print(name, std::move(runs));
  }
  return 0;
}

}  // namespace
}  // namespace takt::command

int main() { return takt::command::run(); }
