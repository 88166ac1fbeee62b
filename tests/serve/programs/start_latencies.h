#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include <takt/takt.h>

namespace takt::test {

/// From the call to the moment in which the program knows that the activity has started, ms: the four cases of the 2013
/// paper, in real time here or with --core through the network. Planning is a part of it.
inline int measure_start_latencies(int argc, char** argv) {
  using namespace takt::app;
  return run(argc, argv, "two_arms.json", [](Cell& cell) {
    constexpr int kRounds = 50;
    using Clock = std::chrono::steady_clock;
    std::map<std::string, std::vector<double>> times;
    const auto measure = [&](const std::string& name, const Activity& activity) {
      const auto begin = Clock::now();
      const RunPtr started = activity.begin_execute();
      times[name].push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
      wait(cell.runtime(), started);
    };
    const Actuator left = cell.arm("left"), right = cell.arm("right");
    const auto motion = left.use<MotionInterface>();
    const State near =
        is_less(distance(position(tool_pose(cell.model(), "left")), Eigen::Vector3d(0.0, 0.0, 9.0)), 0.2);
    auto q = left.home();
    for (int i = 0; i < kRounds; ++i) {
      const double way = i % 2 == 0 ? 0.03 : -0.03;
      q[0] += way;
      measure("PTP", motion.ptp(q));
      measure("LIN", motion.lin_by({0.0, way, 0.0}));
      q = left.q();
      q[0] -= way;
      measure("PTP with a guard", motion.ptp(q, {.until = near, .must_touch = false}));
      const TwoArms pair(left, right, left.frame("world").inverse() * left.flange());  // where they are now
      measure("LIN of two arms", pair.lin_by({0.0, 0.0, way}));
      q = left.q();
    }
    for (auto& [name, all] : times) {
      std::ranges::sort(all);
      cell.print(fmt::format("{:<18} {} starts  p50 {:6.2f} ms  p99 {:6.2f} ms  longest {:6.2f} ms", name, all.size(),
                             all[all.size() / 2], all[all.size() * 99 / 100], all.back()));
    }
  });
}

}  // namespace takt::test
