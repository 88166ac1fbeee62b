// Kind "arm".
#include "cell/build/arm_kind.h"

#include <algorithm>

#include <fmt/format.h>

#include "cell/build/built_cell.h"
#include "cell/build/cell_models.h"
#include "cell/build/command_tape.h"
#include "cell/build/device_kinds.h"
#include "cell/build/faulty_machines.h"
#include "cell/build/site_devices.h"
#include "cell/file/degrees.h"
#include "core/device/arm_force.h"
#include "core/device/device_file.h"
#include "core/device/plant_of_model.h"
#include "core/kinematics/joint_range.h"
#include "sim/model/description_check.h"
#include "sim/model/from_model.h"

namespace takt::cell {
namespace {

using device::ArmDescription;

/// Of the effort limits: external torques at which an arm stops whose device file says nothing.
constexpr double kProtectiveShare = 0.5;

/// A sensor in the flange. The load that the controller knows is no external torque, so nothing is to be taken out.
void add_own_force(const DeviceEntry& entry, const device::Arm& arm, BuiltCell& built) {
  if (entry.own_force.empty()) return;
  auto felt = built.site->own_force(entry.name);
  if (felt == nullptr) felt = std::make_shared<device::ArmForce>(arm);
  auto& sensor = built.core->add(
      std::make_unique<device::ForceTorqueSensor>(entry.own_force, device::arm_force_description(arm.description()),
                                                  built.commands->samples().tap(entry.own_force, std::move(felt))));
  expression::MountedSensor& mounted = built.cell.sensors[entry.own_force];
  mounted.device = &sensor;
  mounted.arm = entry.name;
}

}  // namespace

kinematics::JointVector start_of(const LoadedDevice& device) {
  const auto& wanted = device.entry->start_rad;  // check() reports what does not fit
  const kinematics::JointVector& home = device.as<ArmDescription>()->home;
  const auto count = static_cast<Eigen::Index>(wanted.size());
  if (count != home.size()) return home;
  const kinematics::JointVector q = Eigen::Map<const Eigen::VectorXd>(wanted.data(), count);
  const motion::JointLimits& limits = device.as<ArmDescription>()->limits;
  return kinematics::into_range(q, limits.lower, limits.upper);
}

Result<ModelPointer> ArmKind::read(const std::filesystem::path& folder) const { return device::read_arm(folder); }

std::optional<MountPlace> ArmKind::mount_place(const device::ModelDescription& model) const {
  return MountPlace{.link = dynamic_cast<const ArmDescription&>(model).flange_link};
}

void ArmKind::declare(const DeviceEntry& entry, const device::ModelDescription*, expression::Cell& cell) const {
  cell.arms[entry.name];
  if (!entry.own_force.empty()) cell.sensors[entry.own_force].arm = entry.name;
}

void ArmKind::check(const LoadedDevice& device, Diagnostics& diagnostics) const {
  const ArmDescription& arm = *device.as<ArmDescription>();
  if (!device.entry->settings.empty())
    diagnostics.error(Code::kInvalidValue, device.pointer() + "/settings", "an arm has no settings", "Remove them");
  const auto& wanted = device.entry->start_rad;
  const std::string pointer = device.pointer() + "/start_deg";
  const auto count = static_cast<std::size_t>(arm.home.size());
  if (!wanted.empty() && wanted.size() != count) {
    return diagnostics.error(Code::kWrongSize, pointer,
                             fmt::format("{} numbers for an arm of {} joints", wanted.size(), count));
  }
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    if (kinematics::is_in_range(wanted[i], arm.limits.lower[j], arm.limits.upper[j])) continue;
    diagnostics.error(
        Code::kOutOfRange, pointer + pointer_segment(i),
        fmt::format("{:g} deg for joint {}", wanted[i] / kDegree, arm.joint_names[i]),
        fmt::format("Choose {:g} to {:g} deg", arm.limits.lower[j] / kDegree, arm.limits.upper[j] / kDegree));
  }
}

sim::RobotDescription ArmKind::body(const LoadedDevice& device, sim::Mount mount) const {
  const ArmDescription& arm = *device.as<ArmDescription>();
  sim::RobotDescription robot = sim::arm_body(device.entry->name, arm, std::move(mount));
  const kinematics::JointVector q = start_of(device);
  const auto joints = sim::movable_joints(*arm.robot);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto at = std::ranges::find(arm.joint_names, joints[i]->name);
    if (at != arm.joint_names.end()) robot.q[i] = q[at - arm.joint_names.begin()];
  }
  return robot;
}

void ArmKind::simulate(const LoadedDevice& device, sim::WorldDescription& world) const {
  const std::string& name = device.entry->name;
  world.arms.push_back(sim::simulated_arm(name, name, *device.as<ArmDescription>()));
  world.arms.back().pointer = device.pointer();
  world.arms.back().payload_mass_error = device.entry->payload_error_kg;
  // What is wrong with the file was found when the model was read.
  const device::PlantDescription plant = device::read_plant(*device.model).value_or(device::PlantDescription{});
  if (plant.protective_stop_off) return;
  const kinematics::JointVector& effort = device.as<ArmDescription>()->effort;
  kinematics::JointVector& limit = world.arms.back().control.protective_torque;
  limit = kProtectiveShare * effort;
  if (!plant.protective_torque.empty()) {
    limit = Eigen::Map<const Eigen::VectorXd>(plant.protective_torque.data(),
                                              static_cast<Eigen::Index>(plant.protective_torque.size()));
  }
}

void ArmKind::add(const LoadedDevice& device, LoadedDevices, BuiltCell& built) const {
  const std::string& name = device.entry->name;
  auto wired = built.site->wire(device, built.borrowed<device::ArmBackend>(built.world->arm(name)));
  if (device.entry->may_fail) wired.backend = built.with_faults<FaultyArm>(name, std::move(wired.backend));
  auto backend = built.commands->tap(name, std::move(wired.backend), static_cast<int>(wired.description->home.size()));
  auto& arm =
      built.core->add(std::make_unique<device::Arm>(name, wired.description, std::move(backend), built.core->period()));
  expression::MountedArm mounted;
  mounted.device = &arm;
  mounted.start = start_of(device);
  // A base drives on the level, so what stands on it keeps this.
  mounted.gravity_B = built.true_start(name).linear().transpose() * built.cell.gravity_W;
  built.cell.arms[name] = mounted;
  add_own_force(*device.entry, arm, built);
}

std::unique_ptr<DeviceKind> arm_kind() { return std::make_unique<ArmKind>(); }

}  // namespace takt::cell
