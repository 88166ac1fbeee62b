// Every rule of programs and of the activity layer, broken once: each error has its code, its location and a hint, all
// come at once, and nothing moves. The last test looks through the source for places that no case here comes to.
#include "tests/core/activity/broken_rules.h"

#include <set>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/net/description.h"
#include "core/program/tree/program.h"
#include "tests/core/activity/broken_activities.h"
#include "tests/core/activity/two_arm_cell.h"
#include "tests/support/error_sites.h"
#include "tests/support/reports.h"

namespace takt::activity {
namespace {

using test::BrokenRule;
using test::BrokenRun;
using Json = nlohmann::ordered_json;

/// All that is there to be used wrongly.
class BrokenCell : public test::ActivityCell {
 public:
  BrokenCell() {
    add_net("patient", R"({"name": "patient", "primitives": [
      {"id": "cancel", "type": "Cancel"}, {"id": "end", "type": "Termination"}],
    "links": [{"from": "cancel.requested", "to": "end.condition"}]})");
    add_net("counting", R"({"name": "counting", "primitives": [
      {"id": "count", "type": "CycleCounter", "parameters": {"counted": true, "reset": false}},
      {"id": "end", "type": "Termination", "parameters": {"condition": true}},
      {"id": "counted", "type": "MonitorInteger"}],
    "links": [{"from": "count.count", "to": "counted.value"}]})");
    add_net("no such arm", R"({"name": "no such arm", "primitives": [
      {"id": "state", "type": "ArmState", "parameters": {"device": "amr"}},
      {"id": "end", "type": "Termination", "parameters": {"condition": true}}], "links": []})");
    // Another arm's sensor, known by name.
    cell.sensors["foot"] = cell.sensors.at("wrist");
    cell.sensors["foot"].arm = "other";
  }

  /// Nothing has a net, and nothing was sent anywhere but where it was.
  void expect_untouched() const {
    EXPECT_EQ(core_arm().set_point().q, arm->home);
    for (const auto& sent : backend->sent) EXPECT_TRUE(sent.q == arm->home && sent.dq.isZero());
    EXPECT_TRUE(fingers->written.empty()) << "the gripper moved";
    for (const auto& output : {driver_terminal, lamp_terminal}) {
      for (const bool value : output->written) EXPECT_FALSE(value);
    }
    expect_free();
  }
  void expect_free() const {
    EXPECT_TRUE(core_arm().at_rest());
    EXPECT_FALSE(core_arm().held());
    EXPECT_FALSE(cell.grippers.at("gripper").device->held());
    for (const auto& [name, output] : cell.digital_outputs) EXPECT_FALSE(output->held()) << name;
    EXPECT_FALSE(cell.analog_outputs.at("valve")->held());
  }

 private:
  void add_net(const std::string& name, const std::string& text) {
    auto net = net::net_from_json(Json::parse(text));
    if (!net) ADD_FAILURE() << net.error().to_string();
    if (net) cell.nets[name] = std::make_shared<const net::NetDescription>(std::move(*net));
  }
};

/// What was said in all cases so far, for the look through the source.
std::set<std::string>& all_said() {
  static std::set<std::string> said;
  return said;
}

/// One of the errors is the expected one, and each has a hint.
void expect_told(const Diagnostics& diagnostics, const std::string& place, Code code,
                 const std::vector<std::string>& names = {}) {
  for (const Diagnostic& diagnostic : diagnostics.list()) {
    if (diagnostic.severity != Severity::kError) continue;
    all_said().insert(diagnostic.message);
    EXPECT_FALSE(diagnostic.hint.empty()) << "no hint: " << to_string(diagnostic);
  }
  EXPECT_THAT(diagnostics, takt::test::Reports(code, place, names));
}

std::string whole_place(const BrokenRule& rule, const std::string& node) {
  return rule.place.starts_with("/programs") ? rule.place : node + rule.place;
}

std::vector<BrokenRule> rules_of_form() {
  std::vector<BrokenRule> all;
  for (const auto& some :
       {test::broken_nodes(), test::broken_steps(), test::broken_expressions(), test::broken_transactions()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

std::vector<BrokenRule> rules_of_plans() {
  std::vector<BrokenRule> all = test::broken_plans();
  for (const BrokenRule& rule : test::broken_transaction_plans()) all.push_back(rule);
  return all;
}

Diagnostics parse_errors(const BrokenCell& own, const Json& step, const Json& programs) {
  const auto program = program::Program::parse(step, "/program", own.cell, &programs);
  return program ? Diagnostics() : program.error();
}

void break_forms() {
  BrokenCell own;
  for (const BrokenRule& rule : rules_of_form()) {
    SCOPED_TRACE(rule.step);
    expect_told(parse_errors(own, Json::parse(rule.step), Json::parse(rule.programs)), whole_place(rule, "/program"),
                rule.code, rule.names);
  }
  own.step(10);
  own.expect_untouched();
}

Diagnostics rehearsal_errors(BrokenCell& own, const Json& step) {
  const auto program = program::Program::parse(step, "/program", own.cell);
  if (!program) return program.error();
  return program->rehearse(own.cell, &own.core.environment()).diagnostics;
}

void break_plans() {
  BrokenCell own;
  for (const BrokenRule& rule : rules_of_plans()) {
    SCOPED_TRACE(rule.step);
    expect_told(rehearsal_errors(own, Json::parse(rule.step)), "/program" + rule.place, rule.code, rule.names);
  }
  own.step(10);
  own.expect_untouched();
}

void break_run(const BrokenRun& rule) {
  SCOPED_TRACE(rule.step);
  BrokenCell own;
  const auto program = program::Program::parse(Json::parse(rule.step), "/program", own.cell);
  ASSERT_TRUE(program) << program.error().to_string();
  const Diagnostics rehearsed = program->rehearse(own.cell, &own.core.environment()).diagnostics;
  EXPECT_FALSE(rehearsed.has_errors()) << "only the run can tell: " << rehearsed.to_string();
  Variables variables;
  Context context{own.cell, own.core, variables, 2, [](auto, auto, auto) {}};
  program::ProgramRunner runner(*program, context);
  for (int cycle = 0; cycle < 60'000; ++cycle) {
    if (rule.meanwhile) rule.meanwhile(cycle, own);
    if (runner.advance() != operations::Progress::kRunning) break;
    own.step();
  }
  EXPECT_EQ(runner.progress(), operations::Progress::kFailed);
  expect_told(runner.diagnostics(), "/program" + rule.place, rule.code, rule.names);
  const bool lost = std::exchange(own.backend->silent, false);
  own.step(2'000);
  if (rule.moves) {
    own.expect_free();
  } else if (own.fingers->written.empty()) {
    own.expect_untouched();
  }
  if (!lost) {
    EXPECT_LE(own.worst_limit_share(), 1.0);
  }
}

void break_runs() {
  for (const BrokenRun& rule : test::broken_runs()) break_run(rule);
  for (const BrokenRun& rule : test::broken_transaction_runs()) break_run(rule);
}

Diagnostics thrown_by(const std::function<void()>& wrong) {
  try {
    wrong();
  } catch (const ActivityError& error) {
    return error.diagnostics();
  }
  return {};
}

void break_activities(const std::vector<test::BrokenActivity>& rules) {
  for (const test::BrokenActivity& rule : rules) {
    SCOPED_TRACE(rule.what);
    BrokenCell own;
    expect_told(thrown_by([&] { rule.wrong(own); }), rule.place, rule.code, rule.names);
    own.program.drop_coroutines();
    const bool lost = !std::exchange(own.backend->state().ready, true);
    for (int i = 0; i < (rule.moves ? 3'000 : 20); ++i) own.program.step();
    if (rule.moves) {
      own.expect_free();
    } else {
      own.expect_untouched();
    }
    if (!lost) {
      EXPECT_LE(own.worst_limit_share(), 1.0);
    }
  }
}

void break_uses() { break_activities(test::broken_activities()); }
void break_beliefs() { break_activities(test::broken_beliefs()); }

void break_states() {
  BrokenCell own;
  const auto program = program::Program::parse(
      Json::parse(R"({"do": "sequence", "steps": [{"do": "wait", "name": "here", "seconds": 1}]})"), "/program",
      own.cell);
  ASSERT_TRUE(program);
  Variables variables;
  Context context{own.cell, own.core, variables, 2, [](auto, auto, auto) {}};
  program::ProgramRunner runner(*program, context);
  expect_told(runner.restore(Json::parse("{}")), "", Code::kWrongType);
  Json state = runner.snapshot();
  state["position"] = {{"child", 9}};
  expect_told(runner.restore(state), "/position", Code::kWrongType);
  expect_told(runner.enter("hree"), "", Code::kUnknownName, {"hree", "here"});
}

/// The TX90 knows one mode, and nothing feels on it.
void break_other_arms() {
  rcc::ControlCore core{{}};
  expression::Cell cell;
  const auto arm = device::read_arm("models/tx90").value();
  cell.arms["arm"].device =
      &core.add(std::make_unique<device::Arm>("arm", arm, std::make_shared<test::FakeArm>(arm->home), core.period()));
  const auto program =
      program::Program::parse(Json::parse(R"({"do": "control_mode", "mode": "joint_impedance"})"), "/program", cell);
  ASSERT_TRUE(program);
  expect_told(program->rehearse(cell).diagnostics, "/program/mode", Code::kUnknownName, {"arm", "joint_impedance"});
  const auto guided = program::Program::parse(Json::parse(R"({"do": "freedrive", "seconds": 1})"), "/program", cell);
  ASSERT_TRUE(guided);
  expect_told(guided->rehearse(cell).diagnostics, "/program", Code::kConflict, {"arm", "C8", "joint_impedance"});
}

/// From one mode to another there may be no way but by a third.
void break_ways() {
  rcc::ControlCore core{{}};
  expression::Cell cell;
  const auto arm = std::make_shared<const device::ArmDescription>(test::compliant_arm_description(7));
  const auto backend = std::make_shared<test::FakeArm>(arm->home);
  cell.arms["arm"].device = &core.add(std::make_unique<device::Arm>("arm", arm, backend, core.period()));
  Runtime program(core, cell, [&core] { core.step(); });
  core.step();
  const auto modes = app::Actuator(program, "arm").use<app::ControlModeInterface>();
  expect_told(thrown_by([&] { modes.switch_to("cartesian_impedance").execute(); }), "/arm cartesian_impedance/mode",
              Code::kUnsupported, {"arm", "cartesian_impedance", "joint_impedance"});
  EXPECT_EQ(backend->changes, 0);
}

void break_modes() {
  break_activities(test::broken_modes());
  break_other_arms();
  break_ways();
}

void break_pairs() {
  test::TwoArmCell two;
  const app::TwoArms both = two.pair();
  const operations::MotionParameters guarded{
      .until = is_greater(internal_force(two.cell, "left wrist", "right wrist"), 20.0)};
  const auto up = [&](const operations::MotionParameters& wish) { return both.lin_by({0, 0, 0.05}, wish); };
  expect_told(thrown_by([&] { up({.blend = 0.2}).execute(); }), "/left+right LIN/blend", Code::kOutOfRange,
              {"0.2", "0.5"});
  expect_told(thrown_by([&] {
                sequence({up(guarded), up({})}).execute();
              }),
              "/left+right LIN, left+right LIN/1", Code::kUnknownPosition);
  const app::Actuator left(two.program, "left");
  expect_told(thrown_by([&] { app::TwoArms(left, left, both.centre()); }), "/follower", Code::kConflict, {"left"});
  Runtime other(two.core, two.cell, [&two] { two.core.step(); });
  expect_told(thrown_by([&] { app::TwoArms(left, app::Actuator(other, "right"), both.centre()); }), "/follower",
              Code::kRequires, {"right", "left"});
  const auto several = program::Program::parse(Json::parse(R"({"do": "transaction", "commands": {"m": {"do": "motions",
      "start": true, "steps": [{"do": "ptp", "arm": "left", "to": "home", "blend_m": 0.1},
                               {"do": "ptp", "arm": "right", "to": "home"}]}}})"),
                                               "/program", two.cell);
  ASSERT_FALSE(several);
  expect_told(several.error(), "/program/commands/m/steps/1/arm", Code::kConflict, {"right", "left"});
  for (const auto& [name, backend] : two.backends) {
    for (const auto& sent : backend->sent) EXPECT_EQ(sent.q, two.arm->home) << name;
  }
  left.use<app::LinInterface>().lin_by({0, 0, 0.01}).execute();
  expect_told(thrown_by([&] { up({}).execute(); }), "/left+right LIN/grasp", Code::kUnknownPosition, {"10", "TwoArms"});
  for (const auto& [name, mounted] : two.cell.arms) {
    EXPECT_FALSE(mounted.device->held()) << name;
    EXPECT_TRUE(mounted.device->at_rest()) << name;
  }
}

/// Steps of two arms: what is refused when they are read, or rehearsed.
void break_pair_steps() {
  test::TwoArmCell two;
  const auto told = [&two](const std::string& step, const std::string& place, Code code,
                           const std::vector<std::string>& names = {}) {
    SCOPED_TRACE(step);
    const auto program = program::Program::parse(Json::parse(step), "/program", two.cell);
    expect_told(program ? program->rehearse(two.cell, &two.core.environment()).diagnostics : program.error(),
                "/program" + place, code, names);
  };
  const auto both = [](const std::string& keys, const std::string& kind = "lin") {
    return R"({"do": ")" + kind + R"(", "arm": "left", "to": {"by_m": [0, 0, 0.05]}, )" + keys + "}";
  };
  const std::string follows = R"("follower": "right")";
  const std::string none_is_felt = R"({"internal_force": ["left wrist", "third wrist"], "above_N": 40})";
  two.cell.sensors["third wrist"] = two.cell.sensors.at("left wrist");
  two.cell.sensors["third wrist"].arm = "third";
  told(both(R"("follower": "left")"), "/follower", Code::kConflict, {"left"});
  told(both(R"("follower": "rihgt")"), "/follower", Code::kUnknownName, {"rihgt", "right"});
  told(both(R"("follower": "left wrist")"), "/follower", Code::kUnknownName, {"left wrist"});
  told(both(R"("follower": 5)"), "/follower", Code::kWrongType, {"5"});
  told(both(follows + R"(, "compliance": {"mode": "joint_impedance"})"), "/compliance", Code::kNotPossibleNow,
       {"right", "control_mode", "joint_impedance"});
  told(both(follows + R"(, "compliance": {"mode": "joint_impedance", "torque_Nm": [1, 0, 0, 0, 0, 0, 0]})"),
       "/compliance/torque_Nm", Code::kConflict);
  told(both(follows + R"(, "compliance": {"mode": "cartesian_impedance", "stiffness_N_m": 6000})"),
       "/compliance/stiffness_N_m/0", Code::kOutOfRange, {"right", "6000", "0", "5000"});
  told(both(follows, "ptp"), "/follower", Code::kConflict);
  told(R"({"do": "spline", "arm": "left", "through": ["home", "home"], "follower": "right"})", "/follower",
       Code::kConflict);
  told(both(follows + R"(, "abort_if": )" + none_is_felt), "/abort_if", Code::kConflict,
       {"third wrist", "third", "left", "right"});
  told(both(follows + R"(, "until": {"any": [{"sensor": "left wrist", "above_N": 5}, )" + none_is_felt + "]}"),
       "/until", Code::kConflict, {"third wrist", "left", "right"});
  const std::string weave = R"(, "weave": {"amplitude_m": 0.001, "frequency_Hz": 2})";
  told(both(follows + weave), "/follower", Code::kConflict);
  const auto tree = [](const std::string& command) {
    return R"({"do": "transaction", "commands": {"m": )" + command + "}}";
  };
  const auto several = [&](const std::string& steps, const std::string& more = "") {
    return tree(R"({"do": "motions", "start": true, "steps": [)" + steps + "]" + more + "}");
  };
  const std::string blend = R"(, "blend_m": 0.01)", alone = R"("velocity_m_s": 0.1)";
  told(tree(both(follows + weave + R"(, "start": true)")), "/commands/m/follower", Code::kConflict);
  told(tree(both(follows + blend + R"(, "start": true)")), "/commands/m", Code::kConflict, {"m"});
  told(several(both(alone + blend) + "," + both(follows)), "/commands/m/steps/1/follower", Code::kConflict,
       {"left", "right", "follower"});
  told(several(both(follows + blend) + "," + both(alone)), "/commands/m/steps/1", Code::kConflict,
       {"left", "right", "follower"});
  told(several(both(follows), R"(, "compliance": {"mode": "joint_impedance"})"), "/commands/m/compliance",
       Code::kNotPossibleNow, {"right", "control_mode", "joint_impedance"});
  told(several(both(follows), R"(, "compliance": {"mode": "cartesian_impedance", "force_N": [0, 0, 5]})"),
       "/commands/m/compliance/force_N", Code::kConflict);
  told(both(follows + R"(, "base_to": "home")"), "/follower", Code::kConflict, {"follower"});
  told(both(R"("blend_m": 0.01, "base_to": "home")"), "/blend_m", Code::kConflict, {"blend_m"});
  told(R"({"do": "lin", "arm": "left", "to": {"by_m": [0, 0, 3]}, )" + follows + "}", "/to", Code::kUnreachable);
  told(R"({"do": "lin", "arm": "left", "to": {"by_m": [-0.1, 0.55, 0]}, )" + follows + "}", "/follower",
       Code::kUnreachable);
  const Eigen::Isometry3d X_WB = *two.cell.frames.pose("right");
  ASSERT_FALSE(
      two.cell.frames
          .set("right",
               world::Relation{
                   .kind = world::Relation::Kind::kChannel, .parent = "world", .X_PF = X_WB, .source = "where it is"})
          .has_errors());
  told(both(follows), "/follower", Code::kUnknownPosition, {"right", "left"});
  for (int i = 0; i < 10; ++i) two.core.step();
  for (const auto& [name, backend] : two.backends) {
    for (const auto& sent : backend->sent) EXPECT_EQ(sent.q, two.arm->home) << name;
  }
}

void once(void (*table)()) {
  static std::set<void (*)()> done;
  if (done.insert(table).second) table();
}

TEST(RulesBrokenOnce, OfForm) { once(break_forms); }
TEST(RulesBrokenOnce, OfPlans) { once(break_plans); }
TEST(RulesBrokenOnce, InTheRun) { once(break_runs); }
TEST(RulesBrokenOnce, OfActivities) { once(break_uses); }
TEST(RulesBrokenOnce, OfTwoArms) { once(break_pairs); }
TEST(RulesBrokenOnce, OfStepsOfTwoArms) { once(break_pair_steps); }
TEST(RulesBrokenOnce, OfStatesAndNames) { once(break_states); }
TEST(RulesBrokenOnce, OfBeliefs) { once(break_beliefs); }
TEST(RulesBrokenOnce, OfModes) { once(break_modes); }

// One program with all of it: each is told, none hides another.
TEST(RulesBrokenOnce, AllOfThemAtOnce) {
  BrokenCell own;
  Json steps = Json::array(), programs = Json::object();
  std::vector<BrokenRule> rules;
  for (const BrokenRule& rule : rules_of_form()) {
    const Json known = Json::parse(rule.programs);
    if (!known.is_object()) continue;
    for (const auto& [name, program] : known.items()) programs[name] = program;
    steps.push_back(Json::parse(rule.step));
    rules.push_back(rule);
  }
  const Diagnostics diagnostics = parse_errors(own, {{"do", "sequence"}, {"steps", steps}}, programs);
  for (std::size_t i = 0; i < rules.size(); ++i) {
    const std::string place = whole_place(rules[i], "/program/steps/" + std::to_string(i));
    EXPECT_THAT(diagnostics, takt::test::Reports(rules[i].code, place, rules[i].names));
  }
  Json plans = Json::array();
  for (const BrokenRule& rule : rules_of_plans()) plans.push_back(Json::parse(rule.step));
  const Diagnostics planned = rehearsal_errors(own, {{"do", "sequence"}, {"steps", plans}});
  for (std::size_t i = 0; i < plans.size(); ++i) {
    const std::string place = "/program/steps/" + std::to_string(i) + rules_of_plans()[i].place;
    EXPECT_TRUE(std::ranges::any_of(planned.list(), [&](const Diagnostic& found) { return found.pointer == place; }))
        << place << "\n"
        << planned.to_string();
  }
}

/// What no wrong use comes to, and why.
const std::vector<takt::test::Excuse> kElsewhere = {
    {"activity/scheduler.cc", Code::kNotPossibleNow,
     "a full queue of requests: nothing reads the queue then; a test of ActivityRunTest fills it"},
    {"activity/composition.cc", Code::kConditionNotMet, "of a part without words of its own: all parts have some"},
    {"activity/command_activity.cc", Code::kConditionNotMet, "CompositionVerdict.ACommandFailsByAStateOfItsOwn"},
    {"operations/online/look_at.cc", Code::kConflict, "LookAtTest.WhatRidesOnTheArmItselfIsRefused"},
    {"operations/online/look_at.cc", Code::kUnreachable, "LookAtTest.OrItFails"},
    {"operations/table/operation.cc", Code::kMissing, "of a plug-in: Operations.ARegistrationIsChecked"},
    {"operations/table/operation.cc", Code::kDuplicate, "of a plug-in: Operations.ARegistrationIsChecked"},
    {"app/interfaces/operation_by_name.cc", Code::kUnknownName, "of programs that name operations: OperationByName"},
    {"app/interfaces/operation_by_name.cc", Code::kUnsupported, "likewise"},
    {"app/interfaces/operation_by_name.cc", Code::kInvalidValue, "likewise"},
    {"app/interfaces/actuator_interfaces.cc", Code::kNotKnownYet,
     "only before the first cycle, in which no program has begun"},
    {"operations/motion/motion_plan.cc", Code::kConflict, "an arm of fewer than three joints: no model has so few"},
    {"operations/table/compliance.cc", Code::kConflict, "all models with such springs have as many joints"},
    {"language/expression.cc", Code::kTooLarge, "grows in a loop: ExpressionTest.WhatGrowsInALoopIsBounded"},
    {"language/expression_functions.cc", {}, "grows in a loop: ExpressionTest.WhatGrowsInALoopIsBounded"},
    {"base/object_reader.cc", Code::kUnknownKey, "so many keys: ObjectReader.UnknownKeysAreCountedBeyondABound"},
    {"operations/table/parameter.cc", Code::kUnknownName, "no tools here: Tools.ThatAreNotThereAreErrorsAtTheirKey"},
    {"operations/command/command_step.cc", Code::kConflict, "no tools here: Tools.OneForAnArmInATransaction"},
    {"operations/motion/motion_command.cc", Code::kConflict, "no tools here: Tools.OneForAnArmInATransaction"},
    {"operations/grasp/set_frame.cc", Code::kInvalidName, "BelievedFrames.AStepMakesThemAndTheyDependOnWhatItSays"},
    {"operations/grasp/couple.cc", Code::kConditionNotMet, "no tool sides here: ToolChanges has the cases"},
    {"operations/grasp/couple.cc", Code::kSensorSilent, "likewise"},
    {"operations/grasp/couple.cc", Code::kTimeout, "likewise"},
    {"operations/grasp/couple.cc", Code::kConflict, "likewise"},
    {"operations/grasp/couple.cc", Code::kUnknownName, "likewise"},
    {"operations/grasp/couple.cc", Code::kLimitExceeded, "likewise"},
    {"operations/table/tool_choice.cc", Code::kNotPossibleNow, "likewise"},
    {"operations/grasp/grip.cc", Code::kNotPossibleNow, "likewise"},
    {"program/tree/sequence_node.cc", Code::kConflict, "BlockFramesTest.AreTheirSequencesOwn"},
    {"program/tree/node_parser.cc", Code::kInvalidName, "BlockFramesTest.AreTheirSequencesOwn"},
    {"program/tree/node_parser.cc", Code::kDuplicate, "BlockFramesTest.AreTheirSequencesOwn"},
    {"program/tree/parallel_node.cc", Code::kDuplicate, "BlockFramesTest.AreTheirSequencesOwn"},
    {"operations/grasp/held_part.cc", Code::kConflict, "no fixed part here: tests/cell/belief_test.cc has the case"},
    {"operations/grasp/held_part.cc", Code::kUnknownName, "no grasps here: AttachedParts.WhatCannotBeHeldIsReported"},
    {"operations/grasp/attach.cc", Code::kMissing, "no tools here: AttachedParts.WhatCannotBeHeldIsReported"},
    {"operations/motion/move_plan.cc", Code::kCollision, "no shapes here: tests/cell/move_test.cc has the cases"},
    {"operations/motion/move_plan.cc", Code::kPlanningFailed, "no shapes here: tests/cell/move_test.cc has the case"},
    {"activity/planning_job.cc", Code::kInternal, "an exception of a planner: PlanningThreadTest"},
};

// A place of the source that says what is wrong has a case above. Whoever adds one adds a case.
TEST(RulesBrokenOnce, EveryPlaceInTheSourceHasACase) {
  for (const auto table : {break_forms, break_plans, break_runs, break_uses, break_beliefs, break_pairs,
                           break_pair_steps, break_states, break_modes})
    once(table);
  std::vector<test::ErrorSite> sites;
  for (const char* folder :
       {"core/activity", "core/operations/review", "core/operations/table", "core/operations/command",
        "core/operations/motion", "core/operations/grasp", "core/operations/online", "core/operations/force",
        "core/operations/basic", "app/interfaces", "core/program/language", "core/program/tree"})
    std::ranges::copy(test::error_sites(folder), std::back_inserter(sites));
  for (const test::ErrorSite& site : test::error_sites("core/base")) {
    if (site.file.ends_with("object_reader.cc") || site.file.ends_with("read_parts.cc")) sites.push_back(site);
  }
  ASSERT_GT(sites.size(), 100u) << "the look through the source finds nothing any more";
  EXPECT_THAT(test::unsaid(sites, all_said(), kElsewhere), testing::IsEmpty());
}

}  // namespace
}  // namespace takt::activity
