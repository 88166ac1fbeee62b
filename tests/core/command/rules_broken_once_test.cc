// Every rule of the command layer, broken once: rule, place and way out are said, and nothing is loaded: a wrong
// command is refused by the check or the planning, by the mapping and by LOAD. The last test looks through the source
// for places that no case here comes to.
#include <limits>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/carried_motion.h"
#include "core/command/actions/compliance_action.h"
#include "core/command/actions/freedrive_action.h"
#include "core/command/actions/online_action.h"
#include "core/command/actions/overlay_action.h"
#include "core/command/check.h"
#include "core/command/mapping.h"
#include "core/expression/condition.h"
#include "core/expression/frame_sensors.h"
#include "tests/core/command/broken_commands.h"
#include "tests/support/error_sites.h"

namespace takt::command {
namespace {

RuntimeCommand driver(const World& world, const std::string& name) { return {name, world.driver(), set_value(true)}; }
RuntimeCommand lamp(const World& world, const std::string& name) { return {name, world.lamp(), set_value(true)}; }
WaitCommand wait_for(const State& until) { return {"wait", until}; }
WaitCommand see(const World& world, const RealSensor& sensor) {
  (void)world;
  return wait_for(is_greater(sensor, 1.0));
}

/// "all": the first starts with it, the second does not.
TransactionCommand all_of(const Command& first, const Command& second) {
  TransactionCommand all("all");
  all.add_started(first).add(second);
  return all;
}

std::vector<BrokenCommand> starts() {
  return {
      {"C1",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         a.on_entered(a.completed(), start(b));
         return all_of(a, b);
       },
       "/all/a/handlers/0", "'a' is not a transaction", "the handler on the transaction around it"},
      {"C1",
       [](World& world) -> Command {
         auto a = driver(world, "a"), d = lamp(world, "d");
         TransactionCommand inner("inner");
         inner.add(d).on_entered(inner.started(), start(d));
         TransactionCommand all = all_of(a, inner);
         all.on_entered(a.completed(), start(inner)).on_entered(a.completed(), start(d));
         return all;
       },
       "/all/handlers/1", "start of 'd', which is not directly inside of 'all'", "of the handler's own transaction"},
      {"C5",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         TransactionCommand all("all");
         all.add_started(a).add_started(b).on_entered(a.completed(), start(b));
         return all;
       },
       "/all/handlers/0", "'b' starts with its transaction already", "add() in place of add_started()"},
      {"C5",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         TransactionCommand all = all_of(a, b);
         all.on_entered(all.completed(), start(b));
         return all;
       },
       "/all/handlers/0", "'all' has ended when it is completed", "`completed` of a command inside"},
      {"C5",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b"), c = driver(world, "c");
         TransactionCommand all = all_of(c, a);
         all.add(b).on_entered(c.completed() || b.completed(), start(a));
         all.on_entered(a.completed(), start(b));
         return all;
       },
       "/all/a", "it would start itself: /all/a -> /all/b -> /all/a", "each command runs once at most"},
      {"C9", [](World&) -> Command { return TransactionCommand("empty"); }, "/empty", "nothing starts in 'empty'",
       "add_started()"},
      {"C9", [](World& world) -> Command { return all_of(driver(world, "a"), lamp(world, "b")); }, "/all/b",
       "nothing ever starts 'b'", "add_started()"},
  };
}

std::vector<BrokenCommand> ends() {
  return {
      {"C2",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         b.on_entered(b.completed(), cancel(a));
         return all_of(a, b).on_entered(a.completed(), start(b));
       },
       "/all/b/handlers/0", "cancel of 'a', which is neither 'b' nor inside of it", "the handler on the target itself"},
      {"C2",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         b.on_entered(b.completed(), stop(a));
         return all_of(a, b).on_entered(a.completed(), start(b));
       },
       "/all/b/handlers/0", "stop of 'a', which is neither 'b' nor inside of it", "a transaction around it"},
      {"C4",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         TransactionCommand all("all");
         all.add_started(a).on_cancel_forward_to({a, lamp(world, "elsewhere")});
         return all;
       },
       "/all", "cancel is forwarded to 'elsewhere', which is not directly inside", "commands of this transaction"},
      {"C10",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         a.on_entered(a.completed(), raise(RaisedState("loose")));
         return a;
       },
       "/a/handlers/0", "'loose' does not belong to a transaction around 'a'", "TransactionCommand::raised()"},
      {"C10",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         a.on_entered(TransactionCommand("other").raised("foreign").state(), cancel(a));
         return a;
       },
       "/a/handlers/0", "state 'foreign' is raised in another tree", "TransactionCommand::raised()"},
      {"C11",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         a.on_left(b.completed(), cancel(a));
         return all_of(a, b).on_entered(a.completed(), start(b));
       },
       "/all/a/handlers/0", "this state is never left", "a state of an action, or a sensor"},
      {"C11",
       [](World& world) -> Command {
         auto a = driver(world, "a"), b = lamp(world, "b");
         a.on_entered(b.started(), cancel(a));
         return all_of(a, b).on_entered(a.completed(), start(b));
       },
       "/all/a/handlers/0", "it never acts: 'b' begins only when 'a' has ended", "a transaction around both"},
      {"",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         a.on_entered(a.completed(), cancel(a), {.delay = -1.0});
         return a;
       },
       "/a/handlers/0", "a time of -1 s", "0 to 1e+06 s"},
      {"",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         a.on_entered(a.completed(), external(""));
         return a;
       },
       "/a/handlers/0", "an external effect without a name", "a name"},
  };
}

std::vector<BrokenCommand> trees() {
  return {
      {"C6",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         TransactionCommand inner("inner");
         inner.add_started(a);
         return all_of(inner, a);
       },
       "/all/a", "this command is in the tree twice", "a command of its own"},
      {"C6", [](World& world) -> Command { return wait_for(lamp(world, "stranger").completed()); }, "/wait",
       "a state of 'stranger', which is not, or more than once, in the tree '/wait'", "in this tree"},
      {"C6", [](World& world) -> Command { return wait_for(world.arm_actuator().invalid_set_point()); }, "/wait",
       "no command in this tree gives 'arm' set points", "an actuator of a command in this tree"},
      {"C7",
       [](World& world) -> Command {
         TransactionCommand all("all");
         all.add_started(driver(world, "a")).add_started(driver(world, "b"));
         return all;
       },
       "/all/b", "it drives 'driver' together with '/all/a'", "one after the other"},
      {"", [](World& world) -> Command { return driver(world, ""); }, "/", "a command without a name",
       "a name of its own"},
      {"", [](World& world) -> Command { return all_of(driver(world, "a"), lamp(world, "a")); }, "/all/a",
       "'all' has two commands of this name", "each name once"},
      {"",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         a.observe("width", gripper_width(world.cell, "gripper"));
         a.observe("width", gripper_force(world.cell, "gripper"));
         return a;
       },
       "/a/observations/width", "'width' is observed twice", "each name once in a tree"},
      {"", [](World&) -> Command { return WaitCommand("wait", -0.5); }, "/wait", "a time of -0.5 s", "0 to 1e+06 s"},
  };
}

std::vector<BrokenCommand> actions() {
  const Eigen::Isometry3d there = Eigen::Isometry3d::Identity();
  return {
      {"",
       [](World& world) -> Command {
         RuntimeCommand a("a", world.arm_actuator(), ptp(world.joints(0.2)));
         RuntimeCommand b("b", world.arm_actuator(), ptp(world.joints(0.0)));
         a.on_entered(world.hard(), cancel(a));
         return all_of(a, b).on_entered(a.completed(), start(b));
       },
       "/all/b", "the position of 'arm' when 'b' begins is unknown before the run: it depends on where 'a'",
       "not cancelled"},
      {"C8", [there](World& world) -> Command { return RuntimeCommand("a", world.driver(), lin(there)); }, "/a",
       "LIN gives", "it takes digital value"},
      {"C8",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         a.on_entered(a.action().at_path(0.5), cancel(a));
         return a;
       },
       "/a/handlers/0", "set value has no state 'at_path'", "it offers started, completed"},
      {"",
       [](World& world) -> Command {
         auto moving = move(world, ptp(world.joints(0.1)));
         moving.on_entered(moving.action().at_path(1.5), cancel(moving));
         return moving;
       },
       "/move/handlers/0", "a share of 1.5 of a path", "from 0 to 1"},
      {"C8",
       [](World& world) -> Command {
         const auto to = [&world](double a1) {
           const auto leg = [&world, goal = world.joints(a1)](const device::JointVector& q) {
             return motion::ptp_leg(planning_model(world.cell.arms.at("arm")), q, goal);
           };
           return SequencePart{.geometry = leg, .wish = {}, .blend = {motion::Blend::Kind::kFraction, 0.3}};
         };
         auto moving = move(world, sequence({to(0.1), to(0.2), to(0.0)}));
         moving.on_entered(moving.action().via_passed(2), external("passed"));
         return moving;
       },
       "/move/handlers/0", "sequence passes no point 2", "points 0 to 1"},
      {"", [](World& world) -> Command { return move(world, sequence({})); }, "/move", "a sequence without motions",
       "one at least"},
      {"", [](World& world) -> Command { return move(world, lin(world.moved(5, 0, 0))); }, "/move/goal",
       "the goal is out of reach", "a goal nearer to the base"},
      {"", [](World& world) -> Command { return move(world, ptp(world.joints(9.0))); }, "/move/goal/0",
       "is outside its range", "from -"},
      {"", [](World& world) -> Command { return move(world, ptp(world.joints(0.1), {.velocity = 0.0})); },
       "/move/options/velocity", "share 0", "above 0, at most 1"},
      {"", [](World& world) -> Command { return RuntimeCommand("a", output(world.cell, "valve"), set_value(11.0)); },
       "/a", "11 V is not for 'valve'", "0 to 10 V"},
      {"",
       [](World& world) -> Command {
         return RuntimeCommand("a", gripper(world.cell, "gripper"), grip({.force = 200.0}));
       },
       "/a/force", "200 is not for 'gripper'", "5 to 80"},
      {"",
       [](World& world) -> Command {
         return move(world, follow(channel<net::Frame>(world.cell, "target"), TrackingParameters{.linear_max = -0.1}));
       },
       "/move/linear_max", "-0.1 m/s", "above 0"},
      {"",
       [](World& world) -> Command {
         return move(world, follow(channel<net::JointArray>(world.cell, "posture"), 1.5));
       },
       "/move/velocity", "a share of 1.5", "above 0, at most 1"},
      {"",
       [there](World& world) -> Command {
         const auto pressing = pressing_force(world.cell, "wrist", Eigen::Vector3d::UnitZ());
         return move(world, hold_force(pressing, net::Frame(there), Eigen::Vector3d::UnitZ(), {.force = -5.0}));
       },
       "/move/force", "-5 N", "above 0"},
      {"",
       [there](World& world) -> Command {
         const auto pressing = pressing_force(world.cell, "wrist", Eigen::Vector3d::UnitZ());
         return move(world, hold_force(pressing, net::Frame(there), Eigen::Vector3d::Zero()));
       },
       "/move", "a direction of no length", "a vector that is not zero"},
  };
}

std::vector<BrokenCommand> compliances() {
  const auto joints = [](double value, int count = 7) {
    return net::JointArray(device::JointVector(device::JointVector::Constant(count, value)));
  };
  const auto soft = [](World& world, const SpringParameters& wish) -> Command {
    return move(world, with_compliance(hold(), wish));
  };
  const auto guided = [](World& world, const GuidanceParameters& wish) -> Command {
    return move(world, freedrive(world.cell, "arm", wish));
  };
  return {
      {"C8",
       [](World& world) -> Command {
         return RuntimeCommand("a", world.driver(), with_compliance(set_value(true), CartesianCompliance{}));
       },
       "/a", "set value gives digital value for mode cartesian_impedance, which 'driver' does not take",
       "without a mode"},
      {"", [=](World& world) { return soft(world, JointCompliance{.stiffness = joints(2500.0)}); },
       "/move/compliance/stiffness/6", "2500 Nm/rad for 'arm'", "0 to 2000 Nm/rad"},
      {"", [=](World& world) { return soft(world, JointCompliance{.damping_ratio = joints(1.0, 2)}); },
       "/move/compliance/damping_ratio", "2 values for 'arm'", "7 values"},
      {"",
       [](World& world) -> Command {
         return move(world, with_compliance(with_compliance(hold(), JointCompliance{}), CartesianCompliance{}));
       },
       "/move", "for mode joint_impedance is to be for mode cartesian_impedance", "one compliance"},
      {"", [=](World& world) { return guided(world, {.linear_max = 0.0}); }, "/move/linear_max", "0 m/s",
       "above 0 m/s"},
      {"", [=](World& world) { return guided(world, {.angular_max = std::numeric_limits<double>::infinity()}); },
       "/move/angular_max", "inf rad/s", "above 0 rad/s"},
      {"", [=](World& world) { return guided(world, {.springs = {.torque = -1.0}}); }, "/move/springs/torque", "-1 Nm",
       "from 0 Nm"},
  };
}

std::vector<BrokenCommand> names() {
  return {
      {"", [](World& world) -> Command { return RuntimeCommand("a", output(world.cell, "dirver"), set_value(true)); },
       "/a", "there is no output 'dirver'", "did you mean 'driver'?"},
      {"",
       [](World& world) -> Command {
         return RuntimeCommand("a", arm_pair(world.cell, "arm", "arm"), ptp(world.joints(0.1)));
       },
       "/a", "'arm' twice", "two arms"},
      {"",
       [](World& world) -> Command {
         return RuntimeCommand("a", arm_on_base(world.cell, "arm"), ptp(world.joints(0.1)));
       },
       "/a/arm", "'arm' stands on no base", "mounted \"on\" a base"},
      {"", [](World& world) -> Command { return see(world, gripper_width(world.cell, "grapper")); }, "/wait",
       "there is no gripper 'grapper'", "did you mean 'gripper'?"},
      {"", [](World& world) -> Command { return wait_for(gripper_state(world.cell, "gripper", "shut")); }, "/wait",
       "a gripper has no state 'shut'", "allowed: moving, holding"},
      {"", [](World& world) -> Command { return see(world, channel<net::Real>(world.cell, "enable")); }, "/wait",
       "channel 'enable' carries Boolean", "not Real"},
      {"",
       [](World& world) -> Command {
         return see(world,
                    distance(pose_between(world.cell, "blok", "world"), net::Frame(Eigen::Isometry3d::Identity())));
       },
       "/wait", "there is no frame 'blok'", "did you mean 'block'?"},
      {"", [](World& world) -> Command { return see(world, component(force(world.felt()), 3)); }, "/wait",
       "a vector has axes 0 to 2", "x, y or z"},
      {"",
       [](World& world) -> Command { return see(world, pressing_force(world.cell, "wrist", Eigen::Vector3d::Zero())); },
       "/wait", "a direction of no length", "a vector that is not zero"},
      {"", [](World& world) -> Command { return wait_for(world.hard().held_for(-1.0)); }, "/wait", "a time of -1 s",
       "0 to 1e+06 s"},
      {"C8",
       [](World& world) -> Command {
         WaitCommand wait("wait", world.hard());
         wait.on_entered(wait.timed_out(), external("late"));
         return wait;
       },
       "/wait/handlers/0", "'wait' has no timeout, so it never times out", "a wait for a state, with a timeout"},
      {"", [](World&) -> Command { return wait_for(State(nullptr)); }, "/wait", "an empty formula",
       "a sensor or a state"},
      {"",
       [](World& world) -> Command {
         RealSensor deep = gripper_width(world.cell, "gripper");
         for (int i = 0; i < 1001; ++i) deep = deep + 1.0;
         return see(world, deep);
       },
       "/wait", "a formula of 1", "at most 1000"},
  };
}

/// What was said in all cases so far, for the look through the source.
std::set<std::string>& all_said() {
  static std::set<std::string> said;
  return said;
}

void expect_told(const Diagnostics& diagnostics, const std::string& place, const std::string& message,
                 const std::string& way_out) {
  bool told = false;
  for (const Diagnostic& diagnostic : diagnostics.list()) {
    all_said().insert(diagnostic.message);
    EXPECT_FALSE(diagnostic.hint.empty()) << "no way out: " << to_string(diagnostic);
    told = told || (diagnostic.pointer == place && diagnostic.message.find(message) != std::string::npos &&
                    diagnostic.hint.find(way_out) != std::string::npos);
  }
  EXPECT_TRUE(told) << "expected " << place << ": " << message << " (" << way_out << "), found\n"
                    << diagnostics.to_string();
}

void break_commands() {
  for (const auto& table : {starts(), ends(), trees(), actions(), broken_overlays(), compliances(), names()}) {
    for (const BrokenCommand& rule : table) {
      World world;
      const Command command = rule.make(world);
      const std::string message = (rule.rule.empty() ? "" : rule.rule + ": ") + rule.message;
      SCOPED_TRACE(message);
      const auto loaded = world.runtime.load(command);
      ASSERT_FALSE(loaded.has_value());
      expect_told(loaded.error(), rule.place, message, rule.way_out);
      EXPECT_FALSE(map(command).has_value());
      EXPECT_EQ(world.runtime.execute(command).state, activity::RunState::kFailed);
      world.step(10);
      EXPECT_EQ(world.q(), world.arm->home);
      EXPECT_FALSE(world.core_arm().held());
      for (const auto& [name, output] : world.cell.digital_outputs) EXPECT_FALSE(output->held()) << name;
      EXPECT_FALSE(world.cell.grippers.at("gripper").device->held());
    }
  }
}

void break_conditions() {
  const World world;
  const auto wrong = [&world](const char* text) {
    return parse_condition(nlohmann::ordered_json::parse(text), "/until", world.cell).error();
  };
  expect_told(wrong(R"({"sensor": "wrist"})"), "/until", "exactly one threshold is needed", "'above_N' or 'below_N'");
  expect_told(wrong(R"({"internal_force": ["wrist"], "above_N": 5})"), "/until/internal_force", "1 sensors",
              "two: one on each arm");
  expect_told(wrong(R"({"internal_force": ["wrist", "writs"], "above_N": 5})"), "/until/internal_force/1",
              "there is no force/torque sensor 'writs'", "did you mean 'wrist'?");
  expect_told(wrong(R"({"internal_force": ["wrist", "wrist"], "above_N": 5})"), "/until/internal_force",
              "'wrist' and 'wrist' are both on 'arm'", "sensors on two arms");
  expect_told(wrong(R"({"gripper": "grapper", "is": "lost"})"), "/until/gripper", "there is no gripper 'grapper'",
              "did you mean 'gripper'?");
  expect_told(wrong(R"({"any": []})"), "/until/any", "no condition is given", "at least one");
}

void break_carriers() {
  const World world;
  expect_told(carrier_of(world.cell, "arm").error(), "/arm", "'arm' stands on no base", "mounted \"on\" a base");
}

/// Single joints, composed devices, motions that say where they begin.
void break_actuators() {
  World world;
  const auto told = [](const Command& command, const std::string& place, const std::string& message,
                       const std::string& way_out) {
    Diagnostics found = plan(command);
    found.append(check(command, false));
    expect_told(found, place, message, way_out);
  };
  const auto on = [](const Actuator& actuator, const Action& action) { return RuntimeCommand("m", actuator, action); };
  const device::JointVector one = device::JointVector::Constant(1, 0.1);
  told(on(joint(world.cell, "arm", 9), ptp(one)), "/m", "'arm' has no joint 9", "0 to 6");
  told(on(joint(world.cell, "arm", 1), ptp(world.joints(0.1))), "/m", "a goal of 7 joints for 'arm joint 1'",
       "one number");
  told(on(joint(world.cell, "arm", 1), lin(world.moved(0, 0, 0.05))), "/m", "C8: LIN is not for 'arm joint 1'",
       "ptp()");
  told(on(composed("nothing", {}), ptp(one)), "/m", "'nothing' has no parts", "at least one actuator");
  const Actuator lamps = composed("lamps", {world.lamp(), world.driver()});
  told(on(lamps, ptp(one)), "/m", "no part of 'lamps' takes PTP", "an action for one of its parts");
  told(on(lamps, set_value(true)), "/m", "2 parts of 'lamps' take", "one of lamp, driver");
  world.step(5);
  told(on(world.arm_actuator(), ptp(world.joints(0.1), {.from = device::JointVector::Zero(2)})), "/m/from",
       "2 joints for 'arm'", "7 joints");
  TransactionCommand both("both");
  const RuntimeCommand first("first", world.arm_actuator(), ptp(world.joints(0.1)));
  const RuntimeCommand second("second", world.arm_actuator(), ptp(world.joints(0.3), {.from = world.joints(0.2)}));
  both.add_started(first).add(second);
  both.on_entered(first.completed(), start(second));
  told(both, "/both/second/from", "'second' begins elsewhere than where 'arm' will be", "where the motion before it");
}

/// Before the first cycle nobody knows where an arm is.
void break_beginnings() {
  rcc::ControlCore core{{}};
  Cell cell;
  const auto arm = device::read_arm("models/lwr4plus").value();
  cell.arms["arm"].device =
      &core.add(std::make_unique<device::Arm>("arm", arm, std::make_shared<test::FakeArm>(arm->home), core.period()));
  const RuntimeCommand moved("move", command::arm(cell, "arm"), ptp(arm->home));
  expect_told(plan(moved), "/move", "the position of 'arm' is not known yet", "a cycle of the core before");
}

/// The TX90 knows one mode, and nothing feels on it.
void break_modes() {
  rcc::ControlCore core{{}};
  Cell cell;
  const auto arm = device::read_arm("models/tx90").value();
  cell.arms["arm"].device =
      &core.add(std::make_unique<device::Arm>("arm", arm, std::make_shared<test::FakeArm>(arm->home), core.period()));
  core.step();
  test::CommandRuns runtime(core, cell);
  const auto load = [&](const Action& action) {
    const auto loaded = runtime.load(RuntimeCommand("move", command::arm(cell, "arm"), action));
    return loaded ? Diagnostics() : loaded.error();
  };
  expect_told(load(freedrive(cell, "arm")), "/move", "C8: 'arm' cannot be guided by hand", "the mode joint_impedance");
  expect_told(load(with_compliance(hold(), JointCompliance{})), "/move",
              "for mode joint_impedance, which 'arm' does not take", "it takes them for position");
}

/// Without plan(): what map() says.
void break_maps() {
  World world;
  const Command unplanned = move(world, ptp(world.joints(0.1)));
  const auto mapped = map(unplanned);
  ASSERT_FALSE(mapped);
  expect_told(mapped.error(), "/move", "PTP is not planned", "plan() before it is mapped");
}

void once(void (*table)()) {
  static std::set<void (*)()> done;
  if (done.insert(table).second) table();
}

TEST(CommandRulesBrokenOnce, OfCommands) { once(break_commands); }
TEST(CommandRulesBrokenOnce, OfConditions) { once(break_conditions); }
TEST(CommandRulesBrokenOnce, OfHandles) { once(break_carriers); }
TEST(CommandRulesBrokenOnce, OfBeginnings) { once(break_beginnings); }
TEST(CommandRulesBrokenOnce, OfActuators) { once(break_actuators); }
TEST(CommandRulesBrokenOnce, OfModes) { once(break_modes); }
TEST(CommandRulesBrokenOnce, OfMaps) { once(break_maps); }

// All at once: each is told, none hides another.
TEST(CommandRulesBrokenOnce, AllOfThemAtOnce) {
  World world;
  std::vector<BrokenCommand> rules;
  for (const auto& table : {starts(), ends(), trees()}) rules.insert(rules.end(), table.begin(), table.end());
  std::vector<Command> kept;
  Diagnostics diagnostics;
  TransactionCommand whole("whole");
  for (std::size_t i = 0; i < rules.size(); ++i) {
    TransactionCommand one("rule " + std::to_string(i));
    one.add_started(kept.emplace_back(rules[i].make(world)));
    whole.add_started(one);
  }
  diagnostics = check(whole);
  for (std::size_t i = 0; i < rules.size(); ++i) {
    const std::string place = "/whole/rule " + std::to_string(i) + rules[i].place;
    EXPECT_TRUE(std::ranges::any_of(diagnostics.list(),
                                    [&](const Diagnostic& diagnostic) {
                                      return diagnostic.pointer == place &&
                                             diagnostic.message.starts_with(rules[i].rule);
                                    }))
        << place << ": " << rules[i].message << "\n"
        << diagnostics.to_string();
  }
}

/// What no wrong use comes to, and why.
const std::vector<std::pair<std::string, std::string>> kElsewhere = {
    {" is not planned", "of actions that say they need a plan and make none: none does"},
    {"the arm has no inverse kinematics", "no model has so few joints"},
    {"two arms as one have stiffness only, no force", "there is one arm here; two_arms_test.cc has the case"},
};

// A place of the source that says what is wrong has a case above. Whoever adds one adds a case.
TEST(CommandRulesBrokenOnce, EveryPlaceInTheSourceHasACase) {
  for (const auto table :
       {break_commands, break_conditions, break_carriers, break_beginnings, break_actuators, break_modes, break_maps})
    once(table);
  std::vector<test::ErrorSite> sites;
  for (const char* folder : {"core/expression", "core/command", "core/command/actions"})
    std::ranges::copy(test::error_sites(folder), std::back_inserter(sites));
  ASSERT_GT(sites.size(), 40u) << "the look through the source finds nothing any more";
  for (const test::ErrorSite& site : sites) {
    const bool elsewhere = std::ranges::any_of(kElsewhere, [&](const auto& one) { return site.message == one.first; });
    const bool said = std::ranges::any_of(all_said(), [&](const std::string& text) { return test::says(site, text); });
    EXPECT_TRUE(said || elsewhere) << site.place << " says \"" << site.message << "\": no case breaks this rule";
  }
}

}  // namespace
}  // namespace takt::command
