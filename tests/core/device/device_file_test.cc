#include "core/device/device_file.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/kinematics/chain.h"
#include "core/kinematics/inverse.h"
#include "tests/support/reports.h"

namespace takt::device {
namespace {

namespace fs = std::filesystem;
using takt::test::Reports;
using testing::AllOf;
using testing::ElementsAre;

TEST(DeviceFile, ReadsTheLwr) {
  const auto arm = read_arm("models/lwr4plus");
  ASSERT_TRUE(arm) << arm.error().to_string();
  const ArmDescription& lwr = **arm;
  EXPECT_EQ(lwr.model, "lwr4plus");
  EXPECT_EQ(lwr.title, "KUKA LWR 4+");
  EXPECT_EQ(lwr.chain->joint_count(), 7);
  EXPECT_THAT(lwr.inverse->held_joints(), ElementsAre(2));
  for (const auto* list :
       {&lwr.limits.lower, &lwr.limits.upper, &lwr.limits.velocity, &lwr.limits.acceleration, &lwr.limits.jerk,
        &lwr.effort, &lwr.home, &lwr.armature, &lwr.natural_frequency, &lwr.torque_noise})
    EXPECT_EQ(list->size(), 7);
  EXPECT_EQ(lwr.limits.jerk[0], 160.0);
  EXPECT_TRUE(lwr.friction_observer.isZero(0.0)) << "not in its file";
  EXPECT_EQ(lwr.friction_observer.size(), 7);
  EXPECT_EQ(lwr.cycle, kMillisecond);
  EXPECT_EQ(lwr.sample_age_max, 20 * kMillisecond);
}

TEST(DeviceFile, ReadsSensorAndProbe) {
  const auto sensor = read_force_torque_sensor("models/ft_gamma");
  ASSERT_TRUE(sensor) << sensor.error().to_string();
  EXPECT_EQ((*sensor)->range.force.z(), 400.0);
  EXPECT_GT((*sensor)->X_MT.translation().z(), (*sensor)->X_MS.translation().z() - 1e-12);
  const auto probe = read_tool("models/probe_ball");
  ASSERT_TRUE(probe) << probe.error().to_string();
  EXPECT_EQ((*probe)->tip.ball_radius, 0.005);
  EXPECT_GT((*probe)->payload.mass, 0.0);
  EXPECT_GT((*probe)->X_MT.translation().z(), 0.02);
}

/// Along the plunger its spring, across it the tilt about the guide.
TEST(DeviceFile, ATipYieldsAsTheSpringsOfTheToolSay) {
  const auto rigid = read_tool("models/probe_ball");
  ASSERT_TRUE(rigid);
  EXPECT_EQ((*rigid)->tip.compliance_T, Eigen::Vector3d::Zero());
  const auto sprung = read_tool("models/probe_sprung");
  ASSERT_TRUE(sprung) << sprung.error().to_string();
  const Eigen::Vector3d compliance = (*sprung)->tip.compliance_T;
  EXPECT_NEAR(compliance.z(), 1.0 / 40e3, 1e-12);
  const auto* joint = (*sprung)->robot->joint("tilt_x");
  ASSERT_NE(joint, nullptr);
  const double lever = (*sprung)->X_MT.translation().z() - joint->X_PJ.translation().z();
  EXPECT_NEAR(compliance.x(), lever * lever / 160.0, 1e-9);
  EXPECT_NEAR(compliance.y(), compliance.x(), 1e-12);
}

/// A copy of the LWR's folder whose device file is changed.
class BadFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / "takt_device_file" /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_.parent_path());
    fs::copy("models/lwr4plus", folder_, fs::copy_options::recursive);
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Replaces `from` (which must be there) by `to`.
  void change(const std::string& from, const std::string& to) {
    std::ifstream in(folder_ / "device.json");
    std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto at = text.find(from);
    ASSERT_NE(at, text.npos) << from;
    text.replace(at, from.size(), to);
    std::ofstream(folder_ / "device.json") << text;
  }
  Diagnostics diagnostics() const {
    const auto arm = read_arm(folder_);
    return arm ? Diagnostics() : arm.error();
  }
  fs::path folder_;
};

TEST_F(BadFile, AllMistakesAtOnceWithTheNearestChoice) {
  change("\"payload_max_kg\"", "\"payload_max\"");
  change("\"flange\": \"flange\"", "\"flange\": \"flansch\"");
  change("[8, 5, 10, 8, 15, 15, 20]", "[8, 5, 10, 8, 15, 15]");
  change("[\"position\", \"joint", "[\"positon\", \"joint");
  change("\"damping_ratio\": [1,", "\"damping_ratio\": [-1,");
  const Diagnostics found = diagnostics();
  EXPECT_THAT(found, AllOf(Reports(Code::kUnknownKey, "/payload_max", {"payload_max", "payload_max_kg"}),
                           Reports(Code::kUnknownName, "/flange", {"flansch", "flange"}),
                           Reports(Code::kUnknownName, "/control/modes/0", {"positon", "position"}),
                           Reports(Code::kWrongType, "/control/gains/damping_ratio/0", {"-1"})));
  for (const Diagnostic& one : found.list()) EXPECT_TRUE(one.file.ends_with("device.json")) << to_string(one);
}

TEST_F(BadFile, WrongNumberOfJoints) {
  change("[8, 5, 10, 8, 15, 15, 20]", "[8, 5, 10, 8, 15, 15]");
  EXPECT_THAT(diagnostics(), Reports(Code::kWrongType, "/limits/acceleration_rad_s2", {"7"}));
}

TEST_F(BadFile, HomeOutsideTheRange) {
  change("\"home_rad\": [0, -0.5236", "\"home_rad\": [0, -5.5");
  EXPECT_THAT(diagnostics(), Reports(Code::kOutOfRange, "/home_rad/1", {"-5.5"}));
}

TEST_F(BadFile, UnknownHeldJoint) {
  change("[\"e1\"]", "[\"e2\"]");
  EXPECT_THAT(diagnostics(), Reports(Code::kUnknownName, "/held_joints/0", {"e2", "a1", "a2", "e1"}));
}

TEST_F(BadFile, WrongKind) {
  change("\"kind\": \"arm\"", "\"kind\": \"tool\"");
  EXPECT_THAT(diagnostics(), Reports(Code::kUnknownName, "/kind", {"tool", "arm"}));
}

TEST_F(BadFile, UrdfOutsideTheFolderOrMissing) {
  change("lwr4plus.urdf", "../ft_gamma/ft_gamma.urdf");
  EXPECT_THAT(diagnostics().list(), testing::Contains(testing::Field(&Diagnostic::pointer, "/urdf")));
  change("../ft_gamma/ft_gamma.urdf", "nowhere.urdf");
  EXPECT_TRUE(diagnostics().has_errors());
}

TEST_F(BadFile, TruncatedAnywhereIsAFindingNotACrash) {
  std::ifstream in(folder_ / "device.json");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  for (std::size_t size = 0; size + 2 < text.size(); size += 97) {
    std::ofstream(folder_ / "device.json") << text.substr(0, size);
    EXPECT_TRUE(diagnostics().has_errors()) << size;
  }
}

TEST(ModelLibrary, FindsByNameAndNamesTheNearest) {
  const ModelLibrary library({"models"});
  EXPECT_THAT(library.names(), testing::IsSupersetOf({"ft_gamma", "lwr4plus", "probe_ball"}));
  const auto found = library.find("lwr4plus");
  ASSERT_TRUE(found);
  EXPECT_EQ(read_device_kind(*found).value_or(""), "arm");
  const auto typo = library.find("lwr4pluss", "/devices/arm/model");
  ASSERT_FALSE(typo);
  EXPECT_THAT(typo.error(), Reports(Code::kUnknownName, "/devices/arm/model", {"lwr4pluss", "lwr4plus"}));
  for (const char* bad : {"", ".", "..", "../models/lwr4plus", "/etc"}) EXPECT_FALSE(library.find(bad)) << bad;
}

TEST(Payload, TwoHalvesMakeTheWhole) {
  // Two point masses at +-d along x: mass, centre and inertia by hand.
  const PayloadSetting left{.mass = 1.0, .p_FC = {-0.1, 0, 0}, .I_C = Eigen::Matrix3d::Zero()};
  const PayloadSetting right{.mass = 3.0, .p_FC = {0.1, 0, 0}, .I_C = Eigen::Matrix3d::Zero()};
  const auto sum = combine(left, right);
  EXPECT_DOUBLE_EQ(sum.mass, 4.0);
  EXPECT_DOUBLE_EQ(sum.p_FC.x(), 0.05);
  EXPECT_NEAR(sum.I_C(1, 1), 1.0 * 0.15 * 0.15 + 3.0 * 0.05 * 0.05, 1e-15);
  EXPECT_NEAR(sum.I_C(0, 0), 0.0, 1e-15);
  const Eigen::Isometry3d turn(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  EXPECT_NEAR(transform(turn, sum).I_C(0, 0), sum.I_C(1, 1), 1e-15);
  EXPECT_NEAR(transform(turn, sum).p_FC.y(), 0.05, 1e-15);
}

}  // namespace
}  // namespace takt::device
