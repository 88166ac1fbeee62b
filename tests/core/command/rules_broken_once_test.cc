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
#include "tests/support/reports.h"

namespace takt::command {
namespace {

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
       "/all/b",
       Code::kUnknownPosition,
       {"arm", "b", "a"}},
      {"C8", [there](World& world) -> Command { return RuntimeCommand("a", world.driver(), lin(there)); }, "/a",
       Code::kInvalidValue},
      {"C8",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         a.on_entered(a.action().at_path(0.5), cancel(a));
         return a;
       },
       "/a/handlers/0",
       Code::kUnknownName,
       {"at_path"}},
      {"C8",
       [](World& world) -> Command {
         auto a = driver(world, "a");
         a.on_entered(a.paused(), cancel(a));
         return a;
       },
       "/a/handlers/0",
       Code::kInvalidValue,
       {"a"}},
      {"",
       [](World& world) -> Command {
         auto moving = move(world, ptp(world.joints(0.1)));
         moving.on_entered(moving.action().at_path(1.5), cancel(moving));
         return moving;
       },
       "/move/handlers/0",
       Code::kOutOfRange,
       {"1.5", "0", "1"}},
      {"C8",
       [](World& world) -> Command {
         const auto to = [&world](double a1) {
           const auto leg = [&world, goal = world.joints(a1)](const device::JointVector& q) {
             return motion::ptp_leg(expression::planning_model(world.cell.arms.at("arm")), q, goal);
           };
           return SequencePart{.geometry = leg, .parameters = {}, .blend = {motion::Blend::Kind::kFraction, 0.3}};
         };
         auto moving = move(world, sequence({to(0.1), to(0.2), to(0.0)}));
         moving.on_entered(moving.action().via_passed(2), external("passed"));
         return moving;
       },
       "/move/handlers/0",
       Code::kUnknownName,
       {"2", "0", "1"}},
      {"", [](World& world) -> Command { return move(world, sequence({})); }, "/move", Code::kMissing},
      {"", [](World& world) -> Command { return move(world, lin(world.moved(5, 0, 0))); }, "/move/goal",
       Code::kUnreachable},
      {"", [](World& world) -> Command { return move(world, ptp(world.joints(9.0))); }, "/move/goal/0",
       Code::kOutOfRange},
      {"",
       [](World& world) -> Command { return move(world, ptp(world.joints(0.1), {.velocity = 0.0})); },
       "/move/options/velocity",
       Code::kOutOfRange,
       {"0", "1"}},
      {"",
       [](World& world) -> Command { return RuntimeCommand("a", output(world.cell, "valve"), set_value(11.0)); },
       "/a",
       Code::kOutOfRange,
       {"valve", "11", "0", "10"}},
      {"",
       [](World& world) -> Command {
         return RuntimeCommand("a", gripper(world.cell, "gripper"), grip({.force = 200.0}));
       },
       "/a/force",
       Code::kOutOfRange,
       {"gripper", "200", "5", "80"}},
      {"",
       [](World& world) -> Command {
         return move(world, follow(channel<net::Frame>(world.cell, "target"), TrackingParameters{.linear_max = -0.1}));
       },
       "/move/linear_max",
       Code::kOutOfRange,
       {"-0.1", "0"}},
      {"",
       [](World& world) -> Command {
         return move(world, follow(channel<net::JointArray>(world.cell, "posture"), 1.5));
       },
       "/move/velocity",
       Code::kOutOfRange,
       {"1.5", "0", "1"}},
      {"",
       [there](World& world) -> Command {
         const auto pressing = pressing_force(world.cell, "wrist", Eigen::Vector3d::UnitZ());
         return move(world, hold_force(pressing, net::Frame(there), Eigen::Vector3d::UnitZ(), {.force = -5.0}));
       },
       "/move/force",
       Code::kOutOfRange,
       {"-5", "0"}},
      {"",
       [there](World& world) -> Command {
         const auto pressing = pressing_force(world.cell, "wrist", Eigen::Vector3d::UnitZ());
         return move(world, hold_force(pressing, net::Frame(there), Eigen::Vector3d::Zero()));
       },
       "/move", Code::kOutOfRange},
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
       "/a",
       Code::kInvalidValue,
       {"driver", "cartesian_impedance"}},
      {"",
       [=](World& world) { return soft(world, JointCompliance{.stiffness = joints(2500.0)}); },
       "/move/compliance/stiffness/6",
       Code::kOutOfRange,
       {"arm", "2500", "0", "2000"}},
      {"",
       [=](World& world) { return soft(world, JointCompliance{.damping_ratio = joints(1.0, 2)}); },
       "/move/compliance/damping_ratio",
       Code::kWrongSize,
       {"arm", "2", "7"}},
      {"",
       [](World& world) -> Command {
         return move(world, with_compliance(with_compliance(hold(), JointCompliance{}), CartesianCompliance{}));
       },
       "/move",
       Code::kConflict,
       {"joint_impedance", "cartesian_impedance"}},
      {"",
       [=](World& world) { return guided(world, {.linear_max = 0.0}); },
       "/move/linear_max",
       Code::kOutOfRange,
       {"0"}},
      {"",
       [=](World& world) { return guided(world, {.angular_max = std::numeric_limits<double>::infinity()}); },
       "/move/angular_max",
       Code::kOutOfRange,
       {"0"}},
      {"",
       [=](World& world) { return guided(world, {.springs = {.torque = -1.0}}); },
       "/move/springs/torque",
       Code::kOutOfRange,
       {"-1", "0"}},
  };
}

std::vector<BrokenCommand> names() {
  return {
      {"",
       [](World& world) -> Command { return RuntimeCommand("a", output(world.cell, "dirver"), set_value(true)); },
       "/a",
       Code::kUnknownName,
       {"dirver", "driver"}},
      {"",
       [](World& world) -> Command {
         return RuntimeCommand("a", arm_pair(world.cell, "arm", "arm"), ptp(world.joints(0.1)));
       },
       "/a",
       Code::kDuplicate,
       {"arm"}},
      {"",
       [](World& world) -> Command {
         return RuntimeCommand("a", arm_on_base(world.cell, "arm"), ptp(world.joints(0.1)));
       },
       "/a/arm",
       Code::kRequires,
       {"arm", "on"}},
      {"",
       [](World& world) -> Command { return see(world, expression::gripper_width(world.cell, "grapper")); },
       "/wait",
       Code::kUnknownName,
       {"grapper", "gripper"}},
      {"",
       [](World& world) -> Command { return wait_for(expression::gripper_state(world.cell, "gripper", "shut")); },
       "/wait",
       Code::kUnknownName,
       {"shut"}},
      {"",
       [](World& world) -> Command { return see(world, channel<net::Real>(world.cell, "enable")); },
       "/wait",
       Code::kTypeMismatch,
       {"enable"}},
      {"",
       [](World& world) -> Command {
         return see(world, expression::distance(expression::pose_between(world.cell, "blok", "world"),
                                                net::Frame(Eigen::Isometry3d::Identity())));
       },
       "/wait",
       Code::kUnknownName,
       {"blok", "block"}},
      {"",
       [](World& world) -> Command { return see(world, expression::component(expression::force(world.felt()), 3)); },
       "/wait",
       Code::kOutOfRange,
       {"0", "2"}},
      {"",
       [](World& world) -> Command { return see(world, pressing_force(world.cell, "wrist", Eigen::Vector3d::Zero())); },
       "/wait", Code::kOutOfRange},
      {"",
       [](World& world) -> Command { return wait_for(world.hard().held_for(-1.0)); },
       "/wait",
       Code::kOutOfRange,
       {"-1", "0"}},
      {"C8",
       [](World& world) -> Command {
         WaitCommand wait("wait", world.hard());
         wait.on_entered(wait.timed_out(), external("late"));
         return wait;
       },
       "/wait/handlers/0",
       Code::kRequires,
       {"wait"}},
      {"", [](World&) -> Command { return wait_for(expression::State(nullptr)); }, "/wait", Code::kMissing},
      {"",
       [](World& world) -> Command {
         expression::RealSensor deep = expression::gripper_width(world.cell, "gripper");
         for (int i = 0; i < 1001; ++i) deep = deep + 1.0;
         return see(world, deep);
       },
       "/wait",
       Code::kTooLarge,
       {"1000"}},
  };
}

/// What was said in all cases so far, for the look through the source.
std::set<std::string>& all_said() {
  static std::set<std::string> said;
  return said;
}

/// One of the diagnostics is the expected one, and each has a hint.
void expect_told(const Diagnostics& diagnostics, const std::string& place, Code code,
                 const std::vector<std::string>& names = {}) {
  for (const Diagnostic& diagnostic : diagnostics.list()) {
    all_said().insert(diagnostic.message);
    EXPECT_FALSE(diagnostic.hint.empty()) << "no hint: " << to_string(diagnostic);
  }
  EXPECT_THAT(diagnostics, takt::test::Reports(code, place, names));
}

void break_commands() {
  for (const auto& table : {broken_handlers(), actions(), broken_overlays(), compliances(), names()}) {
    for (const BrokenCommand& rule : table) {
      World world;
      const Command command = rule.make(world);
      std::vector<std::string> names = rule.names;
      if (!rule.rule.empty()) names.push_back(rule.rule);
      SCOPED_TRACE(rule.rule + " " + rule.place);
      const auto loaded = world.runtime.load(command);
      ASSERT_FALSE(loaded.has_value());
      expect_told(loaded.error(), rule.place, rule.code, names);
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
    return expression::parse_condition(nlohmann::ordered_json::parse(text), "/until", world.cell).error();
  };
  expect_told(wrong(R"({"sensor": "wrist"})"), "/until", Code::kConflict, {"above_N", "below_N"});
  expect_told(wrong(R"({"internal_force": ["wrist"], "above_N": 5})"), "/until/internal_force", Code::kWrongSize,
              {"1"});
  expect_told(wrong(R"({"internal_force": ["wrist", "writs"], "above_N": 5})"), "/until/internal_force/1",
              Code::kUnknownName, {"writs", "wrist"});
  expect_told(wrong(R"({"internal_force": ["wrist", "wrist"], "above_N": 5})"), "/until/internal_force",
              Code::kConflict, {"wrist", "arm"});
  expect_told(wrong(R"({"gripper": "grapper", "is": "lost"})"), "/until/gripper", Code::kUnknownName,
              {"grapper", "gripper"});
  expect_told(wrong(R"({"distance": ["arm"], "below_m": 0.1})"), "/until/distance", Code::kWrongSize, {"1"});
  expect_told(wrong(R"({"any": []})"), "/until/any", Code::kMissing);
}

void break_carriers() {
  const World world;
  expect_told(carrier_of(world.cell, "arm").error(), "/arm", Code::kRequires, {"arm", "on"});
}

/// Single joints, composed devices, motions that say where they begin.
void break_actuators() {
  World world;
  const auto told = [](const Command& command, const std::string& place, Code code,
                       const std::vector<std::string>& names = {}) {
    Diagnostics found = plan(command);
    found.append(check(command, false));
    expect_told(found, place, code, names);
  };
  const auto on = [](const Actuator& actuator, const Action& action) { return RuntimeCommand("m", actuator, action); };
  const device::JointVector one = device::JointVector::Constant(1, 0.1);
  told(on(joint(world.cell, "arm", 9), ptp(one)), "/m", Code::kOutOfRange, {"arm", "9", "6"});
  told(on(joint(world.cell, "arm", 1), ptp(world.joints(0.1))), "/m", Code::kWrongSize, {"7", "arm joint 1"});
  told(on(joint(world.cell, "arm", 1), lin(world.moved(0, 0, 0.05))), "/m", Code::kInvalidValue, {"C8", "arm joint 1"});
  told(on(composed("nothing", {}), ptp(one)), "/m", Code::kMissing, {"nothing"});
  const Actuator lamps = composed("lamps", {world.lamp(), world.driver()});
  told(on(lamps, ptp(one)), "/m", Code::kUnsupported, {"lamps", "PTP"});
  told(on(lamps, set_value(true)), "/m", Code::kConflict, {"2", "lamp", "driver"});
  world.step(5);
  told(on(world.arm_actuator(), ptp(world.joints(0.1), {.from = device::JointVector::Zero(2)})), "/m/from",
       Code::kWrongSize, {"2", "arm", "7"});
  TransactionCommand both("both");
  const RuntimeCommand first("first", world.arm_actuator(), ptp(world.joints(0.1)));
  const RuntimeCommand second("second", world.arm_actuator(), ptp(world.joints(0.3), {.from = world.joints(0.2)}));
  both.add_started(first).add(second);
  both.on_entered(first.completed(), start(second));
  told(both, "/both/second/from", Code::kConflict, {"second", "arm"});
}

/// Before the first cycle nobody knows where an arm is.
void break_beginnings() {
  rcc::ControlCore core{{}};
  expression::Cell cell;
  const auto arm = device::read_arm("models/lwr4plus").value();
  cell.arms["arm"].device =
      &core.add(std::make_unique<device::Arm>("arm", arm, std::make_shared<test::FakeArm>(arm->home), core.period()));
  const RuntimeCommand moved("move", command::arm(cell, "arm"), ptp(arm->home));
  expect_told(plan(moved), "/move", Code::kNotPossibleNow, {"arm"});
}

/// The TX90 knows one mode, and nothing feels on it.
void break_modes() {
  rcc::ControlCore core{{}};
  expression::Cell cell;
  const auto arm = device::read_arm("models/tx90").value();
  cell.arms["arm"].device =
      &core.add(std::make_unique<device::Arm>("arm", arm, std::make_shared<test::FakeArm>(arm->home), core.period()));
  core.step();
  test::CommandRuns runtime(core, cell);
  const auto load = [&](const Action& action) {
    const auto loaded = runtime.load(RuntimeCommand("move", command::arm(cell, "arm"), action));
    return loaded ? Diagnostics() : loaded.error();
  };
  expect_told(load(freedrive(cell, "arm")), "/move", Code::kConflict, {"arm", "C8", "joint_impedance"});
  expect_told(load(with_compliance(hold(), JointCompliance{})), "/move", Code::kInvalidValue,
              {"arm", "joint_impedance"});
}

/// Without plan(): what map() says.
void break_maps() {
  World world;
  const Command unplanned = move(world, ptp(world.joints(0.1)));
  const auto mapped = map(unplanned);
  ASSERT_FALSE(mapped);
  expect_told(mapped.error(), "/move", Code::kRequires);
  // Only of the root of a tree.
  const RuntimeCommand first = driver(world, "first"), after = lamp(world, "after");
  TransactionCommand whole = all_of(first, after);
  whole.on_left(whole.active(), start(after));
  expect_told(check(whole), "/all/handlers/0", Code::kNeverFires);
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
  const std::vector<BrokenCommand> rules = broken_handlers();
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
    std::vector<std::string> names;  // others change with the place in the tree
    if (!rules[i].rule.empty()) names.push_back(rules[i].rule);
    EXPECT_THAT(diagnostics, takt::test::Reports(rules[i].code, place, names));
  }
}

/// What no wrong use comes to, and why.
const std::vector<takt::test::Excuse> kElsewhere = {
    {"actions/motion_action.cc", Code::kRequires, "an arm without inverse kinematics: no model has so few joints"},
    {"expression/condition.cc", Code::kUnknownName, "no shapes here; tests/cell/collisions_test.cc has the case"},
    {"frame_sensors.cc", Code::kUnknownPose, "nothing is lost here; tests/cell/belief_test.cc loses a part"},
    {"actions/joint_jog_action.cc", Code::kOutOfRange, "joint_jog_action_test.cc has the case"},
    {"actions/compliance_action.cc", Code::kConflict, "there is one arm here; two_arms_test.cc has the case"},
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
  EXPECT_THAT(test::unsaid(sites, all_said(), kElsewhere), testing::IsEmpty());
}

}  // namespace
}  // namespace takt::command
