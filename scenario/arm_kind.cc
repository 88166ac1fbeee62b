// Kind "arm".
#include <numbers>

#include <fmt/format.h>

#include "core/device/device_file.h"
#include "scenario/cell_builder.h"
#include "scenario/device_kinds.h"
#include "sim/from_model.h"

namespace takt::scenario {
namespace {

using device::ArmDescription;

/// What the scenario says, if it fits the arm; check() reports what does not.
kinematics::JointVector start_of(const LoadedDevice& device) {
  const auto& wanted = device.entry->start_rad;
  const kinematics::JointVector& home = device.as<ArmDescription>()->home;
  const auto count = static_cast<Eigen::Index>(wanted.size());
  if (count != home.size()) return home;
  return Eigen::Map<const Eigen::VectorXd>(wanted.data(), count);
}

class ArmKind final : public DeviceKind {
 public:
  ArmKind() : DeviceKind("arm") {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override { return device::read_arm(folder); }

  bool has_backend() const override { return true; }

  std::optional<MountPlace> mount_place(const device::ModelDescription& model) const override {
    return MountPlace{.link = dynamic_cast<const ArmDescription&>(model).flange_link};
  }

  void declare(const DeviceEntry& entry, const device::ModelDescription*, command::Cell& cell) const override {
    cell.arms[entry.name];
  }

  void check(const LoadedDevice& device, Findings& findings) const override {
    const ArmDescription& arm = *device.as<ArmDescription>();
    if (!device.entry->settings.empty()) findings.error(device.pointer() + "/settings", "an arm has no settings");
    const auto& wanted = device.entry->start_rad;
    const std::string pointer = device.pointer() + "/start_deg";
    const auto count = static_cast<std::size_t>(arm.home.size());
    if (!wanted.empty() && wanted.size() != count) {
      return findings.error(pointer, fmt::format("{} numbers for an arm of {} joints", wanted.size(), count));
    }
    constexpr double kDegree = std::numbers::pi / 180.0;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const auto j = static_cast<Eigen::Index>(i);
      if (wanted[i] >= arm.limits.lower[j] && wanted[i] <= arm.limits.upper[j]) continue;
      findings.error(pointer + pointer_segment(i),
                     fmt::format("{:g} deg for joint {}", wanted[i] / kDegree, arm.joint_names[i]),
                     fmt::format("{:g} to {:g} deg", arm.limits.lower[j] / kDegree, arm.limits.upper[j] / kDegree));
    }
  }

  sim::RobotDescription body(const LoadedDevice& device, sim::Mount mount) const override {
    sim::RobotDescription robot = sim::arm_body(device.entry->name, *device.as<ArmDescription>(), std::move(mount));
    const kinematics::JointVector q = start_of(device);
    robot.q.assign(q.data(), q.data() + q.size());
    return robot;
  }

  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override {
    const std::string& name = device.entry->name;
    world.arms.push_back(sim::simulated_arm(name, name, *device.as<ArmDescription>()));
    world.arms.back().pointer = device.pointer();
    world.arms.back().payload_mass_error = device.entry->payload_error_kg;
  }

  void add(const LoadedDevice& device, LoadedDevices, BuiltCell& built) const override {
    const std::string& name = device.entry->name;
    auto wired = built.site->wire(device, built.borrowed<device::ArmBackend>(built.world->arm(name)));
    auto& arm = built.core->add(
        std::make_unique<device::Arm>(name, wired.description, std::move(wired.backend), built.core->period()));
    command::MountedArm mounted;
    mounted.device = &arm;
    mounted.start = start_of(device);
    if (const auto X_WB = built.cell.frames.pose(name))
      mounted.gravity_B = X_WB->linear().transpose() * built.cell.gravity_W;
    built.cell.arms[name] = mounted;
  }
};

}  // namespace

std::unique_ptr<DeviceKind> arm_kind() { return std::make_unique<ArmKind>(); }

}  // namespace takt::scenario
