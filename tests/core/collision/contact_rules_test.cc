// What may touch what, while steps run and while they do not.
#include "core/collision/contact_rules.h"

#include <gtest/gtest.h>

namespace takt::collision {
namespace {

kinematics::RobotModel robot(const std::string& name) {
  auto model = kinematics::RobotModel::load("models/" + name + "/" + name + ".urdf");
  EXPECT_TRUE(model.has_value());
  return *model;
}

Eigen::Isometry3d at(double x, double y, double z) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << x, y, z;
  return X;
}

/// Two arms with grippers, a table, and a part on it.
class ContactRulesTest : public ::testing::Test {
 protected:
  ContactRulesTest() {
    Scene& scene = shapes.scene;
    for (const auto& [arm, x] : {std::pair("left", 0.0), std::pair("right", 1.4)}) {
      const std::string name = arm;
      const kinematics::RobotModel model = robot("lwr4plus");
      EXPECT_TRUE(scene.add_robot(name, model, -1, at(x, 0, 0.75)).empty());
      const int flange = scene.find(name + "/" + model.links.back().name);
      EXPECT_TRUE(scene.add_robot(name + " gripper", robot("wsg50"), flange, at(0, 0, 0)).empty());
      shapes.arms[name] = {.joints = {}, .flange = flange};
      shapes.grippers[name + " gripper"] = {};
    }
    scene.add_object("table", {{.shape = world::Box{{1, 1, 0.1}}}}, -1, at(0.7, 0, 0.7));
    scene.add_object("part", {{.shape = world::Box{{0.05, 0.05, 0.05}}}}, -1, at(0.7, 0, 0.775));
    shapes.objects = {"table", "part"};
    shapes.free_objects = {"part"};
    scene.find_pairs_that_never_meet();
    situation.state = scene.start();
  }
  [[nodiscard]] int body(const std::string& name) const {
    const int number = shapes.scene.find(name);
    EXPECT_GE(number, 0) << name;
    return number;
  }
  [[nodiscard]] int link(const std::string& owner, std::size_t from_root) const {
    const int root = shapes.scene.root_of(owner);
    return root + static_cast<int>(from_root);
  }
  void hold_part(const std::string& arm) {
    const int part = body("part");
    situation.state.fixings[static_cast<std::size_t>(part)] = {shapes.arms.at(arm).flange, at(0, 0, 0.2)};
    situation.holders[part] = {arm + " gripper"};
  }
  [[nodiscard]] Contact contact(int a, int b, const Touching& touching = {}) const {
    const ContactRules rules(shapes, situation);
    const Contact one = rules.contact(a, b, touching);
    EXPECT_EQ(one, rules.contact(b, a, touching)) << "either way round";
    return one;
  }

  CellShapes shapes;
  CellState situation;
};

TEST_F(ContactRulesTest, AnArmTouchesNothing) {
  const int elbow = link("left", 3);
  EXPECT_EQ(contact(elbow, body("table")), Contact::kForbidden);
  EXPECT_EQ(contact(elbow, body("part")), Contact::kForbidden);
  EXPECT_EQ(contact(elbow, link("right", 3)), Contact::kForbidden);
  EXPECT_EQ(contact(elbow, link("left gripper", 0)), Contact::kForbidden) << "its own tool";
  EXPECT_EQ(contact(body("part"), body("table")), Contact::kIgnored) << "no arm has a part in it";
}

TEST_F(ContactRulesTest, AGuardedMotionTouchesWithItsToolOnly) {
  const Touching left{"left"};
  EXPECT_EQ(contact(link("left gripper", 0), body("table"), left), Contact::kMeant);
  EXPECT_EQ(contact(link("left gripper", 0), body("table")), Contact::kForbidden);
  EXPECT_EQ(contact(link("left", 5), body("table"), left), Contact::kForbidden);
  EXPECT_EQ(contact(link("left gripper", 0), link("right", 5), left), Contact::kForbidden) << "a machine";
  EXPECT_EQ(contact(link("right gripper", 0), body("table"), left), Contact::kForbidden) << "of another arm";
}

TEST_F(ContactRulesTest, AGripperThatMovesItsFingersMayTouch) {
  EXPECT_EQ(contact(link("left gripper", 1), body("part"), {"left gripper"}), Contact::kMeant);
  EXPECT_EQ(contact(link("right gripper", 1), body("part"), {"left gripper"}), Contact::kForbidden);
}

TEST_F(ContactRulesTest, AHeldPartMayBeSetDownAndIsOfItsArm) {
  hold_part("left");
  EXPECT_EQ(contact(body("part"), body("table")), Contact::kSetDown);
  EXPECT_EQ(contact(body("part"), link("left gripper", 1)), Contact::kIgnored);
  EXPECT_EQ(contact(body("part"), link("left", 3)), Contact::kForbidden) << "its own arm";
  EXPECT_EQ(contact(body("part"), link("right", 3)), Contact::kForbidden);
  EXPECT_EQ(contact(body("part"), body("table"), {"left"}), Contact::kMeant);
}

TEST_F(ContactRulesTest, AnotherGripperMayTakeThePart) {
  hold_part("left");
  EXPECT_EQ(contact(body("part"), link("right gripper", 1)), Contact::kForbidden);
  EXPECT_EQ(contact(body("part"), link("right gripper", 1), {"right gripper"}), Contact::kMeant);
  situation.holders[body("part")] = {"left gripper", "right gripper"};
  EXPECT_EQ(contact(body("part"), link("right gripper", 1)), Contact::kIgnored) << "both hold it";
}

TEST_F(ContactRulesTest, WhatIsAllowedOrUnknownIsNotLookedAt) {
  shapes.relaxed.push_back({"table", "left", "it stands on it"});
  EXPECT_EQ(contact(link("left", 3), body("table")), Contact::kIgnored);
  EXPECT_EQ(contact(link("right", 3), body("table")), Contact::kForbidden);
  situation.unknown = {body("part")};
  EXPECT_EQ(contact(link("right", 3), body("part")), Contact::kIgnored);
}

TEST_F(ContactRulesTest, WhatDrivesMayBeLoaded) {
  shapes.arms["right"].is_base = true;
  hold_part("left");
  EXPECT_EQ(contact(body("part"), link("right", 2)), Contact::kSetDown);
  EXPECT_EQ(contact(link("left", 3), link("right", 2)), Contact::kForbidden);
}

TEST_F(ContactRulesTest, WhatIsMountedOnABaseMayBeTouched) {
  shapes.arms["right"].is_base = true;
  EXPECT_EQ(contact(link("left gripper", 0), link("right gripper", 0), {"left"}), Contact::kMeant);
  EXPECT_EQ(contact(link("left gripper", 0), link("right gripper", 0)), Contact::kForbidden);
  EXPECT_EQ(contact(link("left", 3), link("right gripper", 0), {"left"}), Contact::kForbidden);
}

}  // namespace
}  // namespace takt::collision
