// Kind "base": a mobile base, for the core an arm of the joints x, y, yaw (docs/devices/base.md).
#include "cell/build/arm_kind.h"
#include "cell/build/device_kinds.h"
#include "core/base/object_reader.h"
#include "core/device/base_description.h"
#include "sim/model/from_model.h"

namespace takt::cell {
namespace {

using device::BaseDescription;

/// What the scenario says of its odometry; it counts right where nothing is said.
sim::OdometryError odometry_error(const LoadedDevice& device, Diagnostics& diagnostics) {
  sim::OdometryError error;
  ObjectReader settings(device.entry->settings, device.pointer() + "/settings", diagnostics);
  if (const auto* json = settings.object("odometry", /*required=*/false)) {
    constexpr Range kScale{.low = 0.5, .high = 2.0};
    constexpr Range kDrift{.low = -1.0, .high = 1.0};
    constexpr Range kWalk{.low = 0.0, .high = 1.0};
    ObjectReader odometry(*json, settings.at("odometry"), diagnostics);
    error.linear_scale = odometry.number("linear_scale", 1.0, kScale);
    error.angular_scale = odometry.number("angular_scale", 1.0, kScale);
    error.heading_drift = odometry.number("heading_drift_rad_m", 0.0, kDrift);
    error.random_walk = odometry.number("random_walk_m_per_root_m", 0.0, kWalk);
    odometry.finish();
  }
  settings.finish();
  return error;
}

class BaseKind final : public ArmKind {
 public:
  BaseKind() : ArmKind("base") {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override { return device::read_base(folder); }

  std::optional<MountPlace> mount_place(const device::ModelDescription& model) const override {
    const auto& base = dynamic_cast<const BaseDescription&>(model);
    if (base.mount_link.empty()) return std::nullopt;
    return MountPlace{.link = base.mount_link, .X_MP = base.X_FM};
  }

  void check(const LoadedDevice& device, Diagnostics& diagnostics) const override {
    if (!device.entry->start_rad.empty()) {
      diagnostics.error(Code::kInvalidValue, device.pointer() + "/start_deg", "a base starts where it is placed",
                        "Give \"at\" instead");
    }
    if (!device.entry->own_force.empty())
      diagnostics.error(Code::kInvalidValue, device.pointer() + "/own_force", "a base feels no force", "Name an arm");
    (void)odometry_error(device, diagnostics);
  }

  void simulate(const LoadedDevice& device, sim::WorldDescription& world) const override {
    const std::string& name = device.entry->name;
    Diagnostics ignored;  // checked before
    world.arms.push_back(sim::simulated_base(name, name, *device.as<BaseDescription>()));
    world.arms.back().drive->error = odometry_error(device, ignored);
    world.arms.back().pointer = device.pointer();
    world.arms.back().payload_mass_error = device.entry->payload_error_kg;
  }
};

}  // namespace

std::unique_ptr<DeviceKind> base_kind() { return std::make_unique<BaseKind>(); }

}  // namespace takt::cell
