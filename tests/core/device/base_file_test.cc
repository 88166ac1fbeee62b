#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/device/base_description.h"
#include "core/device/brake_ramp.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/inverse.h"

namespace takt::device {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const BaseDescription& youbot() {
  static const auto base = read_base("models/youbot_base");
  if (!base) ADD_FAILURE() << base.error().to_string();
  return **base;
}

TEST(BaseFile, ReadsTheYoubot) {
  const BaseDescription& base = youbot();
  EXPECT_EQ(base.chain->joint_count(), 3);
  EXPECT_EQ(base.joint_names, (std::vector<std::string>{"x", "y", "yaw"}));
  EXPECT_TRUE(base.inverse);
  EXPECT_EQ(base.home, JointVector::Zero(3));
  EXPECT_EQ(base.cartesian.linear_velocity, 0.4);
  EXPECT_EQ(std::get<kinematics::MecanumDrive>(base.drive).wheelbase, 0.47);
  EXPECT_FALSE(base.limits.nonholonomic);
  EXPECT_EQ(base.wheels[2], "rear_left");
  EXPECT_LT(base.X_FD.translation().norm(), 1e-12) << "the middle of the wheels is the body's origin";
  EXPECT_NEAR(base.X_FM.translation().z(), 0.1275, 1e-12);
  // Four wheels of 1.2e-3 kg m^2 about their axles, at 47.5 mm.
  EXPECT_NEAR(base.armature[0], 4.0 * 0.0011996 / (0.0475 * 0.0475), 1e-9);
}

TEST(BaseFile, ReadsABaseThatCannotGoSideways) {
  const auto base = read_base("models/rmp50");
  ASSERT_TRUE(base) << base.error().to_string();
  const auto& drive = std::get<kinematics::DifferentialDrive>((*base)->drive);
  EXPECT_EQ(drive.track, 0.538);
  EXPECT_EQ((*base)->wheels, (std::vector<std::string>{"left_wheel", "right_wheel"}));
  EXPECT_TRUE((*base)->limits.nonholonomic);
  EXPECT_LT((*base)->X_FD.translation().norm(), 1e-12) << "the middle of the axle is the body's origin";
  // Two wheels of 0.126 kg m^2 about their axles, at 0.24 m.
  EXPECT_NEAR((*base)->armature[0], 2.0 * 0.1262810 / (0.2404 * 0.2404), 1e-9);
}

/// Each axis may use its whole limit at any time: the vector, and every wheel, still keep theirs.
TEST(BaseFile, AxesInsideTheirLimitsKeepThoseOfTheVectorAndOfTheWheels) {
  const BaseDescription& base = youbot();
  Random random(9);
  double fastest = 0.0, wheel = 0.0;
  for (int k = 0; k < 20'000; ++k) {
    const auto of = [&](int i) {
      const double most = base.limits.velocity[i];
      return k % 2 == 0 ? random.uniform(-most, most) : std::copysign(most, random.uniform(-1.0, 1.0));
    };
    const double yaw = random.uniform(-M_PI, M_PI);
    const Eigen::Vector2d v_B(of(0), of(1)), v_F = Eigen::Rotation2Dd(-yaw) * v_B;
    fastest = std::max(fastest, v_B.norm());
    wheel = std::max(wheel, kinematics::wheel_speeds(base.drive, {v_F.x(), v_F.y(), of(2)}).cwiseAbs().maxCoeff());
  }
  EXPECT_LE(fastest, base.cartesian.linear_velocity * (1 + 1e-12));
  EXPECT_GT(fastest, 0.999 * base.cartesian.linear_velocity);
  EXPECT_LE(wheel, base.wheel_speed);
  EXPECT_GT(wheel, 0.97 * base.wheel_speed);
}

/// The stop reaction knows axes only, so the same must hold for its accelerations.
TEST(BaseFile, AStopKeepsTheVectorsLimitsToo) {
  const BaseDescription& base = youbot();
  Random random(10);
  for (int k = 0; k < 500; ++k) {
    motion::JointSample at{JointVector::Zero(3), JointVector(3), JointVector(3)};
    for (int i = 0; i < 3; ++i) {
      at.ddq[i] = random.uniform(-1.0, 1.0) * base.limits.acceleration[i];
      const double still = 0.5 * at.ddq[i] * at.ddq[i] / base.limits.jerk[i];
      at.dq[i] = random.uniform(-1.0, 1.0) * (base.limits.velocity[i] - still);
    }
    const BrakeRamp ramp(at, base.limits);
    for (double t = 0.0; t <= ramp.duration(); t += 0.01) {
      const auto now = ramp.sample(t);
      EXPECT_LE(now.dq.head<2>().norm(), base.cartesian.linear_velocity * (1 + 1e-9));
      EXPECT_LE(now.ddq.head<2>().norm(), base.cartesian.linear_acceleration * (1 + 1e-9));
    }
  }
}

/// A copy of the youBot's folder, changed in one of its files.
class BadBaseFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::path(testing::TempDir()) / "takt_base_file" / testing::UnitTest::GetInstance()->current_test_info()->name();
    copy();
  }
  void TearDown() override { fs::remove_all(folder_); }
  void copy() {
    fs::remove_all(folder_);
    fs::create_directories(folder_.parent_path());
    fs::copy("models/youbot_base", folder_, fs::copy_options::recursive);
  }

  void change(const std::string& file, const std::string& from, const std::string& to) {
    std::ifstream in(folder_ / file);
    std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto at = text.find(from);
    ASSERT_NE(at, text.npos) << from;
    text.replace(at, from.size(), to);
    std::ofstream(folder_ / file) << text;
  }
  [[nodiscard]] std::string diagnostics() const {
    const auto base = read_base(folder_);
    return base ? "" : base.error().to_string();
  }
  fs::path folder_;
};

struct Mistake {
  const char *file, *from, *to, *found;
};

TEST_F(BadBaseFile, EveryRuleOnce) {
  const char *device = "device.json", *urdf = "youbot_base.urdf";
  const Mistake mistakes[] = {
      {device, "\"kind\": \"base\"", "\"kind\": \"arm\"", "/kind"},
      {device, "\"mount\": \"arm_plate\"", "\"mount\": \"arm_plat\"", "did you mean 'arm_plate'?"},
      {device, "\"flange\": \"body\"", "\"flange\": \"along_y\"", "joint 'yaw' moves beside or beyond"},
      {device, "\"flange\": \"body\"", "\"flange\": \"front_left_wheel\"", "are not those of a base"},
      {device, "\"mecanum\"", "\"mecanumm\"", "did you mean 'mecanum'?"},
      {device, "\"wheel_radius_m\": 0.0475", "\"wheel_radius_m\": 0", "/drive/wheel_radius_m"},
      {device, "\"track_m\": 0.3,", "", "key 'track_m' is missing"},
      {device, "\"rear_left\", \"rear_right\"", "\"rear_left\"", "3 wheels"},
      {device, "\"rear_left\", \"rear_right\"", "\"rear_left\", \"rear_left\"", "duplicate wheel"},
      {device, "\"rear_right\"]", "\"rear_rihgt\"]", "did you mean 'rear_right'?"},
      {device, "\"rear_right\"]", "\"yaw\"]", "joint 'yaw' is not a wheel"},
      {device, "16.84", "15", "would turn a wheel with 16.77 rad/s, beyond 15"},
      {device, "\"linear_jerk_m_s3\": 6", "\"linear_jerk_m_s3\": -6", "/limits/linear_jerk_m_s3"},
      {device, "\"linear_jerk_m_s3\"", "\"linear_jerk\"", "did you mean 'linear_jerk_m_s3'?"},
      {device, "[60, 60, 60]", "[60, 60]", "/control/gains/natural_frequency_rad_s"},
      {device, "[\"position\"]", "[\"position\", \"joint_impedance\"]", "a base has no mode 'joint_impedance'"},
      {device, "\"resolution_m\": 3e-6", "\"resolution_m\": -1", "/odometry/resolution_m"},
      {urdf, "velocity=\"0.4\"", "velocity=\"0.5\"", "it is that of the vector"},
      {urdf, "<limit velocity=\"0.6\" effort=\"46\"/>", "<limit effort=\"46\" velocity=\"1.2\"/>", "beyond 16.84"},
      {urdf, "<limit velocity=\"0.6\" effort=\"46\"/>", "", "joint 'yaw' has no velocity limit"},
      {urdf, "<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 -1 0\"/>", "are not those of a base"},
      {urdf, "<origin xyz=\"0.235 0.15 0.0475\"/>\n    <axis xyz=\"0 1 0\"/>",
       "<origin xyz=\"0.235 0.15 0.0475\"/>\n    <axis xyz=\"0 -1 0\"/>", "joint 'front_left' is not a wheel"},
  };
  for (const Mistake& one : mistakes) {
    SCOPED_TRACE(std::string(one.from) + " -> " + one.to);
    copy();
    change(one.file, one.from, one.to);
    EXPECT_THAT(diagnostics(), HasSubstr(one.found));
  }
  copy();
  EXPECT_EQ(diagnostics(), "");
}

TEST_F(BadBaseFile, AllMistakesAtOnce) {
  change("device.json", "0.0475", "-1");
  change("device.json", "\"angular_jerk_rad_s3\": 12", "\"angular_jerk_rad_s3\": 0");
  change("device.json", "\"payload_max_kg\"", "\"payload_max\"");
  const std::string text = diagnostics();
  for (const char* found : {"/drive/wheel_radius_m", "/limits/angular_jerk_rad_s3", "did you mean 'payload_max_kg'?"})
    EXPECT_THAT(text, HasSubstr(found));
}

}  // namespace
}  // namespace takt::device
