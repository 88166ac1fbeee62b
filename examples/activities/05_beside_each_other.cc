// 5. Activities of different actuators run beside each other (2013 paper, listing 3): the gripper closes while the arm
// moves; only what the same actuator does has an order.
#include <takt/takt.h>

using namespace takt::app;

int main(int argc, char** argv) {
  return run(argc, argv, "gripper.json", [](Cell& cell) {
    const Actuator robot = cell.arm(), gripper = cell.gripper();
    const auto motion = robot.use<MotionInterface>();
    const Eigen::Isometry3d X_BT = robot.tool();
    const Eigen::Isometry3d goal = Eigen::Translation3d(0.0, 0.2, 0.0) * X_BT;
    const Eigen::Isometry3d goal2 = Eigen::Translation3d(0.0, 0.2, 0.1) * X_BT;

    const RunPtr first = motion.lin(goal, {.velocity = 0.5, .blend = 0.7}).begin_execute();
    const RunPtr grip =
        gripper.use<GrippingInterface>().close({.expect = GripParameters::Expect::kNothing}).begin_execute();
    const RunPtr second = motion.lin(goal2, {.velocity = 0.5}).execute();
    wait(cell.runtime(), grip);

    cell.print(fmt::format("The arm moved in cycles {} to {}, the gripper in {} to {}.", first->first_cycle(),
                           second->last_cycle(), grip->first_cycle(), grip->last_cycle()));
    cell.expect("the gripper began during the first motion",
                first->first_cycle() < grip->first_cycle() && grip->first_cycle() < first->last_cycle(),
                fmt::format("cycle {}", grip->first_cycle()));
    cell.expect("the motions are blended", second->blended(), "in motion");
  });
}
