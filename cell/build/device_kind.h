#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cell/file/description.h"
#include "core/base/form.h"
#include "core/device/description.h"
#include "core/expression/cell.h"
#include "sim/model/world_description.h"

namespace takt::cell {

class DeviceKind;
struct BuiltCell;

using ModelPointer = std::shared_ptr<const device::ModelDescription>;

/// A device of the scenario with its kind and model, and how it hangs on others.
struct LoadedDevice {
  const DeviceEntry* entry = nullptr;
  const DeviceKind* kind = nullptr;
  ModelPointer model;
  const LoadedDevice* on = nullptr;  ///< what it is mounted on; null: placed in a frame

  /// The model as its kind knows it; null if it is of another kind.
  template <class Model>
  [[nodiscard]] std::shared_ptr<const Model> as() const {
    return std::dynamic_pointer_cast<const Model>(model);
  }
  [[nodiscard]] std::string pointer() const { return "/devices" + pointer_segment(entry->name); }
};

/// All devices of a cell; those that carry come before those that they carry.
using LoadedDevices = std::span<const std::unique_ptr<LoadedDevice>>;

/// Where the next part is screwed on.
struct MountPlace {
  std::string link;                                        ///< that carries it
  Eigen::Isometry3d X_LP = Eigen::Isometry3d::Identity();  ///< the place in that link, m
  Eigen::Isometry3d X_MP = Eigen::Isometry3d::Identity();  ///< the place in the device's own mount frame, m; of what
                                                           ///< moves (arm, base) in its flange, where its chain ends
};

/// A kind of device: what the builder of a cell asks for, from the model's file to the canonical device in the core.
/// One object serves all devices of the kind and has no state. Calls come in the order of the members. Realtime: setup.
///
/// Our own kinds and those of plug-ins use the same way (docs/plugins.md): nothing else knows a list of kinds.
class DeviceKind {
 public:
  /// @param name  as "kind" in a device file says
  /// @param settings  what "settings" of its devices may say (docs/tables.md)
  explicit DeviceKind(std::string name, Form settings = {}) : name_(std::move(name)), settings_(std::move(settings)) {
    settings_.definition = name_ + "_settings";
  }
  virtual ~DeviceKind() = default;
  DeviceKind(const DeviceKind&) = delete;
  DeviceKind& operator=(const DeviceKind&) = delete;
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const Form& settings() const { return settings_; }

  // -- What it is ----------------------------------------------------------------------------------------------------
  /// Reads the device file and the URDF in this folder; all diagnostics at once, with the file in them.
  [[nodiscard]] virtual Result<ModelPointer> read(const std::filesystem::path& folder) const = 0;
  /// True if it works only mounted on an arm, directly or through others.
  [[nodiscard]] virtual bool needs_arm() const { return false; }
  /// True if it stands on a back end that a site can make slow (docs/sites.md).
  [[nodiscard]] virtual bool has_backend() const { return false; }
  /// Nothing: it carries no other device.
  [[nodiscard]] virtual std::optional<MountPlace> mount_place(const device::ModelDescription&) const { return {}; }
  /// Its tool centre point in its own mount frame, m. Nothing: it is no tool. The builder of a cell makes what has one
  /// a tool of its arm (Cell::tools), with the frames "NAME" and "NAME/tcp".
  [[nodiscard]] virtual std::optional<Eigen::Isometry3d> tcp(const device::ModelDescription&) const { return {}; }
  /// What is at its tool centre point. By default nothing that matters.
  [[nodiscard]] virtual device::ToolTip tip(const device::ModelDescription&) const { return {}; }
  /// The names that a program may use, before anything is built.
  /// @param model  null where it cannot be read
  virtual void declare(const DeviceEntry& entry, const device::ModelDescription* model, expression::Cell& cell) const;

  // -- In the simulation ---------------------------------------------------------------------------------------------
  /// Checks what the scenario says of one device beyond its model: `settings`, `start_deg`. By default it has no
  /// joints, and settings are refused if the kind has none.
  virtual void check(const LoadedDevice& device, Diagnostics& diagnostics) const;
  /// Its body. By default the URDF as it stands.
  [[nodiscard]] virtual sim::RobotDescription body(const LoadedDevice& device, sim::Mount mount) const;
  /// Adds what makes it work: its simulated counterpart.
  virtual void simulate(const LoadedDevice& device, sim::WorldDescription& world) const;

  // -- In the core ---------------------------------------------------------------------------------------------------
  /// Makes the canonical device on the back end that the world now has, gives it to the core, and tells the cell.
  virtual void add(const LoadedDevice& device, LoadedDevices all, BuiltCell& built) const;

 private:
  std::string name_;
  Form settings_;
};

/// Reads the settings of a device by the form of its kind; what is none of them is a diagnostic at the end.
class SettingsReader : public FormReader {
 public:
  SettingsReader(const LoadedDevice& device, Diagnostics& diagnostics)
      : FormReader(device.kind->settings(), object_),
        object_(device.entry->settings, device.pointer() + "/settings", diagnostics) {}
  SettingsReader(const SettingsReader&) = delete;
  SettingsReader& operator=(const SettingsReader&) = delete;
  ~SettingsReader() { object_.finish(); }

 private:
  ObjectReader object_;
};

}  // namespace takt::cell
