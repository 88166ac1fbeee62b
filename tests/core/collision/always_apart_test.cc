#include "core/collision/always_apart.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace takt::collision {
namespace {

constexpr double kWanted = 2e-3;  // m

/// A scene of one robot, with the ranges of its joints.
struct OneRobot {
  explicit OneRobot(const kinematics::RobotModel& model) {
    EXPECT_TRUE(scene.add_robot("robot", model, -1, Eigen::Isometry3d::Identity()).empty());
    for (const kinematics::Joint& joint : model.joints) {
      if (joint.type == kinematics::JointType::kFixed) continue;
      lower.push_back(std::isfinite(joint.lower) ? joint.lower : -M_PI);
      upper.push_back(std::isfinite(joint.upper) ? joint.upper : M_PI);
    }
    scene.find_pairs_that_never_meet();
  }
  [[nodiscard]] std::vector<double> posture(Random& random) const {
    std::vector<double> q;
    for (std::size_t j = 0; j < lower.size(); ++j) q.push_back(random.uniform(lower[j], upper[j]));
    return q;
  }
  Scene scene;
  std::vector<double> lower, upper;
};

kinematics::RobotModel urdf_of(const std::string& name) {
  return kinematics::RobotModel::load("models/" + name + "/" + name + ".urdf").value();
}

/// A ball of 10 mm that stands beside an arm of two joints: its tip meets it where the first is at 2.0 rad and the
/// second at -1.0 rad, and only about there.
OneRobot with_pin() {
  kinematics::RobotModel model;
  model.links.resize(3);
  const auto ball = [](double radius, const Eigen::Vector3d& p) {
    kinematics::Geometry geometry;
    geometry.shape = kinematics::Sphere{radius};
    geometry.X_LG = Eigen::Translation3d(p);
    return geometry;
  };
  for (std::size_t i = 0; i < 3; ++i) model.links[i].name = "link" + std::to_string(i);
  // Where the tip of the arm is at these joints.
  const Eigen::Vector3d tip =
      Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()) *
      (Eigen::Vector3d(0.2, 0, 0) + Eigen::AngleAxisd(-1.0, Eigen::Vector3d::UnitY()) * Eigen::Vector3d(0.15, 0, 0));
  model.links[0].collisions.push_back(ball(0.01, tip));
  model.links[1].collisions.push_back(ball(0.005, {0.1, 0, 0}));
  model.links[2].collisions.push_back(ball(0.005, {0.15, 0, 0}));
  model.joints.resize(2);
  for (std::size_t i = 0; i < 2; ++i) {
    kinematics::Joint& joint = model.joints[i];
    joint.name = "joint" + std::to_string(i);
    joint.parent = model.links[i].name;
    joint.child = model.links[i + 1].name;
    joint.type = kinematics::JointType::kRevolute;
    joint.axis = i == 0 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
    joint.lower = -2.5;
    joint.upper = 2.5;
  }
  model.joints[1].X_PJ = Eigen::Translation3d(0.2, 0, 0);
  return OneRobot(model);
}

/// The two are 5 mm apart in every posture, so no search may ask for their distance again and again.
TEST(AlwaysApart, LinksThatAreNearInEveryPostureAreProven) {
  const OneRobot arm(urdf_of("lwr4plus"));
  const int a = arm.scene.find("robot/link5"), b = arm.scene.find("robot/link7");
  ASSERT_GE(a, 0);
  ASSERT_GE(b, 0);
  EXPECT_TRUE(arm.scene.least_distance(a, b) >= kWanted || arm.scene.never_meet(a, b));
  EXPECT_EQ(arm.scene.least_distance(arm.scene.find("robot/link1"), b), 0.0) << "too many joints are between these";
}

TEST(AlwaysApart, OnePostureInAThousandIsEnoughForNo) {
  const OneRobot meets = with_pin();
  EXPECT_FALSE(always_apart(meets.scene, 0, 2, meets.lower, meets.upper, kWanted));
  EXPECT_FALSE(always_apart(meets.scene, 2, 0, meets.lower, meets.upper, kWanted));
  // The same pin out of the range of the first joint.
  OneRobot apart = with_pin();
  apart.upper[0] = 1.5;
  EXPECT_TRUE(always_apart(apart.scene, 0, 2, apart.lower, apart.upper, kWanted));
}

/// Of all shipped machines: no drawn posture brings two bodies nearer than was proven.
TEST(AlwaysApart, NoPostureOfAShippedMachineIsNearerThanProven) {
  Random random(5);
  int proven = 0;
  for (const auto& folder : std::filesystem::directory_iterator("models")) {
    const std::string name = folder.path().filename().string();
    const auto model = kinematics::RobotModel::load("models/" + name + "/" + name + ".urdf");
    if (!model) continue;
    const OneRobot robot(*model);
    const int n = static_cast<int>(robot.scene.bodies().size());
    State state = robot.scene.start();
    Poses poses;
    for (int i = 0; i < 300; ++i) {
      state.q = robot.posture(random);
      robot.scene.place(state, poses);
      for (int a = 0; a < n; ++a) {
        for (int b = a + 1; b < n; ++b) {
          const double least = robot.scene.least_distance(a, b);
          if (least <= 0.0 || robot.scene.never_meet(a, b)) continue;
          ++proven;
          ASSERT_GE(distance(robot.scene, poses, a, b), least)
              << name << ": " << robot.scene.body(a).name << " and " << robot.scene.body(b).name;
        }
      }
    }
  }
  EXPECT_GT(proven, 1000);
}

}  // namespace
}  // namespace takt::collision
