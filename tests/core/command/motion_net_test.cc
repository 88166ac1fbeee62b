// The nets that motions are mapped to, loaded into a control core and run on an arm without a body.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/command/actions/device_commands.h"
#include "core/command/actions/tare.h"
#include "core/command/single_net.h"
#include "core/kinematics/chain.h"
#include "core/motion/planner.h"
#include "tests/support/fake_cell.h"
#include "tests/support/motion_net.h"

namespace takt::command {
namespace {

using device::JointVector;
using net::Cause;
using rcc::NetState;
namespace motion_ports = test::motion_ports;
using test::cancel_bound_cycles;
using test::motion_net;
using Json = nlohmann::ordered_json;

class MotionNetTest : public testing::Test {
 protected:
  motion::Motion ptp(double speed = 0.5) const {
    JointVector goal = fake.arm->home;
    goal[0] += 0.6;
    goal[3] -= 0.4;
    return *motion::plan_ptp(*fake.arm->chain, fake.arm->limits, fake.q(), goal, {.velocity = speed});
  }
  /// 15 cm to the side and up, with a turn of the tool.
  motion::Motion lin() const {
    Eigen::Isometry3d X_BT = fake.arm->chain->forward(fake.q()) * X_FT();
    X_BT.translation() += Eigen::Vector3d(-0.03, 0.15, 0.05);
    X_BT.rotate(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()));
    return *motion::plan_lin(*fake.arm->chain, *fake.arm->inverse, fake.arm->limits, fake.arm->cartesian, fake.q(),
                             X_BT, {}, {.velocity = 0.5, .X_FM = X_FT()});
  }
  Eigen::Isometry3d X_FT() const { return fake.cell.arms.at("arm").X_FT; }

  expression::Condition condition(const char* text) const {
    auto parsed = expression::parse_condition(Json::parse(text), "", fake.cell);
    if (!parsed) ADD_FAILURE() << parsed.error().to_string();
    return parsed.value_or(expression::Condition{});
  }
  net::NetDescription net_of(const motion::Motion& motion, std::optional<expression::Condition> until = {}) const {
    return motion_net({"motion", "arm", &motion, X_FT(), std::move(until)}, fake.cell, biases);
  }
  MappedCommand tare(std::int64_t cycles = 100) const {
    return single_net(tare_command("wrist", cycles, fake.cell), "tare").value();
  }
  rcc::NetId load(const net::NetDescription& net, const rcc::LoadOptions& options = {}) {
    auto id = fake.core.load(net, options);
    if (!id) ADD_FAILURE() << id.error().to_string();
    return id.value_or(0);
  }
  /// @return cycles until the net had ended; `most` if it has not.
  int run_to_end(rcc::NetId net, int most = 20'000) {
    int cycles = 0;
    for (; cycles < most && fake.core.state(net) != NetState::kTerminated; ++cycles) fake.step();
    return cycles;
  }
  Cause::Code end_of(rcc::NetId net) const { return fake.core.status(net).cause.code; }
  template <class T>
  std::optional<T> read(rcc::NetId net, std::string_view port) const {
    const auto* slot = fake.core.net(net)->find<T>(port);
    if (slot == nullptr) ADD_FAILURE() << "no port " << port;
    return slot == nullptr || slot->null ? std::nullopt : std::optional<T>(slot->value);
  }

  test::FakeCell fake;
  expression::Biases biases{{"wrist", fake.bias}};
};

constexpr const char* kForce = R"({"sensor": "wrist", "above_N": 5})";

TEST_F(MotionNetTest, EveryNetReadsBackFromItsJson) {
  const motion::Motion joints = ptp(), line = lin();
  const expression::Condition nested =
      condition(R"({"all": [{"any": [{"sensor": "wrist", "quantity": "force_z", "above_N": 5},
      {"sensor": "wrist", "quantity": "torque", "above_Nm": 2}]}, {"not": {"sensor": "wrist", "below_N": 1}}]})");
  for (const auto& net : {net_of(joints), net_of(line), net_of(line, condition(kForce)), net_of(joints, nested),
                          net_of(line, nested), tare().net}) {
    const auto again = net::net_from_json(Json::parse(net::net_to_json(net).dump()));
    ASSERT_TRUE(again.has_value()) << again.error().to_string();
    EXPECT_EQ(*again, net);
    EXPECT_NE(load(net), 0u);
  }
}

TEST_F(MotionNetTest, P3_PtpReachesItsGoalInsideTheLimits) {
  const motion::Motion motion = ptp(1.0);
  const auto net = load(net_of(motion));
  fake.core.start(net);
  EXPECT_NEAR(run_to_end(net), motion.duration() * 1e3, 2.0) << "as long as planned";
  EXPECT_EQ(end_of(net), Cause::Code::kTerminated);
  EXPECT_EQ(fake.q(), motion.q_goal) << "exactly";
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

TEST_F(MotionNetTest, P3_LinMovesTheToolOnItsLineInsideTheLimits) {
  const motion::Motion motion = lin();
  const Eigen::Vector3d from = fake.tool_in_world(fake.q()).translation();
  const auto net = load(net_of(motion));
  fake.core.start(net);
  run_to_end(net);
  EXPECT_EQ(end_of(net), Cause::Code::kTerminated);
  const Eigen::Vector3d to = from + fake.X_WB.linear() * Eigen::Vector3d(-0.03, 0.15, 0.05);
  EXPECT_LT((fake.tool_in_world(fake.q()).translation() - to).norm(), 1e-9);
  const Eigen::Vector3d along = (to - from).normalized();
  for (const auto& sent : fake.backend->sent) {
    const Eigen::Vector3d p = fake.tool_in_world(sent.q).translation() - from;
    ASSERT_LT((p - along * along.dot(p)).norm(), 1e-8);
  }
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

/// What the condition sees, and in which cycle the clock begins to brake.
struct Event {
  const char* condition;
  Eigen::Vector3d force, torque;  ///< in the sensor's axes
};

class MotionNetEvent : public MotionNetTest, public testing::WithParamInterface<Event> {};

TEST_P(MotionNetEvent, O7_P2_BrakesOnThePathFromTheCycleOfTheEvent) {
  const motion::Motion motion = lin();
  const auto net = load(net_of(motion, condition(GetParam().condition)));
  fake.core.start(net);
  fake.step(400);
  ASSERT_EQ(read<net::Real>(net, "motion/clock.rate"), 1.0) << "the weight of the tool and the bias alone stop nothing";
  ASSERT_EQ(read<net::Boolean>(net, motion_ports::kStopped), false);
  const auto X_BT = fake.arm->chain->forward(fake.q()) * X_FT();
  fake.extra = {.force = GetParam().force, .torque = GetParam().torque};
  fake.step();
  EXPECT_LT(*read<net::Real>(net, "motion/clock.rate"), 1.0) << "the first braking set point is that of the same cycle";
  EXPECT_EQ(read<net::Boolean>(net, motion_ports::kTouched), true);
  const auto touched = read<net::Frame>(net, motion_ports::kTouchFrame);
  ASSERT_TRUE(touched.has_value());
  EXPECT_TRUE(touched->isApprox(X_BT, 1e-12)) << "where the arm was when it was felt";
  fake.extra = {};  // a touch is not forgotten
  run_to_end(net);
  EXPECT_EQ(end_of(net), Cause::Code::kTerminated);
  EXPECT_LT(*read<net::Real>(net, "motion/clock.time"), motion.duration()) << "it did not go to the end";
  EXPECT_TRUE(fake.core_arm().at_rest());
  EXPECT_TRUE(read<net::Frame>(net, motion_ports::kTouchFrame)->isApprox(X_BT, 1e-12));
  EXPECT_LE(fake.worst_limit_share(), 1.0);
}

const Event kEvents[] = {
    {kForce, {3.0, -4.0, 0.5}, {0, 0, 0}},
    {R"({"sensor": "wrist", "quantity": "force_x", "above_N": 5})", {5.1, 0, 0}, {0, 0, 0}},
    {R"({"sensor": "wrist", "quantity": "force_y", "below_N": -5})", {0, -5.1, 0}, {0, 0, 0}},
    {R"({"sensor": "wrist", "quantity": "force_z", "above_N": 5})", {0, 0, 5.1}, {0, 0, 0}},
    {R"({"sensor": "wrist", "quantity": "torque", "above_Nm": 1})", {0, 0, 0}, {0.8, 0, -0.7}},
    {R"({"sensor": "wrist", "quantity": "torque_x", "above_Nm": 1})", {0, 0, 0}, {1.1, 0, 0}},
    {R"({"sensor": "wrist", "quantity": "torque_y", "below_Nm": -1})", {0, 0, 0}, {0, -1.1, 0}},
    {R"({"sensor": "wrist", "quantity": "torque_z", "above_Nm": 1})", {0, 0, 0}, {0, 0, 1.1}},
    {R"({"any": [{"sensor": "wrist", "above_N": 50}, {"sensor": "wrist", "quantity": "torque", "above_Nm": 1}]})",
     {0, 0, 0},
     {0, 1.1, 0}},
    {R"({"all": [{"sensor": "wrist", "above_N": 5}, {"sensor": "wrist", "quantity": "torque", "above_Nm": 1}]})",
     {6, 0, 0},
     {0, 1.1, 0}},
    {R"({"not": {"sensor": "wrist", "below_N": 5}})", {0, 6, 0}, {0, 0, 0}},
};
INSTANTIATE_TEST_SUITE_P(Each, MotionNetEvent, testing::ValuesIn(kEvents));

TEST_F(MotionNetTest, HalfOfAnAllStopsNothing) {
  const motion::Motion motion = lin();
  const auto net = load(net_of(motion, condition(kEvents[9].condition)));
  fake.core.start(net);
  fake.step(200);
  fake.extra.force.x() = 6.0;
  run_to_end(net);
  EXPECT_EQ(read<net::Real>(net, "motion/clock.time"), motion.duration());
  EXPECT_EQ(read<net::Boolean>(net, motion_ports::kStopped), false);
  EXPECT_EQ(read<net::Frame>(net, motion_ports::kTouchFrame), std::nullopt);
}

TEST_F(MotionNetTest, N3_ASilentSensorStopsTheArmAndIsNoTouch) {
  for (const char* text : {kForce, R"({"not": {"sensor": "wrist", "below_N": 5}})"}) {
    test::FakeCell cell;
    auto parsed = expression::parse_condition(Json::parse(text), "", cell.cell);
    const motion::Motion motion = ptp();
    const auto net = *cell.core.load(motion_net({"motion", "arm", &motion, X_FT(), *parsed}, cell.cell, biases));
    cell.core.start(net);
    cell.step(200);
    cell.sensor->silent = true;
    for (int i = 0; i < 5000 && cell.core.state(net) != NetState::kTerminated; ++i) cell.step();
    EXPECT_EQ(cell.core.status(net).cause.code, Cause::Code::kTerminated);
    EXPECT_TRUE(cell.core.net(net)->find<net::Boolean>(motion_ports::kStopped)->value);
    EXPECT_FALSE(cell.core.net(net)->find<net::Boolean>(motion_ports::kTouched)->value);
    EXPECT_TRUE(cell.core_arm().at_rest());
    EXPECT_LE(cell.worst_limit_share(), 1.0);
  }
}

TEST_F(MotionNetTest, N3_ASensorThatWasSilentBeforeLetsNothingMove) {
  const motion::Motion motion = ptp();
  const auto net = load(net_of(motion, condition(kForce)));
  fake.sensor->silent = true;
  fake.step(30);
  fake.core.start(net);
  run_to_end(net);
  EXPECT_EQ(read<net::Boolean>(net, motion_ports::kStopped), true);
  EXPECT_EQ(fake.q(), fake.arm->home) << "it never left";
}

TEST_F(MotionNetTest, L6_CancelAtEveryFiftiethCycleEndsAtRestWithinTheBound) {
  for (const bool line : {false, true}) {
    const motion::Motion motion = line ? lin() : ptp(1.0);
    const auto bound = cancel_bound_cycles(motion, fake.core.period());
    EXPECT_LT(bound, 1000) << "much better than the core's own";
    for (int at = 1; at < motion.duration() * 1e3 - 2; at += 50) {
      test::FakeCell cell;
      const auto net = *cell.core.load(motion_net({"motion", "arm", &motion, X_FT(), {}}, cell.cell, {}),
                                       {.cancel_bound_cycles = bound});
      cell.core.start(net);
      cell.step(at);
      cell.core.cancel(net);
      for (int i = 0; i <= bound && cell.core.state(net) != NetState::kTerminated; ++i) cell.step();
      ASSERT_EQ(cell.core.status(net).cause.code, Cause::Code::kCancelled) << "cancelled in cycle " << at;
      ASSERT_TRUE(cell.core_arm().at_rest()) << at;
      ASSERT_LE(cell.worst_limit_share(), 1.0) << at;
    }
  }
}

TEST_F(MotionNetTest, TareFindsTheBiasUnderTheWeightOfTheTool) {
  const MappedCommand mapped = tare();
  const auto net = load(mapped.net);
  fake.core.start(net);
  EXPECT_EQ(run_to_end(net), 101);
  const auto bias = read<net::Wrench>(net, mapped.observed.at(observed::kBias));
  ASSERT_TRUE(bias.has_value());
  EXPECT_LT((bias->force - fake.bias.force).norm(), 1e-9);
  EXPECT_LT((bias->torque - fake.bias.torque).norm(), 1e-9);
}

TEST_F(MotionNetTest, TareOfASilentSensorGivesUp) {
  const MappedCommand mapped = tare();
  const auto net = load(mapped.net);
  fake.core.start(net);
  fake.sensor->silent = true;
  EXPECT_LT(run_to_end(net), 1000);
  EXPECT_EQ(read<net::Wrench>(net, mapped.observed.at(observed::kBias)), std::nullopt);
}

TEST_F(MotionNetTest, TareCanBeCancelled) {
  const auto net = load(tare(100'000).net);
  fake.core.start(net);
  fake.step(10);
  fake.core.cancel(net);
  EXPECT_LE(run_to_end(net), 2);
  EXPECT_EQ(end_of(net), Cause::Code::kCancelled);
}

}  // namespace
}  // namespace takt::command
