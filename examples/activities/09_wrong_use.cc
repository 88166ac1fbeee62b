// 9. What is wrong is said before anything moves, with what would be right: each of these throws an ActivityError.
#include <takt/takt.h>

using namespace takt::app;

int main(int argc, char** argv) {
  return run(argc, argv, "gripper.json", [](Cell& cell) {
    const Actuator robot = cell.arm();
    const auto motion = robot.use<MotionInterface>();
    const auto q_before = robot.q();
    const auto refused = [&cell](const char* what, const auto& attempt) {
      try {
        attempt();
        cell.expect(what, false, "it was taken");
      } catch (const ActivityError& error) {
        for (const takt::Diagnostic& diagnostic : error.diagnostics().list())
          cell.print(fmt::format("{}: {}", what, to_string(diagnostic)));
        cell.expect(what, true, "refused");
      }
    };
    refused("a name", [&] { (void)cell.arm("amr"); });
    refused("an interface", [&] { (void)cell.gripper().use<LinInterface>(); });
    refused("a goal", [&] { motion.lin_by({0.0, 2.0, 0.0}).execute(); });
    refused("a blend", [&] {
      motion.lin_by({0.0, 0.1, 0.0}, {.blend = 0.7, .until = cell.gripper_is("holding")}).execute();
    });
    refused("a rule", [&] {  // nothing starts it, and `start` hangs on no transaction (rules C1, C9)
      WaitCommand one("one", 0.1), other("other", 0.1);
      one.on_entered(one.completed(), start(other));
      TransactionCommand both("both");
      both.add(one).add(other);
      cell.as_activity(both).execute();
    });
    cell.expect("nothing has moved", robot.q() == q_before, "the set point is what it was");
  });
}
