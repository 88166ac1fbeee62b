// 3. A screw is inserted until it is felt, then pressed with a force while the driver turns (2013 paper, figure 3): one
// activity out of three, one net, so what follows an event follows within cycles and not when the program gets to it.
#include <takt/takt.h>

using namespace takt::app;

int main(int argc, char** argv) {
  return run(argc, argv, "screw.json", [](Cell& cell) {
    const Actuator robot = cell.arm();
    const auto motion = robot.use<MotionInterface>();
    const auto driver = cell.output("io/driver").use<OutputInterface>();
    const Eigen::Vector3d down(0.0, 0.0, -1.0);

    cell.step("over the hole");
    motion.ptp(robot.above("hole", 0.005), {.velocity = 0.5}).execute();
    cell.tare("wrist");

    const State felt = is_greater(cell.force("wrist"), 5.0);    // N
    const State tight = cell.input("io/clutch").held_for(2.0);  // s
    const Activity insert = motion.lin_by({0.0, 0.0, -0.1}, {.linear_velocity = 0.005, .until = felt});
    const Activity hold =
        robot.use<ForceInterface>().press({.direction = down, .in = robot.name(), .force = 10.0, .until = tight});

    cell.step("insert, then press and turn");
    sequence({insert, parallel({hold, driver.set(true)})}).execute();
    const double pressed = cell.pressing(down).now().value_or(0.0);

    cell.step("away");
    driver.set(false).execute();
    motion.lin_by({0.0, 0.0, 0.1}, {.velocity = 0.3}).execute();
    cell.expect("pressed with 10 N in the end", std::abs(pressed - 10.0) < 1.0, fmt::format("{:.2f} N", pressed));
  });
}
