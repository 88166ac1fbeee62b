#include "tests/sim/cell.h"

#include <stdexcept>

#include <gtest/gtest.h>

namespace takt::sim::test {
namespace {

JointVector joints(std::initializer_list<double> values) {
  JointVector q(static_cast<Eigen::Index>(values.size()));
  Eigen::Index i = 0;
  for (const double value : values) q[i++] = value;
  return q;
}

template <class T>
T value_of(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().to_string());
  return std::move(*result);
}

}  // namespace

std::shared_ptr<const kinematics::RobotModel> model(const std::string& name) {
  return std::make_shared<kinematics::RobotModel>(
      value_of(kinematics::RobotModel::load("models/" + name + "/" + name + ".urdf")));
}

kinematics::Chain lwr_chain() { return value_of(kinematics::Chain::create(*model("lwr4plus"), "base", "flange")); }

JointVector lwr_home() { return joints({0, -0.5236, 0, 1.5708, 0, -1.0472, 0}); }

RobotDescription lwr() {
  RobotDescription robot;
  robot.name = "arm";
  robot.model = model("lwr4plus");
  const JointVector home = lwr_home();
  robot.q.assign(home.begin(), home.end());
  const JointVector armature = joints({1, 1, 1, 1, 0.3, 0.3, 0.3});
  const auto names = lwr_chain().joint_names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    robot.joints.push_back({.joint = names[i], .armature = armature[static_cast<Eigen::Index>(i)]});
  }
  return robot;
}

SimArmDescription lwr_controller() {
  SimArmDescription arm;
  arm.name = "arm";
  arm.robot = "arm";
  arm.base_link = "base";
  arm.flange_link = "flange";
  arm.control.natural_frequency = joints({60, 60, 60, 60, 80, 80, 80});
  return arm;
}

void add_probe(WorldDescription& world) {
  RobotDescription sensor;
  sensor.name = "sensor";
  sensor.model = model("ft_gamma");
  sensor.mount.parent = "arm/flange";
  RobotDescription probe;
  probe.name = "probe";
  probe.model = model("probe_ball");
  probe.mount.parent = "sensor/tool";
  world.robots.push_back(sensor);
  world.robots.push_back(probe);
  SimForceTorqueDescription wrist;
  wrist.name = "wrist";
  wrist.tool_side = "sensor/measuring";
  world.force_torque_sensors.push_back(wrist);
}

ObjectDescription box(const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& at) {
  ObjectDescription object;
  object.name = name;
  object.mount.X_P.translation() = at;
  object.shapes.push_back({.shape = kinematics::Box{size}});
  return object;
}

World make(const WorldDescription& description) { return value_of(World::create(description)); }

device::ArmSetPoint set_point(const JointVector& q, const JointVector& dq, const JointVector& ddq) {
  device::ArmSetPoint point;
  point.q = q;
  point.dq = dq;
  point.ddq = ddq;
  return point;
}

device::ArmSetPoint set_point(const JointVector& q) {
  const JointVector zero = JointVector::Zero(q.size());
  return set_point(q, zero, zero);
}

void hold(World& world, const JointVector& q, int cycles) {
  for (int i = 0; i < cycles; ++i) {
    world.arm("arm")->write(set_point(q));
    ASSERT_TRUE(world.step());
  }
}

device::ArmSample sample(World& world) {
  device::ArmSample sample;
  EXPECT_TRUE(world.arm("arm")->read(sample));
  return sample;
}

device::WrenchSample wrench(World& world) {
  device::WrenchSample sample;
  EXPECT_TRUE(world.force_torque("wrist")->read(sample));
  return sample;
}

}  // namespace takt::sim::test
