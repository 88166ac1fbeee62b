// 1. A cell is opened, an arm is taken by its name, and moves: to a side on a line, back, home.
#include <takt/takt.h>

using namespace takt::app;

int main(int argc, char** argv) {
  return run(argc, argv, "arm.json", [](Cell& cell) {
    const Actuator robot = cell.arm("arm");
    const auto motion = robot.use<MotionInterface>();
    const Eigen::Isometry3d X_BT_before = robot.tool();

    motion.lin_by({0.0, 0.2, 0.0}, {.linear_velocity = 0.25}).execute();  // m, m/s, in the axes of the arm's base
    const double way = (robot.tool().translation() - X_BT_before.translation()).norm();
    motion.lin(X_BT_before).execute();
    motion.ptp(robot.home(), {.velocity = 0.5}).execute();

    cell.print(fmt::format("It went {:.1f} mm to the side and is home after {:.3f} s.", 1e3 * way, cell.time()));
    cell.expect("the way to the side", std::abs(way - 0.2) < 1e-6, fmt::format("{:.6f} m (0.2)", way));
  });
}
