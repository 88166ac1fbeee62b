#include "core/device/plant_file.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/json.h"
#include "core/device/link_pose.h"
#include "core/kinematics/robot_model.h"

namespace takt::device {
namespace {

using Json = nlohmann::ordered_json;

SpringJoint read_spring(ObjectReader& reader, const std::string& name, bool turns) {
  SpringJoint spring{.joint = name};
  spring.stiffness = reader.number(turns ? "stiffness_Nm_rad" : "stiffness_N_m", {}, kPositive);
  spring.damping = reader.number(turns ? "damping_Nm_s_rad" : "damping_N_s_m", 0.0, kNotNegative);
  spring.preload = reader.number(turns ? "preload_Nm" : "preload_N", 0.0, kNotNegative);
  return spring;
}

/// The URDF's joint for a spring; null with a diagnostic if there is none that a spring can hold.
const kinematics::Joint* spring_joint(const kinematics::RobotModel& robot, const std::string& name,
                                      const std::string& pointer, Diagnostics& diagnostics) {
  const kinematics::Joint* joint = robot.joint(name);
  if (joint && joint->type != kinematics::JointType::kFixed && joint->type != kinematics::JointType::kContinuous)
    return joint;
  std::vector<std::string> names;
  for (const auto& one : robot.joints) {
    if (one.type != kinematics::JointType::kFixed) names.push_back(one.name);
  }
  diagnostics.error(Code::kUnknownName, pointer, fmt::format("the URDF has no joint '{}' with a range", name),
                    nearest_choice(name, names));
  return nullptr;
}

void read_springs(ObjectReader& parent, const kinematics::RobotModel* robot, std::vector<SpringJoint>& springs) {
  const Json* json = parent.object("springs", /*required=*/false);
  if (json == nullptr || robot == nullptr) return;
  Diagnostics& diagnostics = parent.diagnostics();
  for (const auto& [name, entry] : json->items()) {
    const std::string pointer = parent.at("springs") + pointer_segment(name);
    const kinematics::Joint* joint = spring_joint(*robot, name, pointer, diagnostics);
    if (joint == nullptr) continue;
    ObjectReader reader(entry, pointer, diagnostics);
    springs.push_back(read_spring(reader, name, joint->type == kinematics::JointType::kRevolute));
    reader.finish();
    if (joint->lower > 0.0 || joint->upper < 0.0) {
      diagnostics.error(Code::kInvalidValue, pointer, fmt::format("joint '{}' cannot be at zero", name),
                        "Give a range that holds zero, where the spring rests");
    } else if (springs.back().preload > 0.0 && joint->lower != 0.0) {
      diagnostics.error(Code::kInvalidValue, pointer, fmt::format("joint '{}' has no stop at zero", name),
                        "Give the joint a range that begins at zero, or remove the preload");
    }
  }
}

void read_chamfers(ObjectReader& parent, const kinematics::RobotModel* robot, PlantDescription& plant) {
  const Json* json = parent.object("chamfers_m", /*required=*/false);
  if (json == nullptr || robot == nullptr) return;
  std::vector<std::string> links;
  for (const auto& link : robot->links) links.push_back(link.name);
  ObjectReader reader(*json, parent.at("chamfers_m"), parent.diagnostics());
  for (const auto& [link, ignored] : json->items()) {
    plant.chamfers[link] = reader.number(link, {}, kPositive);
    if (std::ranges::find(links, link) != links.end()) continue;
    parent.diagnostics().error(Code::kUnknownName, reader.at(link), fmt::format("the URDF has no link '{}'", link),
                               nearest_choice(link, links));
  }
}

void read_protective_stop(ObjectReader& parent, PlantDescription& plant) {
  const Json* json = parent.object("protective_stop", /*required=*/false);
  if (json == nullptr) return;
  ObjectReader reader(*json, parent.at("protective_stop"), parent.diagnostics());
  plant.protective_stop_off = reader.has("off");
  if (plant.protective_stop_off) {
    (void)reader.text("off");
  } else {
    plant.protective_torque = reader.numbers("external_torque_Nm", 0, {}, kPositive);
  }
  reader.finish();
}

}  // namespace

PlantDescription read_plant_keys(ObjectReader& reader, const kinematics::RobotModel* robot, const std::string& kind) {
  PlantDescription plant;
  plant.material = reader.text("material", plant.material);
  if (kind == "gripper") plant.pad_material = reader.text("pad_material", plant.pad_material);
  constexpr std::array<std::string_view, 5> kSprung = {"tool", "gripper", "force_torque_sensor", "screwdriver",
                                                       "vacuum_cup"};
  if (std::ranges::find(kSprung, kind) != kSprung.end()) read_springs(reader, robot, plant.springs);
  if (kind == "tool" || kind == "gripper") read_chamfers(reader, robot, plant);
  if (kind == "arm") read_protective_stop(reader, plant);
  return plant;
}

Eigen::Vector3d compliance_of(const kinematics::RobotModel& robot, const std::vector<SpringJoint>& springs,
                              const std::string& link) {
  Eigen::Vector3d compliance = Eigen::Vector3d::Zero();
  for (const auto* joint = robot.joint_above(link); joint != nullptr; joint = robot.joint_above(joint->parent)) {
    const auto spring = std::ranges::find(springs, joint->name, &SpringJoint::joint);
    if (spring == springs.end()) continue;
    const Eigen::Isometry3d X_LJ = pose_between(robot, link, joint->child);
    const Eigen::Vector3d axis = X_LJ.linear() * joint->axis;
    const bool turns = joint->type == kinematics::JointType::kRevolute;
    const Eigen::Vector3d way = turns ? axis.cross(-X_LJ.translation()) : axis;
    compliance += way.cwiseAbs2() / spring->stiffness;
  }
  return compliance;
}

}  // namespace takt::device
