// 4. Motions that go over into each other (2013 paper, listing 2): the first one is begun and may be left at 70 % of
// its time, so the second one takes it over in motion; what is executed comes to its natural end.
#include <takt/takt.h>

using namespace takt::app;

int main(int argc, char** argv) {
  return run(argc, argv, "arm.json", [](Cell& cell) {
    const Actuator robot = cell.arm();
    const auto motion = robot.use<MotionInterface>();
    const Eigen::Isometry3d X_BT = robot.tool();
    const auto goal = Eigen::Translation3d(0.0, 0.15, 0.0) * X_BT, goal2 = Eigen::Translation3d(-0.1, 0.15, 0.0) * X_BT,
               goal3 = Eigen::Translation3d(-0.1, 0.15, 0.1) * X_BT;

    const RunPtr first = motion.lin(goal, {.blend = 0.7}).begin_execute();
    const RunPtr second = motion.lin(goal2).execute();
    const RunPtr third = motion.lin(goal3).execute();

    cell.print(fmt::format("The second motion took over in cycle {}, the third began at rest in cycle {}.",
                           second->first_cycle(), third->first_cycle()));
    cell.expect("the second is blended", second->blended(), "in motion");
    cell.expect("without an empty cycle", second->first_cycle() == first->last_cycle() + 1,
                fmt::format("{} after {}", second->first_cycle(), first->last_cycle()));
    cell.expect("the third is not", !third->blended(), "at rest");
    const double off = (robot.tool().translation() - goal3.translation()).norm();
    cell.expect("at the last goal", off < 1e-6, fmt::format("{:.1e} m off", off));
  });
}
