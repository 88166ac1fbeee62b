// Wrong uses of activities: names, interfaces, blends, compositions, two arms, coroutines, ends.
#include "tests/core/activity/broken_activities.h"

#include <limits>

#include "core/activity/command_activity.h"

namespace takt::test {
namespace {

using activity::Activity;
using activity::BlendingCondition;
using activity::Runtime;
using activity::Task;
using app::Actuator;
using app::GrippingInterface;
using app::LinInterface;
using app::OutputInterface;

Activity lamp_on(ActivityCell& cell) { return Actuator(cell.program, "lamp").use<OutputInterface>().set(true); }
Activity up(ActivityCell& cell, const operations::MotionParameters& wish = {}) {
  return cell.motion.lin_by({0.0, 0.0, 0.05}, wish);
}
operations::MotionParameters blended(const BlendingCondition& blend) { return {.blend = blend}; }
BlendingCondition over_share(double share) {
  return BlendingCondition(motion::Blend{motion::Blend::Kind::kFraction, share});
}
BlendingCondition by_both() {
  BlendingCondition blend = BlendingCondition::at_distance(0.01);
  blend.time_share = 0.7;
  return blend;
}

/// The same cell in the hands of another program.
struct OtherProgram {
  explicit OtherProgram(ActivityCell& cell) : runtime(cell.core, cell.cell, [&cell] { cell.step(); }) {}
  Runtime runtime;
  Activity lamp_on() { return Actuator(runtime, "lamp").use<OutputInterface>().set(true); }
};

Task one_that(const std::function<void()>& what) {
  what();
  co_return;
}
std::vector<BrokenActivity> names() {
  return {
      {"an actuator that is not there",
       [](auto& cell) { (void)Actuator(cell.program, "amr"); },
       "/amr",
       Code::kUnknownName,
       {"amr", "arm"}},
      {"an interface that it does not have",
       [](auto& cell) { (void)Actuator(cell.program, "gripper").template use<LinInterface>(); },
       "/gripper",
       Code::kUnsupported,
       {"gripper"}},
      {"what only arms have",
       [](auto& cell) { (void)Actuator(cell.program, "lamp").home(); },
       "/lamp",
       Code::kWrongType,
       {"lamp"}},
      {"a frame that is not there",
       [](auto& cell) { (void)cell.robot.above("blok", 0.1); },
       "/arm",
       Code::kUnknownName,
       {"blok", "block"}},
      {"a motion of no arm",
       [](auto& cell) {
         operations::MotionTask task;
         task.kind = operations::PathKind::kLin;
         task.arm = "amr";
         app::planned_motion(cell.program, task).execute();
       },
       "/amr LIN/arm",
       Code::kUnknownName,
       {"amr", "arm"}},
      {"a speed beyond the plan",
       [](auto& cell) { cell.robot.set_speed(1.5); },
       "/arm",
       Code::kOutOfRange,
       {"1.5", "0", "1"}},
      {"a speed that is not a number",
       [](auto& cell) { cell.robot.set_speed(std::numeric_limits<double>::quiet_NaN()); },
       "/arm",
       Code::kOutOfRange,
       {"0", "1"}},
      {"the speed of no arm",
       [](auto& cell) { cell.program.pause("amr"); },
       "/amr",
       Code::kUnknownName,
       {"amr", "arm"}},
      {"a speed without channels",
       [](auto& cell) {
         cell.cell.arms["second"] = cell.cell.arms.at("arm");
         cell.program.set_speed("second", 0.5);
       },
       "/second",
       Code::kRequires,
       {"second", "declare_channels"}},
      {"a load below nothing", [](auto& cell) { cell.robot.carry(-1.0); }, "/arm", Code::kOutOfRange, {"-1", "0"}},
      {"a load while it moves",
       [](auto& cell) {
         up(cell).begin_execute();
         cell.robot.carry(1.0);
       },
       "/arm",
       Code::kNotPossibleNow,
       {"arm"},
       true},
  };
}

std::vector<BrokenActivity> motions() {
  return {
      {"a goal out of reach", [](auto& cell) { cell.motion.lin(cell.moved(3, 0, 0)).execute(); }, "/arm LIN/to",
       Code::kUnreachable},
      {"a share above all",
       [](auto& cell) { up(cell, {.velocity = 1.5}).execute(); },
       "/arm LIN/speed",
       Code::kOutOfRange,
       {"1.5", "0", "1"}},
      {"a blend too early",
       [](auto& cell) { up(cell, blended(0.2)).execute(); },
       "/arm LIN/blend",
       Code::kOutOfRange,
       {"0.2", "0.5", "1"}},
      {"a blend behind the goal",
       [](auto& cell) { up(cell, blended(BlendingCondition::at_distance(-0.01))).execute(); },
       "/arm LIN/blend_m",
       Code::kOutOfRange,
       {"-0.01", "1e-05"}},
      {"a blend by both", [](auto& cell) { up(cell, blended(by_both())).execute(); }, "/arm LIN/blend",
       Code::kConflict},
      {"a blend over more than half of the path",
       [](auto& cell) { up(cell, blended(over_share(0.7))).execute(); },
       "/arm LIN/blend_fraction",
       Code::kOutOfRange,
       {"0.7", "0.0001", "0.5"}},
      {"a blend of a guarded motion", [](auto& cell) { up(cell, {.blend = 0.7, .until = cell.hard()}).execute(); },
       "/arm LIN/blend", Code::kConflict},
      {"a motion from nobody knows where",
       [](auto& cell) {
         activity::sequence({up(cell, {.until = cell.hard()}), up(cell)}).execute();
       },
       "/arm LIN, arm LIN/1",
       Code::kUnknownPosition,
       {"arm LIN"}},
      {"a condition of a sensor that is not there",
       [](auto& cell) {
         up(cell, {.until = is_greater(norm(force(expression::contact_wrench(cell.cell, "writs"))), 5.0)}).execute();
       },
       "/arm LIN/handlers/0",
       Code::kUnknownName,
       {"writs", "wrist"}},
      {"a width that the gripper does not have",
       [](auto& cell) {
         Actuator(cell.program, "gripper").template use<GrippingInterface>().close({.width = 0.3}).execute();
       },
       "/grip gripper/width_m",
       Code::kOutOfRange,
       {"gripper", "0.3", "0", "0.11"}},
      {"a hold for less than no time",
       [](auto& cell) { cell.robot.template use<app::HoldInterface>().hold(-1.0).execute(); },
       "/hold arm/seconds",
       Code::kOutOfRange,
       {"-1", "3600"}},
      {"a force that pulls",
       [](auto& cell) { cell.robot.template use<app::ForceInterface>().press({.force = -5.0}).execute(); },
       "/press arm/force_N",
       Code::kOutOfRange,
       {"-5", "0.1"}},
      {"a joint that the arm does not have",
       [](auto& cell) { cell.robot.template use<app::JointInterface>().move_to(9, 0.1).execute(); },
       "/arm",
       Code::kOutOfRange,
       {"arm", "9", "0", "6"}},
      {"a value of the wrong kind",
       [](auto& cell) { Actuator(cell.program, "lamp").template use<OutputInterface>().set(3.0).execute(); },
       "/set lamp",
       Code::kInvalidValue,
       {"lamp"}},
  };
}

std::vector<BrokenActivity> compositions() {
  const auto with = [](ActivityCell& cell, const activity::Subtask& subtask) {
    with_subtasks(up(cell), {subtask}).execute();
  };
  return {
      {"nothing in sequence", [](auto&) { (void)activity::sequence({}); }, "", Code::kMissing},
      {"one arm twice at the same time",
       [](auto& cell) {
         (void)activity::parallel({up(cell), lamp_on(cell), up(cell)});
       },
       "/2",
       Code::kResourceConflict,
       {"arm LIN", "arm"}},
      {"parts of two programs",
       [](auto& cell) {
         OtherProgram other(cell);
         (void)activity::sequence({up(cell), other.lamp_on()});
       },
       "/1",
       Code::kRequires,
       {"set lamp", "arm LIN"}},
      {"a choice between two programs",
       [](auto& cell) {
         OtherProgram other(cell);
         (void)conditional(cell.hard(), up(cell), other.lamp_on());
       },
       "/1", Code::kRequires},
      {"an end that there is no command for",
       [](auto& cell) {
         abort_if(cell.robot.template use<app::ControlModeInterface>().switch_to("position"), cell.hard()).execute();
       },
       "/arm position/abort_if",
       Code::kUnsupported,
       {"arm position"}},
      {"more ways to end than a sequence follows",
       [](auto& cell) {
         const auto either = [&] { return conditional(cell.hard(), up(cell), lamp_on(cell)); };
         activity::sequence({either(), either(), either(), either()}).execute();
       },
       "/4 parts, /3",
       Code::kTooLarge,
       {"16", "8"}},
      {"a subtask on the arm of the main task",
       [with](auto& cell) { with(cell, {.activity = up(cell), .at_share = 0.5}); },
       "/subtasks/0",
       Code::kResourceConflict,
       {"arm LIN", "arm"}},
      {"a subtask that never begins",
       [with](auto& cell) { with(cell, {.activity = lamp_on(cell)}); },
       "/arm LIN with subtasks/subtasks/0",
       Code::kMissing,
       {"at_share", "when"}},
      {"a subtask beyond the end",
       [with](auto& cell) { with(cell, {.activity = lamp_on(cell), .at_share = 1.5}); },
       "/arm LIN with subtasks/subtasks/0",
       Code::kOutOfRange,
       {"1.5", "0", "1"}},
      {"a share of what has no way",
       [](auto& cell) { with_subtasks(lamp_on(cell), {{.activity = up(cell), .at_share = 0.5}}).execute(); },
       "/set lamp with subtasks/subtasks/0",
       Code::kConflict,
       {"set lamp", "when"}},
  };
}

std::vector<BrokenActivity> programs() {
  return {
      {"a coroutine that blocks",
       [](auto& cell) { cell.program.run(one_that([&] { lamp_on(cell).execute(); })); },
       "",
       Code::kNotPossibleNow,
       {"co_await"}},
      {"a coroutine that runs another one to its end",
       [](auto& cell) { cell.program.run(one_that([&] { cell.program.run(one_that([] {})); })); },
       "",
       Code::kNotPossibleNow,
       {"co_await"}},
      {"a coroutine that runs the loop",
       [](auto& cell) { cell.program.run(one_that([&] { cell.program.step(); })); },
       "",
       Code::kNotPossibleNow,
       {"co_await"}},
      {"a program that never waits",
       [](auto& cell) {
         cell.program.run([](ActivityCell& own) -> Task {
           for (;;) co_await own.program.cycles(0);
         }(cell));
       },
       "",
       Code::kTooLarge,
       {"10000"}},
      {"a wait for what never comes",
       [](auto& cell) {
         Runtime hasty(cell.core, cell.cell, [&cell] { cell.step(); }, {.scheduler = {}, .most_cycles = 10});
         hasty.run_until([] { return false; });
       },
       "",
       Code::kTimeout,
       {"10", "most_cycles"}},
      {"a start after the end",
       [](auto& cell) {
         cell.program.cancel();
         up(cell).execute();
       },
       "",
       Code::kCancelled,
       {"Runtime"}},
      {"what waits behind a motion that is cancelled",
       [](auto& cell) {
         const auto first = up(cell).begin_execute();
         const auto second = up(cell).schedule();
         first->cancel();
         wait(cell.program, second);
       },
       "/arm LIN",
       Code::kStopped,
       {"arm LIN"},
       true},
      {"a motion whose rest another one carries out and fails with",
       [](auto& cell) {
         const auto first = up(cell, blended(0.7)).schedule();
         const auto second = up(cell).schedule();
         cell.program.run_until([&] { return second->blended(); });
         second->abort();
         wait(cell.program, first);
       },
       "/arm LIN",
       Code::kStopped,
       {"arm LIN"},
       true},
      {"a motion of an arm that fails on its way",
       [](auto& cell) {
         const auto run = up(cell).begin_execute();
         for (int i = 0; i < 50; ++i) cell.program.step();
         cell.backend->state().ready = false;
         wait(cell.program, run);
       },
       "/arm LIN",
       Code::kStopped,
       {"arm LIN"},
       true},
      {"an output that is not ready",
       [](auto& cell) {
         cell.lamp_terminal->is_ready = false;
         lamp_on(cell).execute();
       },
       "/set lamp",
       Code::kNotPossibleNow,
       {"set lamp"}},
  };
}

}  // namespace

std::vector<BrokenActivity> broken_activities() {
  std::vector<BrokenActivity> all;
  for (const auto& some : {names(), motions(), compositions(), programs()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace takt::test
