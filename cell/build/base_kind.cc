// Kind "base": a mobile base, for the core an arm of the joints x, y, yaw (docs/devices/base.md).
#include "cell/build/arm_kind.h"
#include "cell/build/device_kinds.h"
#include "core/base/form_of.h"
#include "core/device/base_description.h"
#include "sim/model/from_model.h"

namespace takt::cell {
namespace {

using device::BaseDescription;

const FormOf<sim::OdometryError>& odometry_form() {
  using Error = sim::OdometryError;
  constexpr Range kScale{.low = 0.5, .high = 2.0};
  static const auto form =
      FormOf<Error>("", "Errors of the odometry; it counts right where nothing is said (docs/devices/base.md).")
          .add(number_key("linear_scale", "", kScale, "What it counts of the true way.").optional(),
               &Error::linear_scale)
          .add(number_key("angular_scale", "", kScale, "What it counts of the true turn.").optional(),
               &Error::angular_scale)
          .add(number_key("heading_drift_rad_m", "rad/m", {.low = -1.0, .high = 1.0}, "Turn that it does not see.")
                   .optional(),
               &Error::heading_drift)
          .add(number_key("random_walk_m_per_root_m", "m per root of m", {.low = 0.0, .high = 1.0},
                          "Sigma of its random walk.")
                   .optional(),
               &Error::random_walk);
  return form;
}

sim::OdometryError odometry_error(const LoadedDevice& device, Diagnostics& diagnostics) {
  SettingsReader from(device, diagnostics);
  const auto* json = from.json("odometry");
  return json ? odometry_form().read(*json, from.at("odometry"), diagnostics) : sim::OdometryError{};
}

class BaseKind final : public ArmKind {
 public:
  BaseKind()
      : ArmKind("base",
                {.doc = "A mobile base.", .keys = {object_key("odometry", odometry_form().form(), "").optional()}}) {}

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
