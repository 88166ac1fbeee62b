// Kind "fan": from the model's file to the device in the core, and the simulated fan.
#include <nlohmann/json.hpp>

#include "cell/build/cell_builder.h"
#include "cell/build/device_kind_registry.h"
#include "core/base/json.h"
#include "core/base/object_reader.h"
#include "core/kinematics/robot_model.h"
#include "fan.h"
#include "sim_fan.h"

namespace fan {
namespace {

using namespace takt;

class FanKind final : public cell::DeviceKind {
 public:
  FanKind()
      : DeviceKind(std::string(Fan::kKind), {.doc = "A fan.",
                                             .keys = {number_key("speed_rad_s", "rad/s", kNotNegative,
                                                                 "Speed before the program, at most that of the model.")
                                                          .by_default(0.0)}}) {}

  Result<cell::ModelPointer> read(const std::filesystem::path& folder) const override {
    const std::filesystem::path file = folder / "device.json";
    const auto json = read_json(file);
    if (!json) return std::unexpected(json.error());
    Diagnostics diagnostics;
    ObjectReader reader(*json, "", diagnostics);
    FanDescription fan;
    (void)reader.choice("kind", {name()});
    fan.model = reader.text("name");
    fan.title = reader.text("title", "");
    fan.folder = folder;
    fan.urdf = folder / reader.text("urdf");
    fan.speed_max = reader.number("speed_max_rad_s", {}, kPositive);
    fan.time_constant = reader.number("time_constant_s", {}, kPositive);
    reader.finish();
    diagnostics.set_file(file.string());
    auto robot = kinematics::RobotModel::load(fan.urdf);
    if (robot) fan.robot = std::make_shared<const kinematics::RobotModel>(std::move(*robot));
    if (!robot) diagnostics.append(robot.error());
    if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
    return std::make_shared<const FanDescription>(std::move(fan));
  }

  void check(const cell::LoadedDevice& device, Diagnostics& diagnostics) const override {
    DeviceKind::check(device, diagnostics);
    (void)speed(device, diagnostics);
  }

  void simulate(const cell::LoadedDevice& device, sim::WorldDescription& world) const override {
    const double time_constant = device.as<FanDescription>()->time_constant;
    Diagnostics ignored;  // checked before
    const double speed = FanKind::speed(device, ignored);
    world.devices.push_back(
        {.name = device.entry->name,
         .pointer = device.pointer(),
         .extend = {},
         .make = [=](const mjModel_&, const sim::WorldDescription&) -> Result<std::unique_ptr<sim::SimDevice>> {
           return std::make_unique<SimFan>(time_constant, speed);
         }});
  }

  void add(const cell::LoadedDevice& device, cell::LoadedDevices, cell::BuiltCell& built) const override {
    const std::string& name = device.entry->name;
    auto backend = built.borrowed<FanBackend>(dynamic_cast<SimFan*>(built.world->device(name)));
    built.core->add(std::make_unique<Fan>(name, device.as<FanDescription>(), std::move(backend)));
  }

 private:
  static double speed(const cell::LoadedDevice& device, Diagnostics& diagnostics) {
    cell::SettingsReader from(device, diagnostics);
    return from.number_up_to("speed_rad_s", device.as<FanDescription>()->speed_max, 0.0);
  }
};

TAKT_DEVICE_KIND(FanKind);

}  // namespace
}  // namespace fan
