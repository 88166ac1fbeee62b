// Sensors and states: the same formula outside of a net and inside of one.
#include "core/expression/sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/command/check.h"
#include "core/command/mapping.h"
#include "core/expression/comparison.h"
#include "core/expression/contact_reader.h"
#include "core/expression/frame_sensors.h"
#include "core/kinematics/link_path.h"
#include "tests/core/command/command_cell.h"
#include "tests/support/reports.h"

namespace takt::expression {
namespace {

using takt::test::Reports;

class SensorTest : public testing::Test {
 protected:
  /// The value of a formula in a net that runs for some cycles.
  template <class T>
  std::optional<T> in_net(const Sensor<T>& sensor, int cycles = 1) {
    command::WaitCommand wait("wait", 1000.0);
    wait.observe("it", sensor);
    auto handle = cell.runtime.load(wait);
    if (!handle) {
      ADD_FAILURE() << handle.error().to_string();
      return std::nullopt;
    }
    handle->start();
    for (int i = 0; i < cycles + 1; ++i) cell.runtime.step();
    const auto value = handle->template value<T>("it");
    handle->abort();
    cell.runtime.step();
    return value;
  }
  test::CommandCell cell;
};

TEST_F(SensorTest, ArithmeticIsTheSameNowAndInANet) {
  const RealSensor a = element(measured_joints(cell.cell, "arm"), 3);
  const double q = cell.arm->home[3];
  const std::vector<std::pair<RealSensor, double>> formulas = {
      {a + 1.0, q + 1.0},
      {2.0 - a, 2.0 - q},
      {a * a, q * q},
      {a / 2.0, q / 2.0},
      {-a, -q},
      {abs(-abs(a)), std::abs(q)},
      {sqrt(a * a), std::abs(q)},
      {min(a, -10.0), -10.0},
      {max(a, 10.0), 10.0},
      {low_pass(a, 5.0), q},
      {derivative(a, 5.0), 0.0},
      {largest(measured_joints(cell.cell, "arm")), cell.arm->home.cwiseAbs().maxCoeff()}};
  for (std::size_t i = 0; i < formulas.size(); ++i) {
    ASSERT_TRUE(formulas[i].first.now().has_value()) << i;
    EXPECT_NEAR(*formulas[i].first.now(), formulas[i].second, 1e-12) << i;
    EXPECT_NEAR(in_net(formulas[i].first).value_or(NAN), formulas[i].second, 1e-12) << i;
  }
}

TEST_F(SensorTest, GeometryOfVectorsAndFrames) {
  const FrameSensor pose = tool_pose(cell.cell, "arm");
  const Eigen::Isometry3d X_BT = cell.arm->chain->forward(cell.q()) * cell.cell.arms.at("arm").X_FT;
  EXPECT_TRUE(pose.now()->isApprox(X_BT, 1e-12));
  EXPECT_TRUE((pose * inverse(pose)).now()->isApprox(Eigen::Isometry3d::Identity(), 1e-12));
  EXPECT_TRUE(position(pose).now()->isApprox(X_BT.translation(), 1e-12));
  EXPECT_NEAR(*component(position(pose), 2).now(), X_BT.translation().z(), 1e-12);
  EXPECT_NEAR(*norm(position(pose)).now(), X_BT.translation().norm(), 1e-12);
  EXPECT_NEAR(*distance(pose, FrameTerm(Eigen::Isometry3d::Identity())).now(), X_BT.translation().norm(), 1e-12);
  const Eigen::Vector3d p(0.1, 0.2, 0.3);
  EXPECT_TRUE(transform(pose, p).now()->isApprox(X_BT * p, 1e-12));
  EXPECT_TRUE(rotate(pose, p).now()->isApprox(X_BT.linear() * p, 1e-12));
}

TEST_F(SensorTest, AForceIsFreeOfWeightAndBias) {
  EXPECT_LT(norm(force(cell.felt())).now().value_or(NAN), 1e-9);
  cell.extra.force = {3.0, 4.0, 0.0};
  cell.step();
  EXPECT_NEAR(norm(force(cell.felt())).now().value_or(NAN), 5.0, 1e-9);
  cell.sensor->silent = true;
  cell.step(30);
  EXPECT_EQ(norm(force(cell.felt())).now(), std::nullopt) << "an old reading is none";
  EXPECT_EQ(cell.hard().now(), std::nullopt);
  EXPECT_EQ(is_null(norm(force(cell.felt()))).now(), true);
}

TEST_F(SensorTest, StatesAreComparedCombinedAndHeld) {
  const RealSensor a = element(measured_joints(cell.cell, "arm"), 0);
  EXPECT_EQ(is_greater(a, -100.0).now(), true);
  EXPECT_EQ(is_less(a, -100.0).now(), false);
  EXPECT_EQ(in_range(a, -100.0, 100.0).now(), true);
  EXPECT_EQ(equals(a, a, 0.0).now(), true);
  EXPECT_EQ((is_greater(a, -100.0) and not is_less(a, -100.0)).now(), true);
  EXPECT_EQ((is_less(a, -100.0) or is_less(a, -101.0)).now(), false);
  const State held = is_greater(a, -100.0).held_for(0.01);
  EXPECT_EQ(in_net(BooleanSensor(held.node()), 5), false);
  EXPECT_EQ(in_net(BooleanSensor(held.node()), 15), true);
}

TEST_F(SensorTest, TheComparisonsOfAStateAreFoundAndNamed) {
  const RealSensor a = element(measured_joints(cell.cell, "arm"), 0), felt = norm(force(cell.felt()));
  const State state = (is_greater(felt, 5.0) or not is_less(a, -100.0)) and is_greater(felt, 5.0) and is_greater(a, a);
  const auto comparisons = comparisons_of(state.held_for(0.1));
  ASSERT_EQ(comparisons.size(), 2U) << "each once; a bound that is no constant is none";
  EXPECT_EQ(comparisons[0].text, "wrist above 5");
  EXPECT_EQ(comparisons[1].text, "arm below -100");
  EXPECT_EQ(comparisons[1].quantity.now(), a.now());
  EXPECT_TRUE(comparisons_of(holds(BooleanSensor(digital_input(cell.cell, "button").node()))).empty());
}

TEST_F(SensorTest, ADeviceThatIsNotThereIsFoundWithTheNearestName) {
  command::WaitCommand wait("wait", is_greater(norm(force(contact_wrench(cell.cell, "wirst"))), 1.0));
  const Diagnostics diagnostics = command::check(wait);
  ASSERT_TRUE(diagnostics.has_errors());
  EXPECT_THAT(diagnostics, Reports(Code::kUnknownName, "/wait", {"wirst", "wrist"}));
  EXPECT_EQ(digital_input(cell.cell, "bottom").now(), std::nullopt);
}

TEST_F(SensorTest, WeightIsTakenAwayHoweverAMovingBaseIsTurned) {
  ASSERT_TRUE(
      cell.cell.frames.set("arm", {.kind = world::Relation::Kind::kChannel, .parent = "world", .source = "target"})
          .empty());
  for (const double angle : {0.0, 0.8, 2.0}) {
    cell.X_WB.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()).toRotationMatrix();
    cell.cell.channels.at("target")->write(net::Frame(cell.X_WB));
    cell.step(2);
    EXPECT_LT(norm(force(cell.felt())).now().value_or(1.0), 1e-9) << angle;
  }
}

// What it consists of may change between two readings; the sensor and the arm do in any case.
TEST_F(SensorTest, AReaderOfContactsReadsWhatTheFormulaSays) {
  ContactWrenchReader reader(cell.cell, "wrist");
  Biases biases;
  const auto expect_the_same = [&](const char* after) {
    const auto wrench = contact_wrench(cell.cell, "wrist", biases).now();
    const auto read = reader.now(biases);
    ASSERT_EQ(read.has_value(), wrench.has_value()) << after;
    if (!read) return;
    EXPECT_EQ(read->force, wrench->force) << after;
    EXPECT_EQ(read->torque, wrench->torque) << after;
  };
  expect_the_same("nothing was measured yet");
  cell.step(2);
  expect_the_same("a reading");
  cell.X_WB.linear() = Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitX()).toRotationMatrix();
  cell.step(2);
  expect_the_same("another reading");
  const auto before = reader.now(biases);
  biases["wrist"].force = {1.0, -2.0, 3.0};
  expect_the_same("a tare");
  EXPECT_NE(reader.now(biases)->force, before->force);
  cell.cell.sensors.at("wrist").tool_mass += 0.5;
  expect_the_same("a heavier tool");
  ASSERT_TRUE(cell.cell.frames.set("arm", "world", cell.X_WB).empty());
  expect_the_same("the arm stands in another way");
  cell.sensor->silent = true;
  cell.step(200);
  expect_the_same("silence");
  EXPECT_FALSE(reader.now(biases));
  EXPECT_FALSE(ContactWrenchReader(cell.cell, "wirst").now(biases));
}

TEST_F(SensorTest, ASensorStandsOnceInANetHoweverManyUseIt) {
  command::WaitCommand wait("wait", is_greater(norm(force(cell.felt())), 5.0) ||
                                        is_greater(norm(force(cell.felt())), 7.0) ||
                                        is_less(norm(torque(cell.felt())), -1.0));
  const auto mapped = command::map(wait);
  ASSERT_TRUE(mapped.has_value());
  const auto count = [&mapped](const char* type) {
    return std::ranges::count(mapped->net.primitives, type, &net::PrimitiveDescription::type);
  };
  EXPECT_EQ(count("ForceTorqueSensor"), 1);
  EXPECT_EQ(count("ForwardKinematics"), 1);
  EXPECT_EQ(count("Norm"), 2);
}

TEST_F(SensorTest, PosesAndTwistsBetweenAnyTwoFrames) {
  ASSERT_TRUE(cell.cell.frames
                  .set("camera", {.kind = world::Relation::Kind::kFlange,
                                  .parent = "arm",
                                  .X_PF = Eigen::Isometry3d(Eigen::Translation3d(0.05, 0.0, 0.1)),
                                  .source = "arm"})
                  .empty());
  const auto X_WC = [this](const device::JointVector& q) {
    return cell.X_WB * cell.arm->chain->forward(q) * Eigen::Isometry3d(Eigen::Translation3d(0.05, 0.0, 0.1));
  };
  const Eigen::Isometry3d X_WO = *cell.cell.frames.pose("block");
  EXPECT_TRUE(pose_between(cell.cell, "camera", "block").now()->isApprox(X_WO.inverse() * X_WC(cell.q()), 1e-12));
  EXPECT_TRUE(pose_between(cell.cell, "block", "camera").now()->isApprox(X_WC(cell.q()).inverse() * X_WO, 1e-12));
  EXPECT_TRUE(pose_between(cell.cell, "block", "arm").now()->isApprox(*cell.cell.frames.pose("block", "arm"), 1e-12))
      << "what does not move is a constant";
  command::RuntimeCommand move("move", cell.arm_actuator(), command::ptp(cell.joints(0.6, -0.4), {.velocity = 0.5}));
  move.observe("pose", pose_between(cell.cell, "camera", "block"));
  move.observe("twist", twist_between(cell.cell, "camera", "block"));
  move.observe("back", twist_between(cell.cell, "block", "camera"));
  auto handle = cell.runtime.load(move);
  ASSERT_TRUE(handle.has_value()) << handle.error().to_string();
  handle->start();
  for (int i = 0; i < 400; ++i) cell.runtime.step();
  const auto before = *handle->value<net::Frame>("pose");
  const auto twist = *handle->value<net::Twist>("twist"), back = *handle->value<net::Twist>("back");
  cell.runtime.step();
  const auto after = *handle->value<net::Frame>("pose");
  const Eigen::Vector3d v = (after.translation() - before.translation()) / 1e-3;
  EXPECT_GT(v.norm(), 0.05) << "it moves";
  EXPECT_LT((twist.linear - v).norm(), 2e-3);
  const Eigen::Vector3d v_back = (after.inverse().translation() - before.inverse().translation()) / 1e-3;
  EXPECT_LT((back.linear - v_back).norm(), 2e-3);
  EXPECT_TRUE(back.angular.isApprox(-(before.linear().transpose() * twist.angular), 1e-9));
}

TEST_F(SensorTest, AFrameOnALinkMovesWithIt) {
  const std::string name = "link4";
  const Eigen::Isometry3d X_LC(Eigen::Translation3d(0.02, 0.1, 0.05));
  ASSERT_TRUE(
      cell.cell.frames
          .set("lamp",
               {.kind = world::Relation::Kind::kLink, .parent = "arm", .X_PF = X_LC, .source = "arm", .link = name})
          .empty());
  const kinematics::LinkPath* const link = cell.arm->links->find(name);
  ASSERT_NE(link, nullptr);
  const auto X_WC = [&](const device::JointVector& q) { return cell.X_WB * link->pose(q) * X_LC; };
  EXPECT_TRUE(pose_between(cell.cell, "lamp", "world").now()->isApprox(X_WC(cell.q()), 1e-12));
  command::RuntimeCommand move("move", cell.arm_actuator(), command::ptp(cell.joints(0.6, -0.4), {.velocity = 0.5}));
  move.observe("pose", pose_between(cell.cell, "lamp", "block"));
  move.observe("twist", twist_between(cell.cell, "lamp", "block"));
  auto handle = cell.runtime.load(move);
  ASSERT_TRUE(handle.has_value()) << handle.error().to_string();
  handle->start();
  for (int i = 0; i < 400; ++i) cell.runtime.step();
  const auto before = *handle->value<net::Frame>("pose");
  const auto twist = *handle->value<net::Twist>("twist");
  cell.runtime.step();
  const Eigen::Vector3d v = (handle->value<net::Frame>("pose")->translation() - before.translation()) / 1e-3;
  EXPECT_GT(v.norm(), 0.02) << "it moves";
  EXPECT_LT((twist.linear - v).norm(), 2e-3);
}

TEST_F(SensorTest, AFrameByAChannelFollowsIt) {
  ASSERT_TRUE(
      cell.cell.frames.set("part", {.kind = world::Relation::Kind::kChannel, .parent = "world", .source = "target"})
          .empty());
  EXPECT_EQ(pose_between(cell.cell, "part", "arm").now(), std::nullopt) << "nobody has said where it is";
  Eigen::Isometry3d X_WP(Eigen::Translation3d(0.5, 0.1, 0.2));
  cell.cell.channels.at("target")->write(net::Frame(X_WP));
  cell.step();
  EXPECT_TRUE(pose_between(cell.cell, "part", "arm").now()->isApprox(cell.X_WB.inverse() * X_WP, 1e-12));
  command::WaitCommand wait("wait", 1.0);
  wait.observe("nowhere", pose_between(cell.cell, "prat", "arm"));
  EXPECT_THAT(command::check(wait), Reports(Code::kUnknownName, "/wait/observations/nowhere", {"part"}));
}

/// A part whose place is told every `every` cycles: body C of the channel goes round a centre that goes straight on,
/// the part hangs on it 0.2 m off.
class MovingPart {
 public:
  explicit MovingPart(test::CommandCell& cell) : cell_(cell) {
    EXPECT_TRUE(cell.cell.frames
                    .set("part", {.kind = world::Relation::Kind::kChannel,
                                  .parent = "block",
                                  .X_PF = Eigen::Isometry3d(Eigen::Translation3d(kArm)),
                                  .source = "target"})
                    .empty());
  }

  /// C in the block at this time.
  [[nodiscard]] static Eigen::Isometry3d body(double t) {
    Eigen::Isometry3d X(Eigen::AngleAxisd(kOmega * t, Eigen::Vector3d::UnitZ()));
    X.translation() = t * kV + X.linear() * kOrbit;
    return X;
  }
  /// Velocity of the part in the block, in the block's axes.
  [[nodiscard]] static Eigen::Vector3d velocity(double t) {
    return kV + kOmega * Eigen::Vector3d::UnitZ().cross(body(t).linear() * (kOrbit + kArm));
  }
  void run(int cycles, int every) {
    for (int i = 0; i < cycles; ++i, ++cycle_) {
      if (cycle_ % every == 0) cell_.cell.channels.at("target")->write(net::Frame(body(1e-3 * cycle_)));
      cell_.step();
    }
  }
  /// Of the newest value that was told.
  [[nodiscard]] double told(int every) const { return 1e-3 * ((cycle_ - 1) / every * every); }

  static inline const Eigen::Vector3d kV{0.1, -0.05, 0.02}, kArm{0.2, 0.0, 0.0}, kOrbit{0.0, 0.3, 0.0};
  static constexpr double kOmega = 0.8;  ///< rad/s

 private:
  test::CommandCell& cell_;
  int cycle_ = 0;
};

TEST_F(SensorTest, AFrameByAChannelHasTheVelocityOfItsLastTwoValues) {
  MovingPart part(cell);
  const TwistSensor twist = twist_between(cell.cell, "part", "block"), back = twist_between(cell.cell, "block", "part");
  EXPECT_EQ(twist.now(), std::nullopt);
  part.run(1, 10);
  EXPECT_EQ(twist.now(), std::nullopt) << "one value says nothing of a velocity";
  for (const int every : {10, 1}) {
    part.run(300, every);
    // The body's is the mean since the value before: half of that time late, and the chord is shorter than the arc by
    // (omega dt)^2 / 24. The lever is that of the newest value.
    const double dt = 1e-3 * every, turned = MovingPart::kOmega * dt;
    const double late = MovingPart::kOmega * MovingPart::kOrbit.norm() * (0.5 * turned + turned * turned / 24.0);
    const auto now = twist.now();
    ASSERT_TRUE(now.has_value());
    EXPECT_LT((now->angular - Eigen::Vector3d(0, 0, MovingPart::kOmega)).norm(), 1e-9);
    EXPECT_LT((now->linear - MovingPart::velocity(part.told(every))).norm(), late + 1e-9);
    EXPECT_GT((now->linear - MovingPart::velocity(part.told(every))).norm(), 0.9 * late) << "no better, no worse";
    // Seen from the part, the block goes the other way.
    const Eigen::Isometry3d X_BP = *pose_between(cell.cell, "part", "block").now();
    const Eigen::Vector3d expected =
        -(X_BP.linear().transpose() * (now->linear - now->angular.cross(X_BP.translation())));
    EXPECT_LT((back.now()->linear - expected).norm(), 1e-9);
    EXPECT_LT((back.now()->angular + X_BP.linear().transpose() * now->angular).norm(), 1e-9);
  }
}

TEST_F(SensorTest, InANetTheVelocityIsThereInTheFirstCycleAndEndsWhenNoValueComes) {
  MovingPart part(cell);
  part.run(50, 10);
  command::WaitCommand wait("wait", 5.0);
  wait.observe("twist", twist_between(cell.cell, "part", "world"));
  wait.capture("first", twist_between(cell.cell, "part", "world"), wait.started());
  auto handle = cell.runtime.load(wait);
  ASSERT_TRUE(handle.has_value()) << handle.error().to_string();
  handle->start();
  part.run(3, 10);
  EXPECT_TRUE(handle->value<net::Twist>("first").has_value()) << "the values came before the net";
  ASSERT_TRUE(handle->value<net::Twist>("twist").has_value());
  Eigen::Vector3d last = handle->value<net::Twist>("twist")->linear;
  double largest_step = 0.0;
  for (int i = 0; i < 200; ++i) {
    part.run(1, 10);
    const Eigen::Vector3d now = handle->value<net::Twist>("twist")->linear;
    largest_step = std::max(largest_step, (now - last).norm());
    last = now;
  }
  EXPECT_LT(largest_step, 0.01) << "no peaks where a value comes, no zeros between";
  cell.step(400);
  EXPECT_TRUE(handle->value<net::Twist>("twist").has_value());
  cell.step(200);
  EXPECT_FALSE(handle->value<net::Twist>("twist").has_value()) << "nobody has told where it is for half a second";
}

}  // namespace
}  // namespace takt::expression
