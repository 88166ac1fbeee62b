// Device files of kind "base".
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/device/arm_reader.h"
#include "core/device/base_description.h"
#include "core/device/device_file_impl.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/inverse.h"
#include "core/kinematics/robot_model.h"

namespace takt::device {
namespace {

using Json = nlohmann::ordered_json;
using kinematics::JointType;

/// Share of a vector's limit that each of two axes may use: whatever both do, the vector keeps it.
constexpr double kAxisShare = 1.0 / std::numbers::sqrt2;
enum Axis { kX, kY, kYaw };

/// Where the body stands at x, y, yaw.
Eigen::Isometry3d in_plane(const JointVector& q) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << q[kX], q[kY], 0.0;
  X.linear() = Eigen::AngleAxisd(q[kYaw], Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return X;
}

class BaseReader {
 public:
  BaseReader(DeviceFile& file, ObjectReader& reader, BaseDescription& base)
      : file_(file), reader_(reader), base_(base), parts_(file, reader, base) {}

  void read() {
    parts_.read_names();
    base_.mount_link = file_.link(reader_, "mount", "");
    read_drive();
    parts_.read_chain(base_.wheels);
    base_.limits.nonholonomic = kinematics::is_nonholonomic(base_.drive);
    const bool plane = base_.chain != nullptr && moves_in_plane();
    base_.home = JointVector::Zero(3);
    base_.start_tolerance = reader_.number("start_tolerance_m", 0.01, kPositive);
    base_.following_error = reader_.number("following_error_m", base_.following_error, kPositive);
    base_.payload_max = reader_.number("payload_max_kg", 0.0, kNotNegative);
    parts_.read_times();
    read_limits(plane);
    parts_.read_control();
    check_modes();
    read_odometry();
    if (!plane || reader_.diagnostics().has_errors()) return;
    check_wheel_speed();
    finish();
  }

 private:
  void read_drive() {
    const Json* json = reader_.object("drive");
    if (json == nullptr) return;
    ObjectReader drive(*json, reader_.at("drive"), reader_.diagnostics());
    const bool differential = drive.choice("kind", {"mecanum", "differential"}) == "differential";
    if (differential) {
      base_.drive =
          kinematics::DifferentialDrive{.wheel_radius = drive.number("wheel_radius_m", {}, kPositive),
                                        .track = drive.number("track_m", {}, kPositive),
                                        .lateral_stiffness = drive.number("lateral_stiffness_N_m", {}, kPositive),
                                        .lateral_force = drive.number("lateral_force_N", {}, kPositive)};
    } else {
      base_.drive = kinematics::MecanumDrive{.wheel_radius = drive.number("wheel_radius_m", {}, kPositive),
                                             .wheelbase = drive.number("wheelbase_m", {}, kPositive),
                                             .track = drive.number("track_m", {}, kPositive)};
    }
    base_.wheel_speed = drive.number("wheel_speed_rad_s", {}, kPositive);
    base_.wheel_friction = drive.number("wheel_friction", base_.wheel_friction, kPositive);
    read_wheels(drive);
    drive.finish();
  }

  void read_wheels(ObjectReader& drive) {
    const auto names = drive.texts("wheels");
    base_.wheels.resize(static_cast<std::size_t>(kinematics::wheel_count(base_.drive)));
    if (names.size() != base_.wheels.size()) {
      return drive.diagnostics().error(Code::kWrongSize, drive.at("wheels"), fmt::format("{} wheels", names.size()),
                                       base_.wheels.size() == 2
                                           ? "Name two joints: left, right"
                                           : "Name four joints: front left, front right, rear left, rear right");
    }
    std::set<std::string> seen;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string pointer = drive.at("wheels") + pointer_segment(i);
      if (!seen.insert(names[i]).second)
        drive.diagnostics().error(Code::kDuplicate, pointer, fmt::format("duplicate wheel '{}'", names[i]),
                                  "Name each wheel once");
      base_.wheels[i] = names[i];
      check_wheel(names[i], pointer);
    }
  }

  void check_wheel(const std::string& name, const std::string& pointer) {
    if (base_.robot == nullptr) return;
    const kinematics::Joint* joint = base_.robot->joint(name);
    if (joint == nullptr) {
      std::vector<std::string> names;
      for (const auto& one : base_.robot->joints) names.push_back(one.name);
      return reader_.diagnostics().error(Code::kUnknownName, pointer, fmt::format("the URDF has no joint '{}'", name),
                                         nearest_choice(name, names));
    }
    const bool rolls = joint->type == JointType::kContinuous && (joint->axis - Eigen::Vector3d::UnitY()).norm() < 1e-9;
    if (!rolls) {
      reader_.diagnostics().error(Code::kInvalidValue, pointer, fmt::format("joint '{}' is not a wheel", name),
                                  "Make it a continuous joint about +y, so that a positive speed drives forward");
    }
  }

  /// Two sliding joints along x and y, then one about z, in one point: joint positions are the body's place.
  bool moves_in_plane() {
    const kinematics::Chain& chain = *base_.chain;
    if (chain.joint_count() == 3) {
      JointVector q(3);
      q << 0.3, -0.2, 0.7;  // any place but a special one
      if ((chain.forward(q).matrix() - in_plane(q).matrix()).norm() < 1e-12) return true;
    }
    reader_.diagnostics().error(
        Code::kInvalidValue, reader_.at("flange"),
        fmt::format("the joints from '{}' to '{}' are not those of a base", base_.base_link, base_.flange_link),
        "Give three: along x, along y, about z, with their frames in one point");
    return false;
  }

  void read_limits(bool plane) {
    const Json* json = reader_.object("limits");
    if (json == nullptr) return;
    ObjectReader limits(*json, reader_.at("limits"), reader_.diagnostics());
    auto& c = base_.cartesian;
    c.linear_acceleration = limits.number("linear_acceleration_m_s2", {}, kPositive);
    c.linear_jerk = limits.number("linear_jerk_m_s3", {}, kPositive);
    c.angular_acceleration = limits.number("angular_acceleration_rad_s2", {}, kPositive);
    c.angular_jerk = limits.number("angular_jerk_rad_s3", {}, kPositive);
    limits.finish();
    if (!plane) return;
    check_urdf_limits();
    c.linear_velocity = base_.limits.velocity[kX];
    c.angular_velocity = base_.limits.velocity[kYaw];
    const auto axes = [](double linear, double angular) {
      JointVector all(3);
      all << kAxisShare * linear, kAxisShare * linear, angular;
      return all;
    };
    base_.limits.velocity = axes(c.linear_velocity, c.angular_velocity);
    base_.limits.acceleration = axes(c.linear_acceleration, c.angular_acceleration);
    base_.limits.jerk = axes(c.linear_jerk, c.angular_jerk);
  }

  void check_urdf_limits() {
    if (base_.limits.velocity[kX] != base_.limits.velocity[kY]) {
      reader_.diagnostics().error(
          Code::kConflict, reader_.at("urdf"),
          fmt::format("joints '{}' and '{}' have the velocity limits {} and {}", base_.joint_names[kX],
                      base_.joint_names[kY], base_.limits.velocity[kX], base_.limits.velocity[kY]),
          "Give both the same: it is that of the vector");
    }
    for (int i = 0; i < 3; ++i) {
      if (std::isfinite(base_.effort[i])) continue;
      reader_.diagnostics().error(
          Code::kMissing, reader_.at("urdf"),
          fmt::format("joint '{}' has no effort limit", base_.joint_names[static_cast<std::size_t>(i)]),
          "Add <limit effort=\"...\"/> to the URDF");
    }
  }

  void check_modes() {
    for (const ControlMode mode : base_.modes.modes) {
      if (mode == ControlMode::kPosition) continue;
      reader_.diagnostics().error(Code::kUnknownName, reader_.at("control") + "/modes",
                                  fmt::format("a base has no mode '{}'", name_of(mode)), "Write [\"position\"]");
    }
  }

  void read_odometry() {
    const Json* json = reader_.object("odometry", /*required=*/false);
    if (json == nullptr) return;
    ObjectReader odometry(*json, reader_.at("odometry"), reader_.diagnostics());
    base_.position_resolution = odometry.number("resolution_m", 0.0, kNotNegative);
    base_.velocity_noise = odometry.number("velocity_noise_m_s", 0.0, kNotNegative);
    odometry.finish();
  }

  /// Whatever way the body goes within its limits, no wheel is asked for more than it can.
  void check_wheel_speed() {
    const auto& c = base_.cartesian;
    const double fastest = kinematics::fastest_wheel(base_.drive, c.linear_velocity, c.angular_velocity);
    if (fastest <= base_.wheel_speed) return;
    reader_.diagnostics().error(
        Code::kInvalidValue, reader_.at("drive") + "/wheel_speed_rad_s",
        fmt::format("{:g} m/s{} with {:g} rad/s would turn a wheel with {:.4g} rad/s, beyond {:g}", c.linear_velocity,
                    kinematics::is_nonholonomic(base_.drive) ? "" : " at 45 degrees", c.angular_velocity, fastest,
                    base_.wheel_speed),
        "Slow the joints down in the URDF");
  }

  /// A body whose origin lies off the axle would swing sideways when it turns.
  void check_axle() {
    constexpr double kOff = 1e-6;  // m
    const Eigen::Vector3d& p_FD = base_.X_FD.translation();
    if (!base_.limits.nonholonomic || p_FD.head<2>().norm() <= kOff) return;
    reader_.diagnostics().error(
        Code::kInvalidValue, reader_.at("flange"),
        fmt::format("the middle of the wheels is {:g} m ahead and {:g} m to the left of '{}'", p_FD.x(), p_FD.y(),
                    base_.flange_link),
        "Name a link whose origin is in the middle of the axle: about it a differential drive turns");
  }

  void finish() {
    const auto& robot = *base_.robot;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    double axial = 0.0;
    const double share = 1.0 / static_cast<double>(base_.wheels.size());
    for (const std::string& name : base_.wheels) {
      const std::string& link = robot.joint(name)->child;
      middle += share * pose_between(robot, base_.flange_link, link).translation();
      if (const auto& inertial = robot.link(link)->inertial)
        axial += share * (inertial->X_LC.linear() * inertial->I_C * inertial->X_LC.linear().transpose())(1, 1);
    }
    base_.X_FD.translation() << middle.x(), middle.y(), 0.0;
    check_axle();
    base_.armature =
        JointVector(std::visit([&](const auto& drive) { return drive.reflected_inertia(axial); }, base_.drive));
    if (!base_.mount_link.empty()) base_.X_FM = pose_between(robot, base_.flange_link, base_.mount_link);
    base_.inverse =
        std::make_shared<const kinematics::InverseKinematics>(*kinematics::InverseKinematics::create(*base_.chain));
  }

  DeviceFile& file_;
  ObjectReader& reader_;
  BaseDescription& base_;
  ArmReader parts_;
};

}  // namespace

Result<std::shared_ptr<const BaseDescription>> read_base(const std::filesystem::path& folder) {
  auto file = DeviceFile::open(folder, "base");
  if (!file) return std::unexpected(std::move(file.error()));
  ObjectReader reader(file->json(), "", file->diagnostics());
  BaseDescription base;
  BaseReader(*file, reader, base).read();
  return file->finish(reader, std::move(base));
}

}  // namespace takt::device
