// Work from a program's call to START: planning, mapping to a net, LOAD. The four cases of the 2013 paper (section 7.3)
// on LWR 4+ arms, with the share of planning, and how many cycles later the first set point is sent. Prints percentiles
// in milliseconds of CPU time.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "app/interfaces/two_arms.h"
#include "core/base/random.h"
#include "core/device/device_file.h"
#include "core/expression/device_sensors.h"
#include "tests/support/fake_arm.h"

namespace takt {
namespace {

using activity::Activity;

/// Two LWR 4+ that look at each other, always where they were sent.
struct Cell {
  Cell() {
    auto model = device::read_arm("models/lwr4plus");
    if (!model) {
      std::fprintf(stderr, "run from the root of the repository\n%s", model.error().to_string().c_str());
      std::exit(2);
    }
    arm = *model;
    double x = 0.0;
    for (const char* name : {"left", "right"}) {
      auto backend = std::make_shared<test::FakeArm>(arm->home);
      backend->keep = false;
      auto& device = core.add(std::make_unique<device::Arm>(name, arm, backend, core.period()));
      Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
      X_WB.translation().x() = x;
      if (x > 0.0) X_WB.linear() = Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      x += 1.2;
      (void)cell.frames.add(name, "world", X_WB);
      cell.arms[name] = {.device = &device, .start = arm->home};
    }
    (void)activity::declare_channels(core, cell);
    core.step();
  }

  std::shared_ptr<const device::ArmDescription> arm;
  rcc::ControlCore core{{.digest = false}};
  expression::Cell cell;
  activity::Runtime runtime{core, cell, [this] { core.step(); }, {.scheduler = {.latency_cycles = 0}}};
};

struct Figures {
  std::vector<double> total_ms, planning_ms;
  std::int64_t most_cycles = 0;  ///< from the call to the first set point
  double first_ms = 0.0;
};

/// Runs the activity to its end and takes what it took until it could be started.
void measure(Cell& cell, const Activity& activity, Figures& figures) {
  const std::int64_t called = cell.core.cycle();
  activity::Scheduler scheduler(cell.core, cell.cell, {.latency_cycles = 0});
  const auto run = scheduler.schedule(activity.model());
  scheduler.poll();
  const double total = 1e3 * run->preparation().total;
  while (!run->over()) {
    cell.core.step();
    scheduler.poll();
  }
  activity::require(run);
  if (figures.first_ms == 0.0) {
    figures.first_ms = total;
    return;
  }
  figures.total_ms.push_back(total);
  figures.planning_ms.push_back(1e3 * run->preparation().planning);
  figures.most_cycles = std::max(figures.most_cycles, run->first_cycle() - called);
}

void print(const char* name, Figures figures) {
  std::ranges::sort(figures.total_ms);
  const auto at = [&](double share) {
    return figures.total_ms[static_cast<std::size_t>(share * static_cast<double>(figures.total_ms.size() - 1))];
  };
  double planning = 0.0, total = 0.0;
  for (std::size_t i = 0; i < figures.total_ms.size(); ++i) {
    total += figures.total_ms[i];
    planning += figures.planning_ms[i];
  }
  fmt::print(
      "{:<36} first {:6.3f}  p50 {:6.3f}  p99 {:6.3f}  max {:6.3f} ms, planning {:2.0f} %, first set point {} cycles "
      "after\n",
      name, figures.first_ms, at(0.5), at(0.99), at(1.0), 100.0 * planning / total, figures.most_cycles);
}

/// Joints near home.
kinematics::JointVector near_home(const Cell& cell, Random& random) {
  kinematics::JointVector q = cell.arm->home;
  for (double& one : q) one += random.uniform(-0.4, 0.4);
  return q;
}

}  // namespace
}  // namespace takt

int main(int argc, char** argv) {
  using namespace takt;
  const int runs = argc > 1 ? std::atoi(argv[1]) : 300;
  Random random(2013);
  {
    Cell cell;
    const app::Actuator robot(cell.runtime, "left");
    const auto motion = robot.use<app::MotionInterface>();
    Figures ptp, lin, guarded;
    const auto home = motion.ptp(cell.arm->home);
    for (int i = 0; i <= runs; ++i) {
      measure(cell, motion.ptp(near_home(cell, random)), ptp);
      home.execute();
      measure(cell, motion.lin_by({random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)}),
              lin);
      home.execute();
      // It is cancelled when the flange comes too near to an obstacle.
      const auto distance_to_obstacle = expression::distance(
          expression::position(expression::tool_pose(cell.cell, "left")), net::Vector(0.9, 0.2, 0.6));
      measure(cell,
              motion.ptp(near_home(cell, random), {.until = is_less(distance_to_obstacle, 0.2), .must_touch = false}),
              guarded);
      home.execute();
    }
    print("PTP", ptp);
    print("LIN", lin);
    print("PTP with a guard", guarded);
  }
  Cell cell;
  const app::Actuator left(cell.runtime, "left"), right(cell.runtime, "right");
  const Eigen::Isometry3d X_WC = left.frame("world").inverse() * left.flange();
  const app::TwoArms pair(left, right, X_WC);
  Figures together;
  for (int i = 0; i <= runs; ++i) {
    const Eigen::Vector3d way(random.uniform(-0.04, 0.04), random.uniform(-0.08, 0.08), random.uniform(-0.08, 0.08));
    measure(cell, pair.lin_by(way), together);
    pair.lin_by(-way).execute();
  }
  print("LIN of two arms", together);
  return 0;
}
