// Every rule of programs and of the activity layer, broken once: what is wrong, where, and the way out are said, all at
// once, and nothing moves. The last test looks through the source for places that no case here comes to.
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

/// One of the diagnostics is the one that is expected; each has a place and a way out.
void expect_told(const Diagnostics& diagnostics, const std::string& place, const std::string& message,
                 const std::string& way_out) {
  bool told = false;
  for (const Diagnostic& diagnostic : diagnostics.list()) {
    if (diagnostic.severity != Severity::kError) continue;
    all_said().insert(diagnostic.message);
    EXPECT_FALSE(diagnostic.hint.empty()) << "no way out: " << to_string(diagnostic);
    told = told || (diagnostic.pointer == place && diagnostic.message.find(message) != std::string::npos &&
                    diagnostic.hint.find(way_out) != std::string::npos);
  }
  EXPECT_TRUE(told) << "expected " << place << ": " << message << " (" << way_out << "), found\n"
                    << diagnostics.to_string();
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
  const auto program = Program::parse(step, "/program", own.cell, &programs);
  return program ? Diagnostics() : program.error();
}

void break_forms() {
  BrokenCell own;
  for (const BrokenRule& rule : rules_of_form()) {
    SCOPED_TRACE(rule.step);
    expect_told(parse_errors(own, Json::parse(rule.step), Json::parse(rule.programs)), whole_place(rule, "/program"),
                rule.message, rule.way_out);
  }
  own.step(10);
  own.expect_untouched();
}

Diagnostics rehearsal_errors(BrokenCell& own, const Json& step) {
  const auto program = Program::parse(step, "/program", own.cell);
  if (!program) return program.error();
  return program->rehearse(own.cell, &own.core.environment()).diagnostics;
}

void break_plans() {
  BrokenCell own;
  for (const BrokenRule& rule : rules_of_plans()) {
    SCOPED_TRACE(rule.step);
    expect_told(rehearsal_errors(own, Json::parse(rule.step)), "/program" + rule.place, rule.message, rule.way_out);
  }
  own.step(10);
  own.expect_untouched();
}

void break_run(const BrokenRun& rule) {
  SCOPED_TRACE(rule.step);
  BrokenCell own;
  const auto program = Program::parse(Json::parse(rule.step), "/program", own.cell);
  ASSERT_TRUE(program) << program.error().to_string();
  const Diagnostics rehearsed = program->rehearse(own.cell, &own.core.environment()).diagnostics;
  EXPECT_FALSE(rehearsed.has_errors()) << "only the run can tell: " << rehearsed.to_string();
  Variables variables;
  Context context{own.cell, own.core, variables, 2, [](auto, auto, auto) {}};
  ProgramRunner runner(*program, context);
  for (int cycle = 0; cycle < 60'000; ++cycle) {
    if (rule.meanwhile) rule.meanwhile(cycle, own);
    if (runner.advance() != Progress::kRunning) break;
    own.step();
  }
  EXPECT_EQ(runner.progress(), Progress::kFailed);
  expect_told(runner.diagnostics(), "/program" + rule.place, rule.message, rule.way_out);
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
    expect_told(thrown_by([&] { rule.wrong(own); }), rule.place, rule.message, rule.way_out);
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

void break_states() {
  BrokenCell own;
  const auto program =
      Program::parse(Json::parse(R"({"do": "sequence", "steps": [{"do": "wait", "name": "here", "seconds": 1}]})"),
                     "/program", own.cell);
  ASSERT_TRUE(program);
  Variables variables;
  Context context{own.cell, own.core, variables, 2, [](auto, auto, auto) {}};
  ProgramRunner runner(*program, context);
  expect_told(runner.restore(Json::parse("{}")), "", "this is not a state of this program", "what snapshot() gave");
  Json state = runner.snapshot();
  state["position"] = {{"child", 9}};
  expect_told(runner.restore(state), "/position", "this is not a state of this program", "what snapshot() gave");
  expect_told(runner.enter("hree"), "", "no step 'hree' can be entered", "did you mean 'here'?");
}

/// The TX90 knows one mode, and nothing feels on it.
void break_other_arms() {
  rcc::ControlCore core{{}};
  command::Cell cell;
  const auto arm = device::read_arm("models/tx90").value();
  cell.arms["arm"].device =
      &core.add(std::make_unique<device::Arm>("arm", arm, std::make_shared<test::FakeArm>(arm->home), core.period()));
  const auto program =
      Program::parse(Json::parse(R"({"do": "control_mode", "mode": "joint_impedance"})"), "/program", cell);
  ASSERT_TRUE(program);
  expect_told(program->rehearse(cell).diagnostics, "/program/mode", "'arm' has no mode 'joint_impedance'", "position");
  const auto guided = Program::parse(Json::parse(R"({"do": "freedrive", "seconds": 1})"), "/program", cell);
  ASSERT_TRUE(guided);
  expect_told(guided->rehearse(cell).diagnostics, "/program", "C8: 'arm' cannot be guided by hand",
              "the mode joint_impedance");
}

/// From one mode to another there may be no way but by a third.
void break_ways() {
  rcc::ControlCore core{{}};
  command::Cell cell;
  const auto arm = std::make_shared<const device::ArmDescription>(test::compliant_arm_description(7));
  const auto backend = std::make_shared<test::FakeArm>(arm->home);
  cell.arms["arm"].device = &core.add(std::make_unique<device::Arm>("arm", arm, backend, core.period()));
  Runtime program(core, cell, [&core] { core.step(); });
  core.step();
  const auto modes = Actuator(program, "arm").use<ControlModeInterface>();
  expect_told(thrown_by([&] { modes.switch_to("cartesian_impedance").execute(); }), "/arm cartesian_impedance/mode",
              "'arm' cannot go from position to cartesian_impedance", "from there to joint_impedance");
  EXPECT_EQ(backend->changes, 0);
}

void break_modes() {
  break_activities(test::broken_modes());
  break_other_arms();
  break_ways();
}

void break_pairs() {
  test::TwoArmCell two;
  const TwoArms both = two.pair();
  const MotionParameters guarded{.until = is_greater(internal_force(two.cell, "left wrist", "right wrist"), 20.0)};
  const auto up = [&](const MotionParameters& wish) { return both.lin_by({0, 0, 0.05}, wish); };
  expect_told(thrown_by([&] { up({.blend = 0.2}).execute(); }), "/left+right LIN/blend", "a blend at a share of 0.2",
              "at least 0.5");
  expect_told(thrown_by([&] {
                sequence({up(guarded), up({})}).execute();
              }),
              "/left+right LIN, left+right LIN/1", "the end position of the arms is unknown before the run",
              "after the end");
  const Actuator left(two.program, "left");
  expect_told(thrown_by([&] { TwoArms(left, left, both.centre()); }), "/follower", "'left' is the leader too",
              "two arms");
  Runtime other(two.core, two.cell, [&two] { two.core.step(); });
  expect_told(thrown_by([&] { TwoArms(left, Actuator(other, "right"), both.centre()); }), "/follower",
              "'right' belongs to another runtime than 'left'", "arms of one Runtime");
  const auto several = Program::parse(Json::parse(R"({"do": "transaction", "commands": {"m": {"do": "motions",
      "start": true, "steps": [{"do": "ptp", "arm": "left", "to": "home", "blend_m": 0.1},
                               {"do": "ptp", "arm": "right", "to": "home"}]}}})"),
                                      "/program", two.cell);
  ASSERT_FALSE(several);
  expect_told(several.error(), "/program/commands/m/steps/1/arm", "'right' after 'left'", "one arm for all of them");
  for (const auto& [name, backend] : two.backends) {
    for (const auto& sent : backend->sent) EXPECT_EQ(sent.q, two.arm->home) << name;
  }
  left.use<LinInterface>().lin_by({0, 0, 0.01}).execute();
  expect_told(thrown_by([&] { up({}).execute(); }), "/left+right LIN/grasp",
              "the arms disagree about the motion centre by 10 mm", "TwoArms anew");
  for (const auto& [name, mounted] : two.cell.arms) {
    EXPECT_FALSE(mounted.device->held()) << name;
    EXPECT_TRUE(mounted.device->at_rest()) << name;
  }
}

/// Steps of two arms: what is refused when they are read, or rehearsed.
void break_pair_steps() {
  test::TwoArmCell two;
  const auto told = [&two](const std::string& step, const std::string& place, const std::string& message,
                           const std::string& way_out) {
    SCOPED_TRACE(step);
    const auto program = Program::parse(Json::parse(step), "/program", two.cell);
    expect_told(program ? program->rehearse(two.cell, &two.core.environment()).diagnostics : program.error(),
                "/program" + place, message, way_out);
  };
  const auto both = [](const std::string& keys, const std::string& kind = "lin") {
    return R"({"do": ")" + kind + R"(", "arm": "left", "to": {"by_m": [0, 0, 0.05]}, )" + keys + "}";
  };
  const std::string follows = R"("follower": "right")";
  const std::string none_is_felt = R"({"internal_force": ["left wrist", "third wrist"], "above_N": 40})";
  two.cell.sensors["third wrist"] = two.cell.sensors.at("left wrist");
  two.cell.sensors["third wrist"].arm = "third";
  told(both(R"("follower": "left")"), "/follower", "'left' leads already", "another arm");
  told(both(R"("follower": "rihgt")"), "/follower", "unknown value 'rihgt'", "did you mean 'right'?");
  told(both(R"("follower": "left wrist")"), "/follower", "unknown value 'left wrist'", "allowed: left, right");
  told(both(R"("follower": 5)"), "/follower", "unexpected value 5", "a text");
  told(both(follows + R"(, "compliance": {"mode": "joint_impedance"})"), "/compliance",
       "'right' will be in mode position, and this needs joint_impedance", "the step \"control_mode\"");
  told(both(follows + R"(, "compliance": {"mode": "joint_impedance", "torque_Nm": [1, 0, 0, 0, 0, 0, 0]})"),
       "/compliance/torque_Nm", "two arms that move as one have stiffness only, no force", "a motion of one arm");
  told(both(follows + R"(, "compliance": {"mode": "cartesian_impedance", "stiffness_N_m": 6000})"),
       "/compliance/stiffness_N_m/0", "6000 N/m for 'right'", "0 to 5000");
  told(both(follows, "ptp"), "/follower", "two arms move as one only on the path of a frame", "lin or circ");
  told(R"({"do": "spline", "arm": "left", "through": ["home", "home"], "follower": "right"})", "/follower",
       "two arms move as one only on the path of a frame", "lin or circ");
  told(both(follows + R"(, "abort_if": )" + none_is_felt), "/abort_if",
       "an internal force that 'third wrist' feels, which is on 'third'", "sensors of 'left' and 'right'");
  told(both(follows + R"(, "until": {"any": [{"sensor": "left wrist", "above_N": 5}, )" + none_is_felt + "]}"),
       "/until", "an internal force that 'third wrist' feels", "sensors of 'left' and 'right'");
  const std::string weave = R"(, "weave": {"amplitude_m": 0.001, "frequency_Hz": 2})";
  const std::string laid_over = "two arms as one with a weave or a force offset";
  told(both(follows + weave), "/follower", laid_over, "one arm, or a plain motion");
  const auto tree = [](const std::string& command) {
    return R"({"do": "transaction", "commands": {"m": )" + command + "}}";
  };
  const auto several = [&](const std::string& steps, const std::string& more = "") {
    return tree(R"({"do": "motions", "start": true, "steps": [)" + steps + "]" + more + "}");
  };
  const std::string blend = R"(, "blend_m": 0.01)", alone = R"("velocity_m_s": 0.1)";
  told(tree(both(follows + weave + R"(, "start": true)")), "/commands/m/follower", laid_over, "one arm");
  told(tree(both(follows + blend + R"(, "start": true)")), "/commands/m",
       "'m' cannot be left for the motion after the transaction", "a plain motion");
  told(several(both(alone + blend) + "," + both(follows)), "/commands/m/steps/1/follower",
       "'left' and 'right' as one after 'left' alone", "the same 'follower' at all of them");
  told(several(both(follows + blend) + "," + both(alone)), "/commands/m/steps/1",
       "'left' alone after 'left' and 'right' as one", "the same 'follower' at all of them");
  told(several(both(follows), R"(, "compliance": {"mode": "joint_impedance"})"), "/commands/m/compliance",
       "'right' will be in mode position, and this needs joint_impedance", "the step \"control_mode\"");
  told(several(both(follows), R"(, "compliance": {"mode": "cartesian_impedance", "force_N": [0, 0, 5]})"),
       "/commands/m/compliance/force_N", "two arms that move as one have stiffness only, no force",
       "a motion of one arm");
  told(both(follows + R"(, "base_to": "home")"), "/follower", "a motion with a base has no 'follower'", "two motions");
  told(both(R"("blend_m": 0.01, "base_to": "home")"), "/blend_m", "a motion with a base has no 'blend_m'",
       "two motions");
  told(R"({"do": "lin", "arm": "left", "to": {"by_m": [0, 0, 3]}, )" + follows + "}", "/to", "the goal is out of reach",
       "a goal nearer to the base");
  told(R"({"do": "lin", "arm": "left", "to": {"by_m": [-0.1, 0.55, 0]}, )" + follows + "}", "/follower",
       "the goal is out of reach", "a goal nearer to the base");
  const Eigen::Isometry3d X_WB = *two.cell.frames.pose("right");
  ASSERT_FALSE(
      two.cell.frames
          .set("right",
               world::Relation{
                   .kind = world::Relation::Kind::kChannel, .parent = "world", .X_PF = X_WB, .source = "where it is"})
          .has_errors());
  told(both(follows), "/follower", "where 'right' stands to 'left' changes while bases drive", "on one base");
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
    EXPECT_TRUE(std::ranges::any_of(diagnostics.list(),
                                    [&](const Diagnostic& diagnostic) {
                                      return diagnostic.pointer == place &&
                                             diagnostic.message.find(rules[i].message) != std::string::npos;
                                    }))
        << place << ": " << rules[i].message;
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
const std::vector<std::pair<std::string, std::string>> kElsewhere = {
    {"'{}' was not started: the control core's queue of requests was full",
     "nothing reads the queue then: a test of ActivityRunTest fills it"},
    {"the condition held, but the arm's position was not known", "the condition is null then: the case before it"},
    {"an operation has no name", "of a plug-in: Operations.ARegistrationIsChecked"},
    {"an operation '{}' already exists", "of a plug-in: Operations.ARegistrationIsChecked"},
    {"operation '{}' is incomplete", "of a plug-in: Operations.ARegistrationIsChecked"},
    {"'{}' has not measured yet", "only before the first cycle, in which no program has begun"},
    {"a list of more than 100 000 elements", "takes minutes to fill, one by one"},
    {"a text of {} bytes", "grows in a loop: ExpressionTest.WhatGrowsInALoopIsBounded"},
    {"a list with more than {} bytes of text", "grows in a loop: ExpressionTest.WhatGrowsInALoopIsBounded"},
    {"{} more unknown keys", "nobody writes so many: ObjectReader.UnknownKeysAreCountedBeyondABound"},
    {"an arm of fewer than three joints follows no line", "no model has so few"},
    {"joint stiffness of '{}' and '{}'", "all models with such springs have as many joints"},
    {"a sensor in `abort_if` did not answer", "followed_run_test.cc has the case: it shows while the activity runs"},
    {"`abort_if` became true", "followed_run_test.cc has the case"},
    {"'{}': the end position of the arm is unknown before the run",
     "steps wait for the end of what moved their arm before"},
    {"planning of '{}' ended with: {}", "an exception of a planner: PlanningThreadTest"},
};

// A place of the source that says what is wrong has a case above. Whoever adds one adds a case.
TEST(RulesBrokenOnce, EveryPlaceInTheSourceHasACase) {
  for (const auto table :
       {break_forms, break_plans, break_runs, break_uses, break_pairs, break_pair_steps, break_states, break_modes})
    once(table);
  std::vector<test::ErrorSite> sites;
  for (const char* folder : {"core/activity", "core/operations", "core/program/language", "core/program/tree"})
    std::ranges::copy(test::error_sites(folder), std::back_inserter(sites));
  for (const test::ErrorSite& site : test::error_sites("core/base")) {
    if (site.place.find("object_reader") != std::string::npos || site.place.find("read_parts") != std::string::npos)
      sites.push_back(site);
  }
  ASSERT_GT(sites.size(), 100u) << "the look through the source finds nothing any more";
  for (const test::ErrorSite& site : sites) {
    const bool elsewhere = std::ranges::any_of(
        kElsewhere, [&](const auto& one) { return site.message.find(one.first) != std::string::npos; });
    const bool said = std::ranges::any_of(all_said(), [&](const std::string& text) { return test::says(site, text); });
    EXPECT_NE(said, elsewhere) << site.place << " says \"" << site.message
                               << (said ? "\": it is not elsewhere" : "\": no case breaks this rule");
  }
}

}  // namespace
}  // namespace takt::activity
