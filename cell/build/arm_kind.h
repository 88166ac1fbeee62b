#pragma once

#include <string>

#include "cell/build/device_kind.h"
#include "cell/file/description.h"

namespace takt::cell {

/// Kind "arm": what is driven by set points of its joints. Other kinds that are, a mobile base, build on it.
class ArmKind : public DeviceKind {
 public:
  explicit ArmKind(std::string name = "arm", Form settings = {}) : DeviceKind(std::move(name), std::move(settings)) {}

  [[nodiscard]] Result<ModelPointer> read(const std::filesystem::path& folder) const override;
  [[nodiscard]] bool has_backend() const override { return true; }
  [[nodiscard]] std::optional<MountPlace> mount_place(const device::ModelDescription& model) const override;
  void declare(const DeviceEntry& entry, const device::ModelDescription* model, expression::Cell& cell) const override;
  void check(const LoadedDevice& device, Diagnostics& diagnostics) const override;
  [[nodiscard]] sim::RobotDescription body(const LoadedDevice& device, sim::Mount mount) const override;
  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override;
  void add(const LoadedDevice& device, LoadedDevices all, BuiltCell& built) const override;
};

/// Where an arm or base stands at the start, rad or m: as the scenario says, if that fits the arm, else at its home.
[[nodiscard]] kinematics::JointVector start_of(const LoadedDevice& device);

}  // namespace takt::cell
