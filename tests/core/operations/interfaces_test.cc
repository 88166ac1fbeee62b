// What actuators offer beside the operations of files: single joints, measured values, interfaces of a project; several
// actuators as one device.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/interfaces/composed_device.h"
#include "tests/core/activity/activity_cell.h"
#include "tests/core/activity/two_arm_cell.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::Not;

Diagnostics error_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const activity::ActivityError& error) {
    return error.diagnostics();
  }
  return {};
}

class InterfacesTest : public testing::Test {
 protected:
  test::ActivityCell cell;
};

TEST_F(InterfacesTest, OneJointMovesAndTheOthersStand) {
  const kinematics::JointVector before = cell.robot.q();
  const auto joint = cell.robot.use<app::JointInterface>();
  joint.move_to(3, before[3] - 0.3).execute();
  joint.move_by(3, 0.1, {.velocity = 0.5}).execute();
  kinematics::JointVector expected = before;
  expected[3] -= 0.2;
  EXPECT_LT((cell.robot.q() - expected).norm(), 1e-9);
  EXPECT_THAT(error_of([&] { (void)joint.move_to(7, 0.0); }), Reports(Code::kOutOfRange, "/arm", {"7", "0", "6"}));
  EXPECT_THAT(error_of([&] { joint.move_to(3, 9.0).execute(); }),
              Reports(Code::kOutOfRange, "/arm PTP/to", {"515.662", "-120", "120"}));
}

TEST_F(InterfacesTest, WhatIsMeasuredIsToldBesideTheSetPoint) {
  cell.motion.lin_by({0.0, 0.05, 0.0}).begin_execute();
  for (int i = 0; i < 100; ++i) cell.program.step();
  EXPECT_EQ(cell.robot.measured_q(), cell.cell.arms.at("arm").device->sample().q);
  const Eigen::Isometry3d X_BT = cell.arm->chain->forward(cell.robot.measured_q()) * cell.cell.arms.at("arm").X_FT;
  EXPECT_TRUE(cell.robot.measured_tool().isApprox(X_BT, 1e-12));
  EXPECT_NE(cell.robot.measured_q(), cell.robot.q()) << "a cycle behind while it moves";
}

TEST(ForceInterfaceTest, AnArmWithoutASensorOfItsOwnDoesNotOfferIt) {
  test::TwoArmCell cell;
  const app::Actuator left(cell.program, "left");
  EXPECT_TRUE(left.offers<app::ForceInterface>());
  cell.cell.sensors.erase("left wrist");
  EXPECT_FALSE(left.offers<app::ForceInterface>()) << "that of the right arm feels nothing of it";
  EXPECT_THAT(left.interfaces(), Not(Contains("ForceInterface")));
}

/// An interface that a project brings.
class PolishInterface : public app::ActuatorInterface {
 public:
  static constexpr std::string_view kName = "PolishInterface";
  static bool offered_by(const expression::Cell& cell, const std::string& actuator) {
    return cell.arms.contains(actuator);
  }
  using app::ActuatorInterface::ActuatorInterface;
};
const app::RegisterInterface<PolishInterface> kPolish;

TEST_F(InterfacesTest, AnInterfaceOfAProjectIsListed) {
  EXPECT_THAT(cell.robot.interfaces(), Contains("PolishInterface"));
  EXPECT_THAT(app::Actuator(cell.program, "lamp").interfaces(), Not(Contains("PolishInterface")));
  EXPECT_EQ(cell.robot.use<PolishInterface>().actuator(), "arm");
}

// 2010: a welding robot is a robot with its torch.
TEST_F(InterfacesTest, SeveralActuatorsAreOneDevice) {
  const app::ComposedDevice welder("welder", {cell.robot, app::Actuator(cell.program, "lamp")});
  EXPECT_TRUE(welder.offers<app::LinInterface>());
  EXPECT_FALSE(welder.offers<app::GrippingInterface>());
  EXPECT_THAT(welder.interfaces(), AllOf(Contains("OutputInterface"), Contains("LinInterface")));
  activity::sequence(
      {welder.use<app::LinInterface>().lin_by({0.0, 0.05, 0.0}), welder.use<app::OutputInterface>().set(true)})
      .execute();
  EXPECT_TRUE(cell.cell.digital_outputs.at("lamp")->value());
  EXPECT_EQ(welder.part("arm").name(), "arm");
  welder.set_speed(0.5);
  cell.program.step();
  EXPECT_EQ(expression::channel<net::Real>(cell.cell, "arm.speed").now(), 0.5);

  EXPECT_THAT(error_of([&] { (void)welder.part("lam"); }), Reports(Code::kUnknownName, "/welder", {"lam", "lamp"}));
  EXPECT_THAT(error_of([&] { (void)welder.use<app::GrippingInterface>(); }),
              Reports(Code::kUnsupported, "/welder", {"welder"}));
  const app::ComposedDevice lamps("lamps",
                                  {app::Actuator(cell.program, "lamp"), app::Actuator(cell.program, "driver")});
  EXPECT_THAT(error_of([&] { (void)lamps.use<app::OutputInterface>(); }), Reports(Code::kConflict, "/lamps"));
  EXPECT_THAT(lamps.interfaces(), ElementsAre());
  EXPECT_THAT(error_of([&] { (void)app::ComposedDevice("none", {}); }), Reports(Code::kMissing, "/none"));
  EXPECT_THAT(error_of([&] {
                (void)app::ComposedDevice("twice", {cell.robot, cell.robot});
              }),
              Reports(Code::kDuplicate, "/twice", {"twice"}));
}

/// What only a robot with its torch can do.
class WeldingInterface : public app::DeviceInterface {
 public:
  static constexpr std::string_view kName = "WeldingInterface";
  static bool offered_by(const app::ComposedDevice& device) {
    return device.has_part("robot") && device.has_part("torch");
  }
  using app::DeviceInterface::DeviceInterface;

  [[nodiscard]] activity::Activity weld(const Eigen::Vector3d& seam) const {
    const auto torch = part("torch").use<app::OutputInterface>();
    return activity::sequence({torch.set(true), part("robot").use<app::LinInterface>().lin_by(seam), torch.set(false)});
  }
};

TEST_F(InterfacesTest, AComposedDeviceHasInterfacesOfTheProgramsOwnWithItsPartsByRole) {
  const app::Actuator lamp(cell.program, "lamp");
  const app::ComposedDevice welder("welder", {{"robot", cell.robot}, {"torch", lamp}});
  ASSERT_TRUE(welder.offers<WeldingInterface>());
  const Eigen::Vector3d before = cell.robot.tool().translation();
  const activity::RunPtr run = welder.use<WeldingInterface>().weld({0.0, 0.02, 0.0}).begin_execute();
  for (int i = 0; i < 20; ++i) cell.program.step();
  EXPECT_TRUE(cell.cell.digital_outputs.at("lamp")->value());
  activity::wait(cell.program, run);
  EXPECT_FALSE(cell.cell.digital_outputs.at("lamp")->value());
  EXPECT_NEAR(cell.robot.tool().translation().y(), before.y() + 0.02, 1e-6);
  EXPECT_EQ(welder.part("torch").name(), "lamp");
  EXPECT_EQ(welder.part("lamp").name(), "lamp");

  const app::ComposedDevice other("other", {cell.robot, lamp});
  EXPECT_FALSE(other.offers<WeldingInterface>());
  EXPECT_THAT(error_of([&] { (void)other.use<WeldingInterface>(); }),
              Reports(Code::kUnsupported, "/other", {"WeldingInterface", "arm", "lamp"}));
  EXPECT_THAT(error_of([&] {
                (void)app::ComposedDevice("twice", {{"robot", cell.robot}, {"robot", lamp}});
              }),
              Reports(Code::kDuplicate, "/twice", {"robot"}));
}

}  // namespace
}  // namespace takt::operations
