// Wrong uses of activities: names, interfaces, blends, compositions, two arms, coroutines, ends.
#include "tests/core/activity/broken_activities.h"

#include <limits>

#include "core/activity/command_activity.h"

namespace takt::test {
namespace {

using activity::Activity;
using activity::Actuator;
using activity::BlendingCondition;
using activity::GrippingInterface;
using activity::LinInterface;
using activity::OutputInterface;
using activity::Runtime;
using activity::Task;

Activity lamp_on(ActivityCell& cell) { return Actuator(cell.program, "lamp").use<OutputInterface>().set(true); }
Activity up(ActivityCell& cell, const activity::MotionParameters& wish = {}) {
  return cell.motion.lin_by({0.0, 0.0, 0.05}, wish);
}
activity::MotionParameters blended(const BlendingCondition& blend) { return {.blend = blend}; }
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
      {"an actuator that is not there", [](auto& cell) { (void)Actuator(cell.program, "amr"); }, "/amr",
       "the cell has no actuator 'amr'", "did you mean 'arm'?"},
      {"an interface that it does not have",
       [](auto& cell) { (void)Actuator(cell.program, "gripper").template use<LinInterface>(); }, "/gripper",
       "'gripper' has no LinInterface", "it offers GrippingInterface"},
      {"what only arms have", [](auto& cell) { (void)Actuator(cell.program, "lamp").home(); }, "/lamp",
       "'lamp' is not an arm", "an arm of the cell"},
      {"a frame that is not there", [](auto& cell) { (void)cell.robot.above("blok", 0.1); }, "/arm",
       "there is no frame 'blok'", "did you mean 'block'?"},
      {"a motion of no arm",
       [](auto& cell) { Activity(cell.program, activity::motion_activity("LIN", "amr", {}, {})).execute(); },
       "/amr LIN/arm", "there is no arm 'amr'", "did you mean 'arm'?"},
      {"a speed beyond the plan", [](auto& cell) { cell.robot.set_speed(1.5); }, "/arm", "a speed of 1.5",
       "from 0 to 1"},
      {"a speed that is not a number",
       [](auto& cell) { cell.robot.set_speed(std::numeric_limits<double>::quiet_NaN()); }, "/arm", "a speed of nan",
       "from 0 to 1"},
      {"the speed of no arm", [](auto& cell) { cell.program.pause("amr"); }, "/amr", "there is no arm 'amr'",
       "did you mean 'arm'?"},
      {"a speed without channels",
       [](auto& cell) {
         cell.cell.arms["second"] = cell.cell.arms.at("arm");
         cell.program.set_speed("second", 0.5);
       },
       "/second", "'second' has no channel for its speed", "declare_channels()"},
      {"a load below nothing", [](auto& cell) { cell.robot.carry(-1.0); }, "/arm", "a mass of -1 kg", "0 or more"},
      {"a load while it moves",
       [](auto& cell) {
         up(cell).begin_execute();
         cell.robot.carry(1.0);
       },
       "/arm", "'arm' runs: its load changes between activities", "after their end", true},
  };
}

std::vector<BrokenActivity> motions() {
  return {
      {"a goal out of reach", [](auto& cell) { cell.motion.lin(cell.moved(3, 0, 0)).execute(); }, "/arm LIN/0/goal",
       "the goal is out of reach", "a goal nearer to the base"},
      {"a share above all", [](auto& cell) { up(cell, {.velocity = 1.5}).execute(); }, "/arm LIN/speed",
       "unexpected value 1.5", "above 0, at most 1"},
      {"a blend too early", [](auto& cell) { up(cell, blended(0.2)).execute(); }, "/arm LIN/blend",
       "a blend at a share of 0.2", "at least 0.5 and below 1"},
      {"a blend behind the goal",
       [](auto& cell) { up(cell, blended(BlendingCondition::at_distance(-0.01))).execute(); }, "/arm LIN/blend_m",
       "unexpected value -0.01", "1e-05"},
      {"a blend by both", [](auto& cell) { up(cell, blended(by_both())).execute(); }, "/arm LIN/blend",
       "a blend by time and by distance", "one of them"},
      {"a blend over more than half of the path", [](auto& cell) { up(cell, blended(over_share(0.7))).execute(); },
       "/arm LIN/blend_fraction", "unexpected value 0.7", "0.0001 to 0.5"},
      {"a blend of a guarded motion", [](auto& cell) { up(cell, {.blend = 0.7, .until = cell.hard()}).execute(); },
       "/arm LIN/blend", "the end of a guarded motion is unknown", "no blend, or no condition"},
      {"a motion from nobody knows where",
       [](auto& cell) {
         activity::sequence({up(cell, {.until = cell.hard()}), up(cell)}).execute();
       },
       "/arm LIN, arm LIN/1", "'arm LIN': its end position is unknown before the run", "after the end of what runs"},
      {"a condition of a sensor that is not there",
       [](auto& cell) {
         up(cell, {.until = is_greater(norm(force(command::contact_wrench(cell.cell, "writs"))), 5.0)}).execute();
       },
       "/arm LIN/handlers/0", "there is no force/torque sensor 'writs'", "did you mean 'wrist'?"},
      {"a width that the gripper does not have",
       [](auto& cell) {
         Actuator(cell.program, "gripper").template use<GrippingInterface>().close({.width = 0.3}).execute();
       },
       "/grip gripper/width_m", "0.3 is not for 'gripper'", "0 to 0.11"},
      {"a hold for less than no time",
       [](auto& cell) { cell.robot.template use<activity::HoldInterface>().hold(-1.0).execute(); }, "/hold arm/seconds",
       "unexpected value -1", "3600"},
      {"a force that pulls",
       [](auto& cell) { cell.robot.template use<activity::ForceInterface>().press({.force = -5.0}).execute(); },
       "/press arm/force_N", "unexpected value -5", "0.1"},
      {"a joint that the arm does not have",
       [](auto& cell) { cell.robot.template use<activity::JointInterface>().move_to(9, 0.1).execute(); }, "/arm",
       "'arm' has no joint 9", "0 to 6"},
      {"a value of the wrong kind",
       [](auto& cell) { Actuator(cell.program, "lamp").template use<OutputInterface>().set(3.0).execute(); },
       "/set lamp", "gives analog value, which 'lamp' does not take", "it takes digital value"},
  };
}

std::vector<BrokenActivity> compositions() {
  const auto with = [](ActivityCell& cell, const activity::Subtask& subtask) {
    with_subtasks(up(cell), {subtask}).execute();
  };
  return {
      {"nothing in sequence", [](auto&) { (void)activity::sequence({}); }, "", "a composition without parts",
       "at least one"},
      {"one arm twice at the same time",
       [](auto& cell) {
         (void)activity::parallel({up(cell), lamp_on(cell), up(cell)});
       },
       "/2", "'arm LIN' drives 'arm' together with 'arm LIN'", "sequence()"},
      {"parts of two programs",
       [](auto& cell) {
         OtherProgram other(cell);
         (void)activity::sequence({up(cell), other.lamp_on()});
       },
       "/1", "'set lamp' belongs to another runtime than 'arm LIN'", "activities of one Runtime"},
      {"a choice between two programs",
       [](auto& cell) {
         OtherProgram other(cell);
         (void)conditional(cell.hard(), up(cell), other.lamp_on());
       },
       "/1", "belongs to another runtime", "activities of one Runtime"},
      {"an end that there is no command for",
       [](auto& cell) {
         abort_if(cell.robot.template use<activity::ControlModeInterface>().switch_to("position"), cell.hard())
             .execute();
       },
       "/arm position/abort_if", "'arm position' is not a command, so nothing can end it",
       "an activity that moves something"},
      {"more ways to end than a sequence follows",
       [](auto& cell) {
         const auto either = [&] { return conditional(cell.hard(), up(cell), lamp_on(cell)); };
         activity::sequence({either(), either(), either(), either()}).execute();
       },
       "/4 parts, /3", "16 ways in which it may end", "8 at most"},
      {"a subtask on the arm of the main task",
       [with](auto& cell) { with(cell, {.activity = up(cell), .at_share = 0.5}); }, "/subtasks/0",
       "'arm LIN' drives 'arm' together with 'arm LIN'", "sequence()"},
      {"a subtask that never begins", [with](auto& cell) { with(cell, {.activity = lamp_on(cell)}); },
       "/arm LIN with subtasks/subtasks/0", "it never begins", "`at_share` or `when`"},
      {"a subtask beyond the end", [with](auto& cell) { with(cell, {.activity = lamp_on(cell), .at_share = 1.5}); },
       "/arm LIN with subtasks/subtasks/0", "share 1.5", "from 0 to 1"},
      {"a share of what has no way",
       [](auto& cell) { with_subtasks(lamp_on(cell), {{.activity = up(cell), .at_share = 0.5}}).execute(); },
       "/set lamp with subtasks/subtasks/0", "'set lamp' is not a motion", "`when`"},
  };
}

std::vector<BrokenActivity> programs() {
  return {
      {"a coroutine that blocks", [](auto& cell) { cell.program.run(one_that([&] { lamp_on(cell).execute(); })); }, "",
       "a coroutine may not block", "co_await"},
      {"a coroutine that runs another one to its end",
       [](auto& cell) { cell.program.run(one_that([&] { cell.program.run(one_that([] {})); })); }, "",
       "a coroutine may not block", "co_await"},
      {"a coroutine that runs the loop", [](auto& cell) { cell.program.run(one_that([&] { cell.program.step(); })); },
       "", "a coroutine may not block", "co_await"},
      {"a program that never waits",
       [](auto& cell) {
         cell.program.run([](ActivityCell& own) -> Task {
           for (;;) co_await own.program.cycles(0);
         }(cell));
       },
       "", "the program went on 10000 times without a cycle between", "co_await cycles(1)"},
      {"a wait for what never comes",
       [](auto& cell) {
         Runtime hasty(cell.core, cell.cell, [&cell] { cell.step(); }, {.scheduler = {}, .most_cycles = 10});
         hasty.run_until([] { return false; });
       },
       "", "nothing came of it within 10 cycles", "a larger most_cycles"},
      {"a start after the end",
       [](auto& cell) {
         cell.program.cancel();
         up(cell).execute();
       },
       "", "the program was cancelled", "a Runtime of its own"},
      {"what waits behind a motion that is cancelled",
       [](auto& cell) {
         const auto first = up(cell).begin_execute();
         const auto second = up(cell).schedule();
         first->cancel();
         wait(cell.program, second);
       },
       "/arm LIN", "'arm LIN' was given up: 'arm LIN' before it was cancelled", "ask for it again", true},
      {"a motion of an arm that fails on its way",
       [](auto& cell) {
         const auto run = up(cell).begin_execute();
         for (int i = 0; i < 50; ++i) cell.program.step();
         cell.backend->state().ready = false;
         wait(cell.program, run);
       },
       "/arm LIN", "'arm LIN' was stopped in cycle", "ask for it again", true},
      {"an output that is not ready",
       [](auto& cell) {
         cell.lamp_terminal->is_ready = false;
         lamp_on(cell).execute();
       },
       "/set lamp", "'set lamp' was not started: ", "ask for it again"},
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
