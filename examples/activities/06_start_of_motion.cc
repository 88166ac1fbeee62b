// 6. How long it takes to start an activity: the four cases that the 2013 paper measured (section 7.3, figure 11: 50 to
// 200 ms). Here from the call to a net that is ready to start, CPU time of the program; planning is a part of it.
#include <takt/takt.h>

using namespace takt::app;

namespace {

/// Carries the activity out and keeps what it took.
void measure(const Activity& activity, std::vector<takt::activity::Preparation>& times) {
  times.push_back(activity.execute()->preparation());
}

void print(Cell& cell, const char* name, std::vector<takt::activity::Preparation> times) {
  std::ranges::sort(times, {}, &takt::activity::Preparation::total);
  const auto& middle = times[times.size() / 2];
  cell.print(fmt::format("{:<18} {:>2} runs  median {:6.2f} ms  longest {:6.2f} ms  planning {:3.0f} %", name,
                         times.size(), 1e3 * middle.total, 1e3 * times.back().total,
                         100.0 * middle.planning / middle.total));
  cell.expect(fmt::format("{} starts sooner than the paper's 50 ms", name), middle.total < 0.05,
              fmt::format("{:.2f} ms", 1e3 * middle.total));
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "two_arms.json", [](Cell& cell) {
    constexpr int kRuns = 5;
    const Actuator left = cell.arm("left"), right = cell.arm("right");
    const auto motion = left.use<MotionInterface>();
    // As in the paper: by the measured joints the tool is too near to where an obstacle is known to be.
    const Eigen::Vector3d p_BO = left.tool().translation() + Eigen::Vector3d(0.0, 0.25, 0.0);
    const State too_near = is_less(distance(position(tool_pose(cell.model(), "left")), p_BO), 0.2);
    double nearest = 1.0;
    std::vector<takt::activity::Preparation> ptp, lin, guarded, together;
    for (int i = 0; i < kRuns; ++i) {
      auto q_goal = left.home();
      q_goal[0] += 0.05 * (i + 1);
      measure(motion.ptp(q_goal), ptp);
      motion.ptp(left.home()).execute();
      measure(motion.lin_by({0.0, 0.02 * (i + 1), 0.0}), lin);
      motion.ptp(left.home()).execute();
      q_goal[0] = left.home()[0] + 0.3;
      measure(motion.ptp(q_goal, {.until = too_near, .must_touch = false}), guarded);
      nearest = std::min(nearest, (left.tool().translation() - p_BO).norm());
      motion.ptp(left.home()).execute();
    }
    const TwoArms pair(left, right, left.frame("world").inverse() * left.flange());
    for (int i = 0; i < kRuns; ++i) {
      measure(pair.lin_by({0.0, 0.0, 0.02}), together);
      measure(pair.lin_by({0.0, 0.0, -0.02}), together);
    }
    cell.expect("the guard stops before the obstacle", nearest > 0.05 && nearest < 0.2,
                fmt::format("{:.3f} m", nearest));
    print(cell, "PTP", ptp);
    print(cell, "LIN", lin);
    print(cell, "PTP with a guard", guarded);
    print(cell, "LIN of two arms", together);
  });
}
