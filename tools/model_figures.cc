#include "tools/model_figures.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/device/base_description.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/inverse.h"
#include "core/kinematics/robot_model.h"
#include "tools/model_kinematics.h"

namespace takt::tools {
namespace {

using Json = nlohmann::ordered_json;
using kinematics::JointVector;

constexpr double kDegrees = 180 / std::numbers::pi;

/// Infinite where the URDF sets no limit: null in JSON.
Json numbers(const JointVector& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(std::isfinite(value) ? Json(value) : Json(nullptr));
  return list;
}

Json links_json(const kinematics::RobotModel& robot) {
  Json links = Json::array();
  for (const kinematics::Link& link : robot.links) {
    links.push_back({{"name", link.name}, {"mass", link.inertial ? link.inertial->mass : 0.0}});
  }
  return links;
}

Json held_names(const device::ArmDescription& arm) {
  Json names = Json::array();
  for (const int joint : arm.inverse->held_joints()) names.push_back(arm.joint_names[static_cast<std::size_t>(joint)]);
  return names;
}

Json mode_names(const device::ArmDescription& arm) {
  Json names = Json::array();
  for (const device::ControlMode mode : arm.modes.modes) names.push_back(name_of(mode));
  return names;
}

Json arm_json(const device::ArmDescription& arm) {
  const auto& c = arm.cartesian;
  return {{"title", arm.title},
          {"joints", arm.joint_names},
          {"lower", numbers(arm.limits.lower)},
          {"upper", numbers(arm.limits.upper)},
          {"velocity", numbers(arm.limits.velocity)},
          {"acceleration", numbers(arm.limits.acceleration)},
          {"jerk", numbers(arm.limits.jerk)},
          {"effort", numbers(arm.effort)},
          {"home", numbers(arm.home)},
          {"cartesian",
           {{"linear_velocity", c.linear_velocity},
            {"linear_acceleration", c.linear_acceleration},
            {"linear_jerk", c.linear_jerk},
            {"angular_velocity", c.angular_velocity},
            {"angular_acceleration", c.angular_acceleration},
            {"angular_jerk", c.angular_jerk}}},
          {"payload_max", arm.payload_max},
          {"payload_rated", arm.payload_rated},
          {"cycle_ms", static_cast<double>(arm.cycle) / 1e6},
          {"reach", arm.chain->reach()},
          {"inverse_kinematics", way_to_solutions(arm)},
          {"held_joints", held_names(arm)},
          {"modes", mode_names(arm)}};
}

/// What the worst way within a base's limits asks of a wheel, rad/s.
double fastest_wheel(const device::BaseDescription& base) {
  return kinematics::fastest_wheel(base.drive, base.cartesian.linear_velocity, base.cartesian.angular_velocity);
}

/// A column of the table of joints: a heading, and how a number of the joint is shown there.
struct Column {
  const char* heading;  ///< of a turning joint; a sliding one shows m for deg and N for Nm
  const JointVector& values;
  bool angle;
};

void print_joints(const device::ArmDescription& arm) {
  const auto& limits = arm.limits;
  const Column columns[] = {{"from deg", limits.lower, true},       {"to deg", limits.upper, true},
                            {"deg/s", limits.velocity, true},       {"deg/s2", limits.acceleration, true},
                            {"deg/s3", limits.jerk, true},          {"Nm", arm.effort, false},
                            {"home deg", arm.home, true},           {"friction Nm", arm.friction, false},
                            {"armature kg m2", arm.armature, false}};
  fmt::print("\n  {:<18}", "joint");
  for (const Column& column : columns) fmt::print(" {:>14}", column.heading);
  for (int i = 0; i < arm.chain->joint_count(); ++i) {
    const bool slides = arm.chain->is_prismatic(i);
    const std::string& name = arm.joint_names[static_cast<std::size_t>(i)];
    fmt::print("\n  {:<18}", slides ? name + " (m, N)" : name);
    for (const Column& column : columns) {
      fmt::print(" {:>14.6g}", column.values[i] * (column.angle && !slides ? kDegrees : 1.0));
    }
  }
  fmt::print("\n");
}

void print_links(const kinematics::RobotModel& robot) {
  fmt::print("\n  {:<18} {:>10} {:>30}\n", "link", "kg", "centre of mass, m in the link");
  for (const kinematics::Link& link : robot.links) {
    if (!link.inertial) continue;
    const Eigen::Vector3d c = link.inertial->X_LC.translation();
    fmt::print("  {:<18} {:>10.4g} {:>30}\n", link.name, link.inertial->mass,
               fmt::format("({:.4f}, {:.4f}, {:.4f})", c.x(), c.y(), c.z()));
  }
}

Json drive_json(const device::BaseDescription& base) {
  Json json;
  if (const auto* mecanum = std::get_if<kinematics::MecanumDrive>(&base.drive)) {
    json = {{"kind", "mecanum"},
            {"wheel_radius", mecanum->wheel_radius},
            {"wheelbase", mecanum->wheelbase},
            {"track", mecanum->track}};
  } else {
    const auto& drive = std::get<kinematics::DifferentialDrive>(base.drive);
    json = {{"kind", "differential"},
            {"wheel_radius", drive.wheel_radius},
            {"track", drive.track},
            {"lateral_stiffness", drive.lateral_stiffness},
            {"lateral_force", drive.lateral_force}};
  }
  json["wheels"] = base.wheels;
  json["wheel_speed"] = base.wheel_speed;
  json["fastest_wheel"] = fastest_wheel(base);
  return json;
}

void print_arm_frames(const device::ArmDescription& arm) {
  fmt::print("  frames              base '{}' to flange '{}', at most {:.3f} m from the first joint\n", arm.base_link,
             arm.flange_link, arm.chain->reach());
  fmt::print("  inverse kinematics  {}\n", way_to_solutions(arm));
}

void print_base_frames(const device::BaseDescription& base) {
  fmt::print("  frames              from '{}', where the odometry counts from, to the body '{}'", base.base_link,
             base.flange_link);
  if (!base.mount_link.empty()) {
    const Eigen::Vector3d p = base.X_FM.translation();
    fmt::print("; an arm stands on '{}' at ({:g}, {:g}, {:g}) m", base.mount_link, p.x(), p.y(), p.z());
  }
  if (const auto* mecanum = std::get_if<kinematics::MecanumDrive>(&base.drive)) {
    fmt::print("\n  drive               four mecanum wheels of {:g} m, axles {:g} m apart, track {:g} m\n",
               mecanum->wheel_radius, mecanum->wheelbase, mecanum->track);
  } else {
    const auto& drive = std::get<kinematics::DifferentialDrive>(base.drive);
    fmt::print("\n  drive               two wheels of {:g} m on one axle, track {:g} m: it cannot go sideways\n",
               drive.wheel_radius, drive.track);
  }
  fmt::print("  wheels              {:.4g} rad/s at most within the limits below, of {:g}\n", fastest_wheel(base),
             base.wheel_speed);
}

void print_arm(const device::ArmDescription& arm) {
  const auto& c = arm.cartesian;
  const auto* base = dynamic_cast<const device::BaseDescription*>(&arm);
  base != nullptr ? print_base_frames(*base) : print_arm_frames(arm);
  fmt::print("  payload             {:g} kg rated, {:g} kg at most\n", arm.payload_rated, arm.payload_max);
  fmt::print("  cycle               {:g} ms\n", static_cast<double>(arm.cycle) / 1e6);
  fmt::print("  {} {:g} m/s, {:g} m/s2, {:g} m/s3; {:g} rad/s, {:g} rad/s2, {:g} rad/s3\n",
             base != nullptr ? "in any direction   " : "tool centre point  ", c.linear_velocity, c.linear_acceleration,
             c.linear_jerk, c.angular_velocity, c.angular_acceleration, c.angular_jerk);
  fmt::print("  control modes       {}\n", arm.modes.list());
  print_joints(arm);
}

Json gripper_json(const device::GripperDescription& gripper) {
  return {{"title", gripper.title},
          {"stroke", gripper.stroke},
          {"force_min", gripper.force_min},
          {"force_max", gripper.force_max},
          {"speed_min", gripper.speed_min},
          {"speed_max", gripper.speed_max},
          {"acceleration", gripper.acceleration},
          {"length", gripper.X_MT.translation().norm()},
          {"pad_friction", gripper.pad_friction},
          {"cycle_ms", static_cast<double>(gripper.cycle) / 1e6}};
}

void print_gripper(const device::GripperDescription& gripper) {
  const Eigen::Vector3d p = gripper.X_MT.translation();
  fmt::print("  stroke              {:g} mm between the pads, {:g} to {:g} mm/s\n", 1e3 * gripper.stroke,
             1e3 * gripper.speed_min, 1e3 * gripper.speed_max);
  fmt::print("  force               {:g} to {:g} N, of both fingers together; friction of the pads {:g}\n",
             gripper.force_min, gripper.force_max, gripper.pad_friction);
  fmt::print("  size                the tool centre point lies {:g} mm from the mount, at ({:g}, {:g}, {:g}) m\n",
             1e3 * p.norm(), p.x(), p.y(), p.z());
  fmt::print("  cycle               {:g} ms\n", static_cast<double>(gripper.cycle) / 1e6);
}

}  // namespace

int print_figures(const std::string& name, const std::string& kind, const kinematics::RobotModel& robot,
                  const device::ArmDescription* arm, const device::GripperDescription* gripper, const Common& common) {
  if (common.json) {
    Json json = {{"model", name}, {"kind", kind}, {"mass", robot.total_mass()}, {"links", links_json(robot)}};
    if (arm != nullptr) json.update(arm_json(*arm));
    if (gripper != nullptr) json.update(gripper_json(*gripper));
    if (const auto* base = dynamic_cast<const device::BaseDescription*>(arm)) json["drive"] = drive_json(*base);
    print(json);
    return kHeld;
  }
  fmt::print("{}: {}, {:.3f} kg\n", name,
             arm != nullptr       ? arm->title
             : gripper != nullptr ? gripper->title
                                  : kind,
             robot.total_mass());
  if (arm != nullptr) print_arm(*arm);
  if (gripper != nullptr) print_gripper(*gripper);
  print_links(robot);
  return kHeld;
}

}  // namespace takt::tools
