// 7. Two arms: coroutines beside each other until both are where they meet, then both as one actuator that moves the
// frame between them on one path with one clock.
#include <takt/takt.h>

using namespace takt::app;

namespace {

/// Up, and down again when the other one is up too.
Task greet(Cell& cell, Actuator robot, int& up) {
  const auto motion = robot.use<MotionInterface>();
  const Activity rise = motion.lin_by({0.0, 0.0, 0.1}), sink = motion.lin_by({0.0, 0.0, -0.1});
  co_await rise;
  ++up;
  const auto both_are_up = [&up] { return up == 2; };
  co_await cell.runtime().when(both_are_up);
  co_await sink;
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "two_arms.json", [](Cell& cell) {
    const Actuator left = cell.arm("left"), right = cell.arm("right");
    int up = 0;
    cell.step("one beside the other");
    cell.runtime().spawn(greet(cell, left, up));
    cell.run(greet(cell, right, up));
    cell.wait_for_all();

    cell.step("both as one");
    Eigen::Isometry3d X_WC = left.frame("world").inverse() * left.flange();
    X_WC.translation().x() = 0.7;  // in the middle
    const TwoArms both(left, right, X_WC);
    const RunPtr first = both.lin_by({0.0, 0.0, 0.1}, {.blend = 0.6}).begin_execute();
    const RunPtr second = both.lin_by({0.0, 0.1, 0.0}).execute();

    const double apart = (both.centre().translation() - both.centre_by_follower().translation()).norm();
    const double off = (both.centre().translation() - X_WC.translation() - Eigen::Vector3d(0.0, 0.1, 0.1)).norm();
    cell.expect("one motion after the other, blended", second->blended(),
                fmt::format("cycle {}", second->first_cycle()));
    cell.expect("both see the centre at one place", apart < 1e-8, fmt::format("{:.1e} m apart", apart));
    cell.expect("the centre is at its goal", off < 1e-6, fmt::format("{:.1e} m off", off));
  });
}
