// 8. The screw again, a layer below: a transaction of commands with event handlers, as figure 3 of the 2013 paper draws
// it. Who starts and cancels whom is written out; the cell carries it out as one activity.
#include <takt/takt.h>

using namespace takt::app;

int main(int argc, char** argv) {
  return run(argc, argv, "screw.json", [](Cell& cell) {
    const Actuator robot = cell.arm();
    const auto motion = robot.use<MotionInterface>();
    motion.ptp(robot.above("hole", 0.005), {.velocity = 0.5}).execute();
    cell.tare();

    const Eigen::Vector3d down(0.0, 0.0, -1.0);
    const Eigen::Isometry3d X_BT_hole = robot.above("hole", -0.08);
    const command::Actuator arm = command::arm(cell.model(), "arm"),
                            driver = command::output(cell.model(), "io/driver");
    RuntimeCommand insert_screw("insertScrew", arm, command::lin(X_BT_hole, {.linear_velocity = 0.005}));
    RuntimeCommand maintain_force(
        "maintainForce", arm,
        command::hold_force(cell.pressing(down), Eigen::Isometry3d::Identity(), down, {.force = 10.0, .gain = 2e-4}));
    RuntimeCommand tighten_screw("tightenScrew", driver, command::set_value(true));
    insert_screw.on_entered(is_greater(cell.force(), 5.0), cancel(insert_screw));
    maintain_force.on_entered(cell.input("io/clutch").held_for(2.0), cancel(maintain_force));
    TransactionCommand screwing("screwing");
    screwing.add_started(insert_screw).add(maintain_force).add(tighten_screw);
    screwing.on_entered(insert_screw.completed(), start(maintain_force));
    screwing.on_entered(insert_screw.completed(), start(tighten_screw));

    const RunPtr run = cell.as_activity(screwing).execute();
    for (const Reaction& reaction : run->reactions())
      cell.print(fmt::format("{}: 5 N in cycle {}, the arm brakes in cycle {} (certified: {} to {} cycles later)",
                             reaction.event, reaction.event_cycle, reaction.braking_cycle, reaction.least,
                             reaction.most));
    cell.output("io/driver").use<OutputInterface>().set(false).execute();
    motion.lin_by({0.0, 0.0, 0.1}, {.velocity = 0.3}).execute();
  });
}
