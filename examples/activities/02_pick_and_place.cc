// 2. Pick and place: the cell and what must come of it are those of scenarios/pick.json, the program is this one.
#include <takt/takt.h>

using namespace takt::app;

int main(int argc, char** argv) {
  return run(argc, argv, "pick.json", [](Cell& cell) {
    const Actuator robot = cell.arm(), lamp = cell.output("io/lamp");
    const auto motion = robot.use<MotionInterface>();
    const auto hand = cell.gripper().use<GrippingInterface>();
    motion.ptp(robot.above("part", 0.1), {.velocity = 0.5}).execute();
    motion.lin(robot.above("part", 0.01), {.velocity = 0.4}).execute();
    hand.close({.speed = 0.1, .force = 60.0}).execute();
    robot.carry(1.0);
    lamp.use<OutputInterface>().set(true).execute();
    motion.lin_by({0.0, 0.0, 0.15}, {.velocity = 0.4}).execute();
    motion.lin(robot.above("box", 0.16), {.velocity = 0.4}).execute();
    motion.lin(robot.above("box", 0.071), {.linear_velocity = 0.05}).execute();
    hand.open({.width = 0.08, .speed = 0.1}).execute();
    robot.put_down();
    lamp.use<OutputInterface>().set(false).execute();
    motion.lin_by({0.0, 0.0, 0.12}, {.velocity = 0.4}).execute();
    motion.ptp(robot.home(), {.velocity = 0.5}).execute();
  });
}
