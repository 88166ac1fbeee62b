// 10. A place is taught by hand: the arm goes after whoever leads it, in a control mode of its own, and is stiff again
// afterwards. Then it stands there as a spring, and gives way by as much as its stiffness says.
#include <takt/takt.h>

using namespace takt::app;

namespace {

/// How far somebody who leans on the arm from `begin` on pushes it away while it is a spring, m.
double given_way(Cell& cell, const Actuator& robot, double begin, double stiffness) {
  const auto tool = takt::expression::tool_pose(cell.model(), "arm");  // where it is, not where it is told to be
  const CartesianCompliance spring{.stiffness = Eigen::Vector3d(stiffness, stiffness, stiffness)};
  const RunPtr hold =
      robot.use<HoldInterface>().hold({.seconds = begin + 3.0 - cell.time(), .compliance = spring}).begin_execute();
  cell.wait(begin - cell.time());
  const Eigen::Vector3d before = tool.now()->translation();
  cell.wait(1.8);
  const double way = (tool.now()->translation() - before).norm();
  cell.wait_for_all();
  return way;
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "by_hand.json", [](Cell& cell) {
    const Actuator robot = cell.arm();
    const auto motion = robot.use<MotionInterface>();
    const auto modes = robot.use<ControlModeInterface>();
    const Eigen::Isometry3d start = robot.tool();

    cell.step("led by hand");
    robot.use<FreedriveInterface>().freedrive({.seconds = 5.0, .velocity = 0.1}).execute();
    const Eigen::Isometry3d taught = robot.tool();
    const double led = (taught.translation() - start.translation()).norm();
    cell.expect("the hand has led it", led > 0.05, fmt::format("{:.0f} mm", 1e3 * led));
    cell.expect("stiff again", modes.mode() == takt::device::ControlMode::kPosition, "mode position");

    cell.step("there again");
    motion.lin(start, {.linear_velocity = 0.2}).execute();
    motion.lin(taught, {.linear_velocity = 0.2}).execute();
    const double off = (robot.tool().translation() - taught.translation()).norm();
    cell.expect("at the place that was taught", off < 1e-6, fmt::format("{:.1e} m off", off));

    cell.step("as a spring");
    modes.switch_to("cartesian_impedance").execute();
    for (const auto& [begin, stiffness] : {std::pair(14.0, 2000.0), std::pair(18.0, 500.0)}) {
      const double way = given_way(cell, robot, begin, stiffness), wanted = 20.0 / stiffness;
      cell.expect(fmt::format("gives way as {:g} N/m do", stiffness), std::abs(way - wanted) < 0.2 * wanted,
                  fmt::format("{:.1f} mm under 20 N", 1e3 * way));
    }
    modes.switch_to("position").execute();
  });
}
