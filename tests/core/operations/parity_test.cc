// What exists in a file exists in C++ and comes to the same net, and is refused with the same diagnostics.
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/interfaces/actuator_interfaces.h"
#include "core/command/mapping.h"
#include "core/operations/basic/set.h"
#include "core/operations/command/command_builder.h"
#include "core/operations/force/press.h"
#include "core/operations/force/search.h"
#include "core/operations/force/wipe.h"
#include "core/operations/grasp/grip.h"
#include "core/operations/motion/motion.h"
#include "core/operations/online/control_mode.h"
#include "core/operations/online/follow.h"
#include "core/operations/online/freedrive.h"
#include "core/operations/online/hold.h"
#include "core/operations/online/jog.h"
#include "core/operations/online/look_at.h"
#include "tests/core/command/command_cell.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;

using Json = nlohmann::ordered_json;
using Made = Result<std::unique_ptr<OperationCommand>>;

/// Parameters of a program, as its interfaces take them.
template <class P>
std::function<Made(const expression::Cell&)> program(const ParameterTable<P>& (*table)(),
                                                     std::unique_ptr<OperationCommand> (*make)(const P&),
                                                     const P& parameters) {
  return [=](const expression::Cell& cell) -> Made {
    auto accepted = table().accept(parameters, cell);
    if (!accepted) return std::unexpected(accepted.error());
    return make(*accepted);
  };
}

/// The same in a file and in C++.
struct Pair {
  const char* operation;
  std::string file;
  std::function<Made(const expression::Cell&)> in_cpp;
};

/// @param p_B  of the tool, m
std::vector<Pair> good_pairs(const Eigen::Vector3d& p_B) {
  expression::Condition button;
  button.kind = expression::Condition::Kind::kDigital;
  button.device = "button";
  const Eigen::Vector3d down(0, 0, -1);
  return {
      {"press", R"({"direction": [0, 0, -1], "in": "world", "force_N": 12, "travel_m": 0.03, "seconds": 0.5})",
       program(press_parameters, press_command,
               {.direction = down, .in = "world", .force = 12.0, .travel = 0.03, .seconds = 0.5})},
      {"search", R"({"force_N": 8, "radius_m": 0.01, "pitch_m": 0.004, "drop_m": 0.003, "on_end": "continue"})",
       program(search_parameters, search_command,
               {.force = 8.0, .radius = 0.01, .pitch = 0.004, .drop = 0.003, .must_find = false})},
      {"wipe",
       fmt::format(R"({{"in": "arm", "centre_m": [{}, {}, {}], "length_m": 0.04, "width_m": 0.02, "pitch_m": 0.01}})",
                   p_B.x(), p_B.y(), p_B.z()),
       program(wipe_parameters, wipe_command,
               {.in = "arm", .centre = p_B, .length = 0.04, .width = 0.02, .pitch = 0.01})},
      {"hold", R"({"seconds": 0.25, "until": {"input": "button", "is": true}, "abort_if": {"input": "button"}})",
       program(hold_parameters, hold_command, {.seconds = 0.25, .until = button, .abort_if = button})},
      {"jog", R"({"while": {"input": "button", "is": true}, "linear_m_s": [0.1, 0, 0], "linear_max_m_s": 0.05})",
       program(jog_parameters, jog_command,
               {.enabled = button, .linear = Eigen::Vector3d(0.1, 0, 0), .linear_max = 0.05})},
      {"look_at", R"({"at": "block", "distance_m": 0.4, "on_unreachable": "fail", "seconds": 2})",
       program(look_at_parameters, look_at_command,
               {.at = "block", .distance = 0.4, .must_reach = true, .seconds = 2.0})},
      {"follow", R"({"channel": "target", "linear_max_m_s": 0.2, "seconds": 2})",
       program(follow_parameters, follow_command, {.channel = "target", .linear_max = 0.2, .seconds = 2.0})},
      {"grip", R"({"width_m": 0.02, "force_N": 20, "expect": "any"})",
       program(grip_parameters, close_command, {.width = 0.02, .force = 20.0, .expect = GripParameters::Expect::kAny})},
      {"couple", R"({"tool": "tool side", "timeout_s": 1})",
       program(couple_parameters, couple_command, {.tool = "tool side", .timeout = 1.0})},
      {"uncouple", R"({"onto": "world"})", program(uncouple_parameters, uncouple_command, {.onto = "world"})},
      {"release", R"({"speed_m_s": 0.05})", program(release_parameters, open_command, {.speed = 0.05})},
      {"set", R"({"output": "lamp", "value": true})",
       program(set_parameters, set_command, {.output = "lamp", .value = true})},
      {"set", R"({"output": "valve", "value": {"channel": "speed"}, "factor": 2, "seconds": 1})",
       program(set_parameters, set_command,
               {.output = "valve",
                .source = ValueParameters{.kind = ValueParameters::Kind::kChannel, .of = "speed"},
                .factor = 2.0,
                .seconds = 1.0})},
  };
}

std::vector<Pair> bad_pairs() {
  return {
      {"press", R"({"force_N": -5, "travel_m": 3, "direction": [0, 0, 0]})",
       program(press_parameters, press_command, {.direction = Eigen::Vector3d::Zero(), .force = -5.0, .travel = 3.0})},
      {"search", R"({"radius_m": 0.5, "pitch_m": 0.001, "velocity_m_s": 2})",
       program(search_parameters, search_command, {.radius = 0.5, .pitch = 0.001, .velocity = 2.0})},
      {"wipe", R"({"in": "world", "width_m": 2, "pitch_m": 0.001, "velocity_m_s": 3})",
       program(wipe_parameters, wipe_command, {.in = "world", .width = 2.0, .pitch = 0.001, .velocity = 3.0})},
      {"hold", R"({"seconds": -1})", program(hold_parameters, hold_command, {.seconds = -1.0})},
      {"jog", R"({"linear_max_m_s": 7})", program(jog_parameters, jog_command, {.linear_max = 7.0})},
      {"look_at", R"({"at": "block", "distance_m": 0})",
       program(look_at_parameters, look_at_command, {.at = "block", .distance = 0.0})},
      {"follow", R"({"angular_max_deg_s": 0})", program(follow_parameters, follow_command, {.angular_max = 0.0})},
      {"grip", R"({"force_N": 0, "gripper": "hand"})",
       program(grip_parameters, close_command, {.gripper = "hand", .force = 0.0})},
      {"couple", R"({"tool": "tol side", "changer": "changr", "timeout_s": 0})",
       program(couple_parameters, couple_command, {.changer = "changr", .tool = "tol side", .timeout = 0.0})},
      {"uncouple", R"({"timeout_s": 100})", program(uncouple_parameters, uncouple_command, {.timeout = 100.0})},
      {"release", R"({"width_m": -0.1})", program(release_parameters, open_command, {.width = -0.1})},
      {"set", R"({"output": "lamb", "value": true})",
       program(set_parameters, set_command, {.output = "lamb", .value = true})},
  };
}

class Parity : public ::testing::Test {
 protected:
  Made read(const Pair& pair) {
    Diagnostics diagnostics;
    const std::string pointer;
    Json json = Json::parse(pair.file);
    json["do"] = pair.operation;
    auto command = Operations::global().find(pair.operation)->read_command({json, pointer, cell.cell, diagnostics});
    if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
    return command;
  }
  /// The net as LOAD would get it.
  std::string net_of(OperationCommand& command) {
    command.name = "operation";
    Diagnostics notes;
    const expression::Biases untared;
    const CommandBuilder tree(command, {.cell = cell.cell, .biases = untared, .notes = notes});
    command::Command made = tree.command();
    expression::Places places{{"arm", cell.q()}};
    const Diagnostics unplanned = command::plan(made, places);
    EXPECT_FALSE(unplanned.has_errors()) << unplanned.to_string();
    const auto mapped = command::map(made);
    EXPECT_TRUE(mapped) << mapped.error().to_string();
    return mapped ? net::net_to_json(mapped->net).dump(1) : std::string();
  }

  test::CommandCell cell{add_changer};

 private:
  static void add_changer(test::CommandCell& cell) {
    cell.cell.changers["changer"] = {.arm = "arm"};
    cell.cell.tool_sides["tool side"] = {.size = {}, .number = 1};
    cell.cell.digital_outputs["changer/lock"] = &cell.core.add(
        std::make_unique<device::DigitalOutput>("changer/lock", device::SignalOutputDescription<bool>{},
                                                std::make_shared<test::FakeOutput<bool>>(), cell.core.period()));
    for (const char* name : {"changer/locked", "changer/unlocked", "changer/ready_to_lock", "changer/coupled"})
      cell.cell.digital_inputs[name] = &cell.core.add(std::make_unique<device::DigitalInput>(
          name, device::SignalInputDescription<bool>{}, std::make_shared<test::FakeInput<bool>>()));
    cell.cell.analog_inputs["changer/tool_number"] = &cell.core.add(std::make_unique<device::AnalogInput>(
        "changer/tool_number", device::SignalInputDescription<double>{.unit = "1"},
        std::make_shared<test::FakeInput<double>>()));
  }
};

TEST_F(Parity, TheSameParametersComeToTheSameNet) {
  for (const Pair& pair : good_pairs(cell.moved(0, 0, 0).translation())) {
    SCOPED_TRACE(pair.operation);
    const Made in_file = read(pair), in_cpp = pair.in_cpp(cell.cell);
    ASSERT_TRUE(in_file) << in_file.error().to_string();
    ASSERT_TRUE(in_cpp) << in_cpp.error().to_string();
    const std::string net = net_of(**in_file);
    EXPECT_GT(net.size(), 200U);
    EXPECT_EQ(net, net_of(**in_cpp));
  }
}

TEST_F(Parity, TheSameMistakesAreToldInTheSameWords) {
  for (const Pair& pair : bad_pairs()) {
    SCOPED_TRACE(pair.operation);
    const Made in_file = read(pair), in_cpp = pair.in_cpp(cell.cell);
    ASSERT_FALSE(in_file);
    ASSERT_FALSE(in_cpp);
    EXPECT_EQ(in_file.error().to_string(), in_cpp.error().to_string());
  }
}

TEST_F(Parity, MotionsHaveTheSameParameters) {
  const Json json = Json::parse(R"({"do": "lin", "to": "home", "speed": 0.5, "acceleration": 0.9, "velocity_m_s": 0.1,
    "blend_m": 0.02, "force_offset": {"force_N": 8, "reach_m": 0.01, "direction": [0, 0, 2]}})");
  Diagnostics diagnostics;
  const std::string pointer;
  const MotionTask in_file = read_motion(PathKind::kLin, {json, pointer, cell.cell, diagnostics});
  EXPECT_EQ(diagnostics.to_string(), "");
  const auto in_cpp =
      motion_parameters(PathKind::kLin)
          .accept(
              MotionTask{{.velocity = 0.5,
                          .acceleration = 0.9,
                          .linear_velocity = 0.1,
                          .blend = activity::BlendingCondition::at_distance(0.02),
                          .force_offset = ForceOffsetParameters{.direction = {0, 0, 2}, .reach = 0.01, .force = 8.0}}},
              cell.cell);
  ASSERT_TRUE(in_cpp) << in_cpp.error().to_string();
  EXPECT_EQ(in_cpp->arm, in_file.arm);
  EXPECT_EQ(in_cpp->velocity, in_file.velocity);
  EXPECT_EQ(in_cpp->acceleration, in_file.acceleration) << "less than was asked for: a path leaves room for an offset";
  EXPECT_EQ(in_cpp->linear_velocity, in_file.linear_velocity);
  EXPECT_EQ(in_cpp->blend.along_path.kind, in_file.blend.along_path.kind);
  EXPECT_EQ(in_cpp->force_offset, in_file.force_offset);
  EXPECT_EQ(in_cpp->force_offset->direction, Eigen::Vector3d(0, 0, 1));
}

TEST_F(Parity, MistakesOfMotionsAreTheSame) {
  const Json json = Json::parse(R"({"do": "ptp", "to": "home", "speed": 2, "blend_fraction": 0.9,
                                    "weave": {"amplitude_m": 0.01, "frequency_Hz": 1}})");
  Diagnostics in_file;
  const std::string pointer;
  (void)read_motion(PathKind::kPtp, {json, pointer, cell.cell, in_file});
  const auto in_cpp =
      motion_parameters(PathKind::kPtp)
          .accept(MotionTask{{.velocity = 2.0,
                              .blend = activity::BlendingCondition(motion::Blend{motion::Blend::Kind::kFraction, 0.9}),
                              .weave = command::WeaveParameters{.amplitude = 0.01, .frequency = 1.0}}},
                  cell.cell);
  ASSERT_FALSE(in_cpp);
  EXPECT_EQ(in_file.to_string(), in_cpp.error().to_string());
  EXPECT_GE(in_file.list().size(), 3U);
}

TEST_F(Parity, MovesHaveTheSameParametersAndTheSameMistakes) {
  const auto in_file = [this](const char* text, Diagnostics& diagnostics) {
    const Json json = Json::parse(text);
    const std::string pointer;
    return read_motion(PathKind::kMove, {json, pointer, cell.cell, diagnostics});
  };
  const auto in_cpp = [this](double speed, const AvoidanceParameters& avoidance) {
    MotionTask task{{.velocity = speed}};
    task.avoidance = avoidance;
    return motion_parameters(PathKind::kMove).accept(std::move(task), cell.cell);
  };
  Diagnostics good, bad;
  const MotionTask file =
      in_file(R"({"do": "move", "to": "home", "speed": 0.5, "clearance_m": 0.01, "seed": 7, "effort": 2})", good);
  const auto program = in_cpp(0.5, {.clearance = 0.01, .seed = 7, .effort = 2.0});
  EXPECT_EQ(good.to_string(), "");
  ASSERT_TRUE(program) << program.error().to_string();
  EXPECT_EQ(program->arm, file.arm);
  EXPECT_EQ(program->velocity, file.velocity);
  EXPECT_EQ(program->avoidance.clearance, file.avoidance.clearance);
  EXPECT_EQ(program->avoidance.seed, file.avoidance.seed);
  EXPECT_EQ(program->avoidance.effort, file.avoidance.effort);
  (void)in_file(R"({"do": "move", "to": "home", "speed": 2, "clearance_m": 0, "seed": -1, "effort": 1000})", bad);
  const auto refused = in_cpp(2.0, {.clearance = 0.0, .seed = -1, .effort = 1000.0});
  ASSERT_FALSE(refused);
  EXPECT_EQ(bad.to_string(), refused.error().to_string());
  EXPECT_EQ(bad.list().size(), 4U);
}

TEST_F(Parity, AnActuatorPerformsAnyOperation) {
  activity::Runtime program(cell.core, cell.cell, [this] { cell.step(); });
  const app::Actuator robot(program, "arm");
  const activity::RunPtr run = robot.perform(PressParameters{.force = -1.0}).schedule();
  for (int i = 0; i < 5 && !run->over(); ++i) program.step();
  ASSERT_EQ(run->state(), activity::RunState::kFailed);
  EXPECT_THAT(run->diagnostics(), Reports(Code::kOutOfRange, "/press arm/force_N"));
}

/// A program that closes the gripper, whose fingers then report this.
class GripInCpp : public Parity {
 protected:
  activity::RunPtr close(const GripParameters& parameters, device::GripperState state, double width) {
    const activity::RunPtr run =
        app::Actuator(program, "gripper").use<app::GrippingInterface>().close(parameters).schedule();
    follow(run, state, width);
    return run;
  }
  void follow(const activity::RunPtr& run, device::GripperState state, double width) {
    for (int i = 0; i < 2000 && !run->over(); ++i) {
      if (!cell.fingers->written.empty()) cell.fingers->answer(state, width);
      program.step();
    }
  }
  activity::Runtime program{cell.core, cell.cell, [this] {
                              cell.fingers->sample.stamp = cell.core.time();  // it answers in every cycle
                              cell.step();
                            }};
};

TEST_F(GripInCpp, WhatIsExpectedAndNotThereIsAFailureAsInAFile) {
  const activity::RunPtr empty = close({}, device::GripperState::kIdle, 0.0);
  ASSERT_EQ(empty->state(), activity::RunState::kFailed);
  EXPECT_EQ(empty->failure(), activity::RunFailure::kAborted);
  EXPECT_EQ(empty->diagnostics().list().front().code, Code::kConditionNotMet) << empty->diagnostics().to_string();
  const activity::RunPtr any = close({.expect = GripParameters::Expect::kAny}, device::GripperState::kIdle, 0.0);
  EXPECT_EQ(any->state(), activity::RunState::kCompleted) << any->diagnostics().to_string();
  const activity::RunPtr held =
      close({.expect = GripParameters::Expect::kNothing}, device::GripperState::kHolding, 0.05);
  EXPECT_EQ(held->state(), activity::RunState::kFailed);
}

TEST_F(GripInCpp, ThePartGoesWithTheArmUntilTheGripperOpens) {
  program.step();
  cell.cell.objects.try_emplace("block");
  const double before = cell.core_arm().tool().payload.mass;
  const activity::RunPtr grip = close({.part = "block", .part_mass = 0.7}, device::GripperState::kHolding, 0.05);
  ASSERT_EQ(grip->state(), activity::RunState::kCompleted) << grip->diagnostics().to_string();
  EXPECT_NEAR(cell.core_arm().tool().payload.mass, before + 0.7, 1e-12);
  ASSERT_TRUE(cell.cell.held.contains("gripper"));
  const app::Actuator robot(program, "arm");
  robot.use<app::LinInterface>().lin_by({0, 0, 0.05}).execute();
  const activity::RunPtr open = app::Actuator(program, "gripper").use<app::GrippingInterface>().open().schedule();
  follow(open, device::GripperState::kIdle, 0.11);
  ASSERT_EQ(open->state(), activity::RunState::kCompleted) << open->diagnostics().to_string();
  EXPECT_NEAR(cell.core_arm().tool().payload.mass, before, 1e-12);
  EXPECT_FALSE(cell.cell.held.contains("gripper"));
}

TEST_F(GripInCpp, APressThatTouchesNothingIsAFailureAsInAFile) {
  program.step();
  const activity::RunPtr run = app::Actuator(program, "arm")
                                   .use<app::ForceInterface>()
                                   .press({.direction = {0, 0, 1}, .in = "arm", .travel = 0.002})
                                   .schedule();
  for (int i = 0; i < 20'000 && !run->over(); ++i) program.step();
  ASSERT_EQ(run->state(), activity::RunState::kFailed);
  EXPECT_EQ(run->diagnostics().list().front().code, Code::kConditionNotMet) << run->diagnostics().to_string();
}

// Whoever adds an operation adds a pair above, or says here how C++ does it.
TEST_F(Parity, EveryOperationHasAFormInCpp) {
  const std::map<std::string, std::string> otherwise{
      {"ptp", "PtpInterface, its parameters above"},
      {"lin", "LinInterface, likewise"},
      {"circ", "LinInterface, likewise"},
      {"spline", "PtpInterface and LinInterface, likewise"},
      {"move", "MotionInterface, its parameters above"},
      {"motions", "sequence() of motions that blend"},
      {"transaction", "command::TransactionCommand"},
      {"wait", "wait(), Cell::wait(), Cell::wait_until()"},
      {"net", "net_activity()"},
      {"tare", "Cell::tare()"},
      {"record_contact", "guarded_outcome() gives the contact"},
      {"fit_pose", "world::fit_pose()"},
      {"set_frame", "Frame::keep_as()"},
      {"attach", "attach()"},
      {"detach", "detach()"},
      {"control_mode", "ControlModeInterface::switch_to()"},
      {"weld", "perform(WeldParameters), in weld_test.cc: this cell has no torch"},
      {"freedrive", "FreedriveInterface, its parameters; it is no command"},
  };
  std::set<std::string> good, bad;
  for (const Pair& pair : good_pairs({})) good.insert(pair.operation);
  for (const Pair& pair : bad_pairs()) bad.insert(pair.operation);
  EXPECT_EQ(good, bad);
  for (const Operation& operation : Operations::global().all()) {
    const std::string name(operation.name);
    EXPECT_NE(good.contains(name), otherwise.contains(name)) << name;
  }
}

}  // namespace
}  // namespace takt::operations
