// What fails in a composition of a program in C++: nothing goes on after it, the composition fails, and says which part
// it was. Every operation with a verdict in every composition.
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/activity/command_activity.h"
#include "core/activity/dual_entry_motion.h"
#include "core/operations/force/pressing.h"
#include "core/operations/force/wipe.h"
#include "tests/core/activity/activity_cell.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;

/// With a tool changer whose lock does not move, and fingers that report this.
class VerdictCell : public test::CommandCell {
 public:
  VerdictCell()
      : CommandCell([](CommandCell& own) {
          EXPECT_FALSE(activity::declare_channels(own.core, own.cell).has_errors());
          add_changer(own);
        }) {}

  activity::Activity output(const std::string& name) {
    return app::Actuator(program, name).use<app::OutputInterface>().set(true);
  }
  bool is_set(const std::string& name) const { return cell.digital_outputs.at(name)->value(); }
  /// Only a cancel ends it.
  activity::Activity endless(const std::string& name) {
    return {program, activity::command_activity(command::WaitCommand(name, expression::digital_input(cell, "button")))};
  }
  activity::Activity grip(GripParameters parameters = {}) {
    return app::Actuator(program, "gripper").use<app::GrippingInterface>().close(parameters);
  }
  activity::Activity release() { return app::Actuator(program, "gripper").use<app::GrippingInterface>().open(); }
  activity::Activity wait_for_button(double timeout) {
    return {program, activity::command_activity(
                         command::WaitCommand("button", expression::digital_input(cell, "button"), timeout))};
  }
  /// Its end, whatever it comes to.
  activity::RunPtr carry_out(const activity::Activity& activity) {
    program.step();
    const activity::RunPtr run = activity.schedule();
    for (int i = 0; i < 20'000 && !run->over(); ++i) program.step();
    EXPECT_TRUE(run->over());
    return run;
  }

  device::GripperState fingers_report = device::GripperState::kIdle;
  double fingers_width = 0.0;
  activity::Runtime program{core, cell, [this] {
                              if (!fingers->written.empty()) fingers->answer(fingers_report, fingers_width);
                              fingers->sample.stamp = core.time();
                              step();
                            }};
  app::Actuator robot{program, "arm"};

 private:
  static void add_changer(CommandCell& own) {
    own.cell.changers["changer"] = {.arm = "arm"};
    own.cell.tool_sides["tool side"] = {.size = {}, .number = 1};
    own.cell.digital_outputs["changer/lock"] = &own.core.add(
        std::make_unique<device::DigitalOutput>("changer/lock", device::SignalOutputDescription<bool>{},
                                                std::make_shared<test::FakeOutput<bool>>(), own.core.period()));
    for (const char* name : {"changer/locked", "changer/unlocked", "changer/ready_to_lock", "changer/coupled"})
      own.cell.digital_inputs[name] = &own.core.add(std::make_unique<device::DigitalInput>(
          name, device::SignalInputDescription<bool>{}, std::make_shared<test::FakeInput<bool>>()));
    own.cell.analog_inputs["changer/tool_number"] = &own.core.add(std::make_unique<device::AnalogInput>(
        "changer/tool_number", device::SignalInputDescription<double>{.unit = "1"},
        std::make_shared<test::FakeInput<double>>()));
  }
};

/// Something that fails in this cell.
struct Failing {
  std::string name;
  std::function<activity::Activity(VerdictCell&)> make;
  Code code;
  std::string pointer;  ///< below the activity
};

constexpr const char* kNothing = "";
const Eigen::Vector3d kUp(0, 0, 1);

std::vector<Failing> all_failing() {
  return {
      {"grip", [](auto& cell) { return cell.grip(); }, Code::kConditionNotMet, kNothing},
      {"press",
       [](auto& cell) {
         return cell.robot.template use<app::ForceInterface>().press({.direction = kUp, .in = "arm", .travel = 0.002});
       },
       Code::kConditionNotMet, "/travel_m"},
      {"search",
       [](auto& cell) {
         return cell.robot.template use<app::ForceInterface>().search(
             {.direction = kUp, .in = "arm", .travel = 0.002, .radius = 0.01, .pitch = 0.004, .drop = 0.003});
       },
       Code::kConditionNotMet, "/travel_m"},
      {"wipe",
       [](auto& cell) {
         return cell.robot.perform(
             WipeParameters{.in = "arm", .centre = cell.robot.tool().translation(), .length = 0.02, .travel = 0.002});
       },
       Code::kConditionNotMet, "/travel_m"},
      {"guarded motion without a touch",
       [](auto& cell) {
         return cell.robot.template use<app::LinInterface>().lin_by(0.01 * kUp, {.until = cell.hard()});
       },
       Code::kConditionNotMet, "/until"},
      {"guarded motion with a silent sensor",
       [](auto& cell) {
         cell.sensor->silent = true;
         return cell.robot.template use<app::LinInterface>().lin_by(0.05 * kUp, {.until = cell.hard()});
       },
       Code::kSensorSilent, "/until"},
      {"motion that is aborted",
       [](auto& cell) {
         const expression::State there = near(expression::tool_pose(cell.cell, "arm"), cell.robot.tool(), 0.01, 1.0);
         return cell.robot.template use<app::LinInterface>().lin_by(0.05 * kUp, {.abort_if = !there});
       },
       Code::kAbortCondition, "/abort_if"},
      {"couple",
       [](auto& cell) {
         return app::Actuator(cell.program, "changer")
             .template use<app::ToolChangerInterface>()
             .couple({.timeout = 0.05});
       },
       Code::kSensorSilent, kNothing},
      {"wait", [](auto& cell) { return cell.wait_for_button(0.05); }, Code::kTimeout, "/until"},
  };
}

/// A composition of something that fails, of "lamp" that must not be set then, and of what only a cancel ends.
struct Composition {
  std::string name;
  std::function<activity::Activity(VerdictCell&, const activity::Activity&)> of;
  std::string part;  ///< which of its parts it is
};

expression::State always(VerdictCell& cell) { return !expression::digital_input(cell.cell, "button"); }

std::vector<Composition> all_compositions() {
  return {
      {"sequence",
       [](auto& cell, const auto& part) {
         return activity::sequence({part, cell.output("lamp")});
       },
       "/0"},
      {"sequence that it ends",
       [](auto& cell, const auto& part) {
         return activity::sequence({cell.output("driver"), part});
       },
       "/1"},
      {"nested sequence",
       [](auto& cell, const auto& part) {
         return activity::sequence(
             {cell.output("driver"), activity::sequence({part, cell.output("driver")}), cell.output("lamp")});
       },
       "/1/0"},
      {"parallel",
       [](auto& cell, const auto& part) {
         return activity::parallel({cell.endless("endless"), part});
       },
       "/1"},
      {"sequence of a parallel",
       [](auto& cell, const auto& part) {
         return activity::sequence({activity::parallel({part, cell.endless("endless")}), cell.output("lamp")});
       },
       "/0/0"},
      {"condition",
       [](auto& cell, const auto& part) { return activity::conditional(always(cell), part, cell.output("lamp")); },
       "/0"},
      {"sequence of a condition",
       [](auto& cell, const auto& part) {
         return activity::sequence(
             {activity::conditional(!always(cell), cell.output("lamp"), part), cell.output("lamp")});
       },
       "/0/1"},
      {"main task",
       [](auto& cell, const auto& part) {
         return activity::with_subtasks(part, {{.activity = cell.endless("endless"), .when = always(cell)}});
       },
       "/0"},
      {"subtask",
       [](auto& cell, const auto& part) {
         return activity::with_subtasks(cell.endless("endless"), {{.activity = part, .when = always(cell)}});
       },
       "/1"},
      {"sequence that may be aborted",
       [](auto& cell, const auto& part) {
         return activity::abort_if(activity::sequence({part, cell.output("lamp")}),
                                   expression::digital_input(cell.cell, "button"));
       },
       "/0"},
  };
}

TEST(CompositionVerdict, WhatFailsFailsItsCompositionAndNothingGoesOn) {
  for (const Failing& failing : all_failing()) {
    for (const Composition& composition : all_compositions()) {
      SCOPED_TRACE(failing.name + " in " + composition.name);
      VerdictCell cell;
      cell.program.step();
      const activity::RunPtr run = cell.carry_out(composition.of(cell, failing.make(cell)));
      ASSERT_EQ(run->state(), activity::RunState::kFailed);
      EXPECT_EQ(run->failure(), activity::RunFailure::kAborted) << run->diagnostics().to_string();
      EXPECT_FALSE(cell.is_set("lamp")) << "it went on";
      EXPECT_THAT(run->diagnostics(),
                  Reports(failing.code, pointer_segment(run->name()) + composition.part + failing.pointer))
          << run->diagnostics().to_string();
      EXPECT_EQ(run->diagnostics().list().size(), 1u) << run->diagnostics().to_string();
      EXPECT_EQ(run->inside(composition.part).state(), activity::RunState::kFailed);
      for (int i = 0; i < 600; ++i) cell.program.step();
      EXPECT_TRUE(cell.core_arm().at_rest());
      EXPECT_FALSE(cell.core_arm().held());
    }
  }
}

TEST(CompositionVerdict, AloneTheyFailAlike) {
  for (const Failing& failing : all_failing()) {
    SCOPED_TRACE(failing.name);
    VerdictCell cell;
    cell.program.step();
    const activity::RunPtr run = cell.carry_out(failing.make(cell));
    ASSERT_EQ(run->state(), activity::RunState::kFailed);
    EXPECT_EQ(run->failure(), activity::RunFailure::kAborted);
    EXPECT_THAT(run->diagnostics(), Reports(failing.code, pointer_segment(run->name()) + failing.pointer))
        << run->diagnostics().to_string();
  }
}

TEST(CompositionVerdict, NothingFollowsThatWasAskedForBehindIt) {
  VerdictCell cell;
  cell.program.step();
  const auto lin = [&](double z) { return cell.robot.use<app::LinInterface>().lin_by(z * kUp); };
  const activity::RunPtr failing = activity::sequence({lin(0.01), cell.grip()}).schedule();
  for (int i = 0; i < 20; ++i) cell.program.step();
  const activity::RunPtr behind = lin(0.02).schedule();  // the arm will be where this one begins
  for (int i = 0; i < 5'000 && !behind->over(); ++i) cell.program.step();
  EXPECT_EQ(failing->state(), activity::RunState::kFailed);
  EXPECT_EQ(behind->state(), activity::RunState::kFailed);
  EXPECT_EQ(behind->failure(), activity::RunFailure::kGivenUp);
  EXPECT_LT(behind->first_cycle(), 0);
}

TEST(CompositionVerdict, WhatSucceedsGoesOn) {
  VerdictCell cell;
  cell.fingers_report = device::GripperState::kHolding;
  cell.fingers_width = 0.04;
  const activity::RunPtr run = cell.carry_out(activity::sequence({cell.grip(), cell.output("lamp")}));
  EXPECT_EQ(run->state(), activity::RunState::kCompleted) << run->diagnostics().to_string();
  EXPECT_TRUE(cell.is_set("lamp"));
  const activity::RunPtr waited = cell.carry_out(activity::sequence(
      {activity::Activity(cell.program, activity::command_activity(command::WaitCommand("time", always(cell), 0.5))),
       cell.grip()}));
  EXPECT_EQ(waited->state(), activity::RunState::kCompleted) << waited->diagnostics().to_string();
}

// Names are those of the parts.
TEST(CompositionVerdict, SeveralOperationsOfOneKindHaveOutcomesOfTheirOwn) {
  VerdictCell cell;
  const auto any = cell.grip({.expect = GripParameters::Expect::kAny});
  const activity::RunPtr run =
      cell.carry_out(activity::sequence({any, cell.release(), any, cell.grip(), cell.output("lamp")}));
  EXPECT_EQ(run->failure(), activity::RunFailure::kAborted) << run->diagnostics().to_string();
  EXPECT_THAT(run->diagnostics(), Reports(Code::kConditionNotMet, pointer_segment(run->name()) + "/3"));
  EXPECT_EQ(run->inside("/0").state(), activity::RunState::kCompleted);
  EXPECT_EQ(run->inside("/2").state(), activity::RunState::kCompleted);
  EXPECT_EQ(run->inside("/3").state(), activity::RunState::kFailed);
  EXPECT_EQ(run->inside("/4").state(), activity::RunState::kQueued);
  EXPECT_TRUE(run->inside("/2").value<net::Real>("/grip width").has_value());
  EXPECT_FALSE(run->value<net::Real>("/grip width").has_value()) << "which of them?";
}

TEST(CompositionVerdict, GuardedMotionsAndPressesOfOneCompositionAreToldApart) {
  VerdictCell cell;
  const auto guarded =
      cell.robot.use<app::LinInterface>().lin_by(0.01 * kUp, {.until = cell.hard(), .must_touch = false});
  const auto press = [&](double travel) {
    return cell.robot.use<app::ForceInterface>().press(
        {.direction = kUp, .in = "arm", .travel = travel, .until = is_less(norm(force(cell.felt())), 1.0)});
  };
  const activity::RunPtr run = cell.carry_out(activity::sequence({guarded, press(0.01), press(0.002)}));
  EXPECT_EQ(run->state(), activity::RunState::kCompleted) << run->diagnostics().to_string();
  EXPECT_EQ(activity::guarded_outcome(run->inside("/0")).kind, activity::GuardedOutcome::Kind::kNotTouched);
  EXPECT_EQ(activity::guarded_outcome(*run).kind, activity::GuardedOutcome::Kind::kNotTouched)
      << "the only guarded motion in it";
  EXPECT_EQ(press_outcome(run->inside("/1")), PressOutcome::kConditionMet);
  EXPECT_EQ(press_outcome(run->inside("/2")), PressOutcome::kConditionMet);
}

// A command of one's own is carried out as often as one likes, in compositions and alone.
TEST(CompositionVerdict, ACommandOfOnesOwnFailsEachTime) {
  VerdictCell cell;
  const activity::Activity wait = cell.wait_for_button(0.02);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(cell.carry_out(activity::sequence({wait, cell.output("lamp")}))->failure(),
              activity::RunFailure::kAborted);
    EXPECT_EQ(cell.carry_out(wait)->failure(), activity::RunFailure::kAborted);
  }
  cell.button->sample.value = true;
  EXPECT_EQ(cell.carry_out(wait)->failure(), activity::RunFailure::kNone);
}

TEST(CompositionVerdict, WhatMayBeAbortedByTwoStatesIsAbortedByEither) {
  for (const bool first : {true, false}) {
    VerdictCell cell;
    const expression::State here = near(expression::tool_pose(cell.cell, "arm"), cell.robot.tool(), 0.01, 1.0);
    const auto lin = cell.robot.use<app::LinInterface>().lin_by(0.05 * kUp);
    const auto button = expression::digital_input(cell.cell, "button");
    const activity::Activity guarded = first ? activity::abort_if(activity::abort_if(lin, !here), button)
                                             : activity::abort_if(activity::abort_if(lin, button), !here);
    EXPECT_EQ(cell.carry_out(guarded)->failure(), activity::RunFailure::kAborted);
  }
  VerdictCell cell;
  const activity::Activity guarded =
      activity::abort_if(cell.wait_for_button(0.02), expression::digital_input(cell.cell, "button"));
  for (int i = 0; i < 2; ++i) EXPECT_EQ(cell.carry_out(guarded)->failure(), activity::RunFailure::kAborted) << i;
}

TEST(CompositionVerdict, ACommandFailsByAStateOfItsOwn) {
  for (const bool fails : {true, false}) {
    VerdictCell cell;
    command::RuntimeCommand lamp("lamp", cell.lamp(), command::set_value(true));
    lamp.fails_if(fails ? always(cell) : !always(cell));
    const activity::Activity own(cell.program, activity::command_activity(lamp));
    const activity::RunPtr run = cell.carry_out(activity::sequence({own, cell.output("driver")}));
    EXPECT_EQ(run->state(), fails ? activity::RunState::kFailed : activity::RunState::kCompleted)
        << run->diagnostics().to_string();
    EXPECT_EQ(cell.is_set("driver"), !fails);
    if (!fails) continue;
    EXPECT_THAT(run->diagnostics(), Reports(Code::kConditionNotMet, pointer_segment(run->name()) + "/0"));
  }
}

TEST(CompositionVerdict, ATransactionFailsWithAWaitInItAsInAFile) {
  VerdictCell cell;
  command::WaitCommand arc("arc", expression::digital_input(cell.cell, "button"), 0.02);
  command::RuntimeCommand seam("seam", cell.lamp(), command::set_value(true));
  command::TransactionCommand weld("weld");
  weld.add_started(arc).add(seam).on_entered(arc.completed(), start(seam));
  const activity::RunPtr run = cell.carry_out(activity::Activity(cell.program, activity::command_activity(weld)));
  EXPECT_EQ(run->failure(), activity::RunFailure::kAborted);
  EXPECT_THAT(run->diagnostics(), Reports(Code::kTimeout, "/weld/arc/until"));
  EXPECT_FALSE(cell.is_set("lamp"));
}

// -- What nobody waits for --------------------------------------------------------------------------------------------

class UnawaitedFailure : public testing::Test {
 protected:
  test::CommandCell cell{
      [](test::CommandCell& own) { EXPECT_FALSE(activity::declare_channels(own.core, own.cell).has_errors()); }};
  std::vector<std::string> events;
  activity::Runtime program{
      cell.core, cell.cell, [this] { cell.step(); }, {.event = [this](auto source, auto name, auto text) {
        events.push_back(std::string(source) + "|" + std::string(name) + "|" + std::string(text));
      }}};
  const activity::Activity guarded =
      app::Actuator(program, "arm").use<app::LinInterface>().lin_by({0, 0, 0.01}, {.until = cell.hard()});

  void let_it_end(const activity::RunPtr& run) {
    program.run_until([&] { return run->over(); });
    for (int i = 0; i < 3; ++i) program.step();
  }
};

TEST_F(UnawaitedFailure, IsToldAtOnceAndCountsUntilSomebodyAsks) {
  const activity::RunPtr run = guarded.begin_execute();
  let_it_end(run);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_THAT(events.front(), testing::HasSubstr("arm LIN|failed|condition-not-met"));
  EXPECT_THAT(program.take_failures(), Reports(Code::kConditionNotMet, "/arm LIN/until"));
  EXPECT_TRUE(program.take_failures().empty()) << "once";
}

TEST_F(UnawaitedFailure, IsNoneForWhoeverReadsItsOutcomeOrWaits) {
  const activity::RunPtr read = guarded.begin_execute();
  let_it_end(read);
  EXPECT_EQ(read->failure(), activity::RunFailure::kAborted);
  EXPECT_TRUE(program.take_failures().empty());
  events.clear();
  EXPECT_THROW(guarded.execute(), activity::ActivityError);
  const activity::RunPtr waited = guarded.begin_execute();
  EXPECT_THROW(activity::wait(program, waited), activity::ActivityError);
  program.step();
  EXPECT_TRUE(program.take_failures().empty());
  EXPECT_TRUE(events.empty());
}

TEST_F(UnawaitedFailure, WhatWasGivenUpBehindACancelIsNone) {
  const activity::RunPtr run = guarded.begin_execute();
  const activity::RunPtr behind = guarded.schedule();
  for (int i = 0; i < 20; ++i) program.step();
  run->cancel();
  let_it_end(run);
  EXPECT_EQ(behind->state(), activity::RunState::kFailed);
  EXPECT_TRUE(program.take_failures().empty());
}

}  // namespace
}  // namespace takt::operations
