// Guiding by hand in the simulation: a hand pushes the tool of a compliant arm and of a stiff one with a sensor.
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <nlohmann/json.hpp>

#include "app/interfaces/actuator_interfaces.h"
#include "cell/build/cell_builder.h"
#include "cell/run/session.h"
#include "core/expression/device_sensors.h"
#include "tests/cell/described.h"
#include "tests/support/limit_oracle.h"
#include "tests/support/reports.h"

namespace takt::cell::freedrive_test {
namespace {

using activity::RunPtr;
using activity::RunState;
using app::FreedriveInterface;
using device::ControlMode;
using takt::test::Reports;
using testing::AllOf;

class FreedriveTest : public testing::TestWithParam<std::string> {
 protected:
  static std::string cell_of(const std::string& arm, const std::string& program) {
    return R"({"devices": {"arm": {"model": ")" + arm + R"("}, "wrist": {"model": "ft_gamma", "on": "arm"},
        "probe": {"model": "probe_ball", "on": "wrist"}},
        "channels": {"button": {"type": "Boolean", "timeout_s": 0.05}}, "program": )" +
           program + "}";
  }

  void build(const std::string& arm) {
    const auto description = parse_description(cell_of(arm, R"({"do": "wait", "seconds": 1})"));
    ASSERT_TRUE(description) << description.error().to_string();
    Diagnostics warnings;
    auto built = build_cell(*description, test::models(), false, warnings);
    ASSERT_TRUE(built) << built.error().to_string();
    robot_.reset();
    program_.reset();  // before its core, which has to outlive it
    cell_ = std::make_unique<BuiltCell>(std::move(*built));
    program_ = std::make_unique<activity::Runtime>(*cell_->core, cell_->cell, [this] { cycle(); });
    const auto list = [](const device::JointVector& v) { return std::vector<double>(v.begin(), v.end()); };
    const motion::JointLimits& limits = arm_model().limits;
    oracle_ = std::make_unique<takt::test::LimitOracle>(
        takt::test::LimitOracle::Limits{list(limits.lower), list(limits.upper), list(limits.velocity),
                                        list(limits.acceleration), list(limits.jerk)},
        1e-3, 1e-11);
    for (int i = 0; i < 200; ++i) cycle();
    robot_ = std::make_unique<app::Actuator>(*program_, "arm");
  }

  /// One cycle, in which the hand pushes the tool, and holds the button or not.
  void cycle() {
    if (button_) cell_->core->find_channel("button")->write(*button_);
    cell_->core->step();
    cell_->world->push(cell_->world->body(pushed_), hand_);
    ASSERT_TRUE(cell_->world->step());
    const auto& q = device().set_point().q;
    // Out of impedance, position begins where the arm is: no motion of the set point.
    watches_ = watches_ && device().mode() == watched_mode_;
    if (watches_) oracle_->add({q.begin(), q.end()});
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) program_->step();
  }

  device::Arm& device() { return *cell_->core->find_arm("arm"); }
  const device::ArmDescription& arm_model() { return device().description(); }
  [[nodiscard]] Eigen::Vector3d tip() const {
    return cell_->world->body_pose(cell_->world->body(pushed_)).translation();
  }
  [[nodiscard]] expression::State button() const {
    return expression::holds(expression::channel<bool>(cell_->cell, "button"));
  }
  /// A net that trips the guard ends with a failure; and the oracle differences what was sent.
  void expect_within_limits() {
    EXPECT_LE(oracle_->range_excess, 1e-9);
    EXPECT_LE(oracle_->velocity.share, 1.0 + 1e-4);
    EXPECT_LE(oracle_->acceleration.share, 1.0 + 1e-4);
    EXPECT_LE(oracle_->jerk.share, 1.0 + 1e-3);
  }
  RunPtr begin() {
    RunPtr run = robot_->use<FreedriveInterface>().freedrive({.enabled = button()}).begin_execute();
    watches_ = true;
    watched_mode_ = device().mode();
    button_ = true;
    steps(1200);  // soft, or tared
    return run;
  }
  void end(const RunPtr& run) {
    run->cancel();
    for (int i = 0; i < 5000 && !run->over(); ++i) program_->step();
    EXPECT_EQ(run->state(), RunState::kCancelled) << run->diagnostics().to_string();
    EXPECT_TRUE(device().at_rest());
    EXPECT_EQ(device().mode(), ControlMode::kPosition);
  }

  std::unique_ptr<BuiltCell> cell_;
  std::unique_ptr<activity::Runtime> program_;
  std::unique_ptr<app::Actuator> robot_;
  std::unique_ptr<takt::test::LimitOracle> oracle_;
  std::string pushed_ = "wrist/measuring";
  Eigen::Vector3d hand_ = Eigen::Vector3d::Zero();  ///< N, in the world
  std::optional<bool> button_;
  bool watches_ = false;
  ControlMode watched_mode_ = ControlMode::kPosition;
};

TEST_P(FreedriveTest, TwentyNewtonsLeadTheToolAndItStaysWhereItIsLetGo) {
  for (const Eigen::Vector3d& along : {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1)}) {
    ASSERT_NO_FATAL_FAILURE(build(GetParam()));
    const RunPtr run = begin();
    const Eigen::Vector3d from = tip();
    steps(500);
    EXPECT_LT((tip() - from).norm(), 1e-3) << "nobody pushes";
    hand_ = 20.0 * along;
    steps(1500);
    hand_.setZero();
    steps(1500);
    const Eigen::Vector3d way = tip() - from;
    RecordProperty("way_mm", std::to_string(1e3 * way.norm()));
    EXPECT_GT(way.dot(along), 0.03) << way.transpose();
    EXPECT_GT(way.dot(along), 0.7 * way.norm()) << "along the push: " << way.transpose();
    const Eigen::Vector3d there = tip();
    steps(2000);
    EXPECT_LT((tip() - there).norm(), 1e-3) << "it stays";
    end(run);
    EXPECT_LT((tip() - there).norm(), 2e-3) << "and in the mode that it had before";
    expect_within_limits();
    EXPECT_EQ(run->state(), RunState::kCancelled);
    button_.reset();
    watches_ = false;
  }
}

TEST_P(FreedriveTest, WithoutTheButtonItComesToRestAndIsStiff) {
  ASSERT_NO_FATAL_FAILURE(build(GetParam()));
  const RunPtr run = begin();
  hand_ = Eigen::Vector3d(0, 20, 0);
  steps(800);
  EXPECT_FALSE(device().at_rest());
  for (const std::optional<bool> now : {std::optional(false), std::optional<bool>()}) {
    button_ = now;
    int cycles = 0;
    while (!device().at_rest() && cycles < 2000) {
      program_->step();
      ++cycles;
    }
    EXPECT_LT(cycles, 400) << "of the set point";
    steps(1000);
    const Eigen::Vector3d pushed = tip();
    steps(1000);
    EXPECT_LT((tip() - pushed).norm(), 5e-4) << "the same push moves it no more";
    hand_.setZero();
    steps(1500);
    EXPECT_LT((tip() - pushed).norm(), 0.012) << "than its springs say";
    hand_ = Eigen::Vector3d(0, 20, 0);
    button_ = true;
    steps(1500);
    EXPECT_GT((tip() - pushed).norm(), 0.02) << "held again, it is led again";
  }
  hand_.setZero();
  steps(500);
  end(run);
  expect_within_limits();
}

TEST_P(FreedriveTest, AStrongHandBreaksNoLimitAndTheEndsOfTheJointsHold) {
  ASSERT_NO_FATAL_FAILURE(build(GetParam()));
  const RunPtr run = begin();
  for (const Eigen::Vector3d& force : {Eigen::Vector3d(0, 60, 0), Eigen::Vector3d(-60, 0, 0),
                                       Eigen::Vector3d(0, -60, 40), Eigen::Vector3d(50, 0, 0)}) {
    hand_ = force;
    double fastest = 0.0;
    Eigen::Vector3d last = robot_->tool().translation();
    for (int i = 0; i < 4000 && !run->over(); ++i) {
      program_->step();
      const Eigen::Vector3d now = robot_->tool().translation();
      fastest = std::max(fastest, (now - last).norm() / 1e-3);
      last = now;
    }
    ASSERT_EQ(run->state(), RunState::kRunning) << run->diagnostics().to_string();
    EXPECT_LT(fastest, 0.25 * 1.02) << "m/s of the set point";
  }
  hand_.setZero();
  steps(2000);
  end(run);
  expect_within_limits();
}

INSTANTIATE_TEST_SUITE_P(Arms, FreedriveTest, testing::Values("lwr4plus", "ur5"));

TEST(FreedriveRefusal, AnArmThatFeelsNothingSaysWhatWould) {
  const auto description =
      test::parsed(R"({"devices": {"arm": {"model": "tx90"}}, "program": {"do": "freedrive", "seconds": 1}})");
  const auto session = Session::create(description, test::models());
  ASSERT_FALSE(session);
  EXPECT_THAT(session.error(), Reports(Code::kConflict, "/program", {"arm", "joint_impedance"}));
}

class FreedriveStepTest : public testing::TestWithParam<std::string> {
 protected:
  static std::string cell_with(const std::string& program, const std::string& more = {}) {
    return R"({"devices": {"arm": {"model": ")" + GetParam() + R"("}, "wrist": {"model": "ft_gamma", "on": "arm"}},
        "channels": {"button": {"type": "Boolean", "initial": true}}, )" +
           more + R"("program": )" + program + R"(, "expectations": [{"kind": "limits"}]})";
  }
  static RunReport run(const std::string& text) {
    auto session = Session::create(test::parsed(text), test::models());
    if (session) return (*session)->run({});
    RunReport report;
    report.diagnostics = session.error();
    return report;
  }
};

TEST_P(FreedriveStepTest, StandsBetweenMotionsAndThePlaceIsKnownAfterIt) {
  const RunReport report = run(cell_with(R"json({"do": "sequence", "variables": {"taught": {"in": "world"}}, "steps": [
      {"do": "ptp", "to": {"by_m": [0, 0, 0.02]}},
      {"do": "freedrive", "seconds": 1.5, "velocity_m_s": 0.1, "turn_deg_s": 20},
      {"do": "let", "values": {"taught": "$position('arm')"}},
      {"do": "lin", "to": {"by_m": [0, 0, 0.03]}},
      {"do": "ptp", "to": "$taught"},
      {"do": "branch", "cases": [{"when": "$distance(position('arm'), taught) > 0.1[mm]",
                                  "steps": [{"do": "fail", "text": "not there"}]}]}
    ]})json"));
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  EXPECT_GT(report.sim_time, 1.5);
}

TEST_P(FreedriveStepTest, IsCancelledInOrderWhereverItIs) {
  for (const char* at : {"0.05", "0.3", "0.9"}) {
    const RunReport report = run(cell_with(R"({"do": "freedrive", "seconds": 30})",
                                           R"("operator": [{"at_s": )" + std::string(at) + R"(, "do": "cancel"}], )"));
    EXPECT_LT(report.sim_time, 5.0) << at << report.diagnostics.to_string();
    EXPECT_FALSE(report.diagnostics.to_string().find("guard") != std::string::npos) << report.diagnostics.to_string();
  }
}

TEST_P(FreedriveStepTest, WhatIsMissingOrWrongIsToldAllAtOnce) {
  const auto session = Session::create(
      test::parsed(cell_with(R"({"do": "freedrive", "velocity_m_s": 3, "enabled": {"input": "knob"}, "speed": 1})")),
      test::models());
  ASSERT_FALSE(session);
  EXPECT_THAT(session.error(), AllOf(Reports(Code::kMissing, "/program", {"until", "seconds"}),
                                     Reports(Code::kOutOfRange, "/program/velocity_m_s", {"3"}),
                                     Reports(Code::kUnknownName, "/program/enabled/input", {"knob"}),
                                     Reports(Code::kUnknownKey, "/program/speed")));
}

INSTANTIATE_TEST_SUITE_P(Arms, FreedriveStepTest, testing::Values("lwr4plus", "ur5"));

}  // namespace
}  // namespace takt::cell::freedrive_test
