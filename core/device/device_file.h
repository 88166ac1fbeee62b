#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/device/description.h"
#include "core/device/gripper.h"

namespace takt::device {

/// Reads <folder>/device.json and the URDF that it names. All diagnostics at once, each with file, JSON pointer, value
/// and what is allowed; unknown keys are errors with the nearest known one. Format: schemas/device.schema.json.
/// Realtime: setup.
[[nodiscard]] Result<std::shared_ptr<const ArmDescription>> read_arm(const std::filesystem::path& folder);
[[nodiscard]] Result<std::shared_ptr<const ForceTorqueDescription>> read_force_torque_sensor(
    const std::filesystem::path& folder);
[[nodiscard]] Result<std::shared_ptr<const ToolDescription>> read_tool(const std::filesystem::path& folder);
[[nodiscard]] Result<std::shared_ptr<const GripperDescription>> read_gripper(const std::filesystem::path& folder);
[[nodiscard]] Result<std::shared_ptr<const IoDescription>> read_io(const std::filesystem::path& folder);
[[nodiscard]] Result<std::shared_ptr<const BeamDescription>> read_light_barrier(const std::filesystem::path& folder);
[[nodiscard]] Result<std::shared_ptr<const BeamDescription>> read_range_finder(const std::filesystem::path& folder);

/// The text of "kind" in <folder>/device.json: "arm", "force_torque_sensor", "tool", ... Whether there is such a kind
/// is for the registry of kinds to say. Realtime: setup.
[[nodiscard]] Result<std::string> read_device_kind(const std::filesystem::path& folder);

/// Finds models by name in a list of folders; the first that holds <name>/device.json wins.
class ModelLibrary {
 public:
  explicit ModelLibrary(std::vector<std::filesystem::path> paths) : paths_(std::move(paths)) {}

  /// This library, and before it the models that lie beside a file: in its folder, and in "models" there. The same for
  /// no file. Realtime: setup.
  [[nodiscard]] ModelLibrary beside(const std::filesystem::path& file) const;
  /// @return the model's folder; or a diagnostic with the names of all models and the folders that were searched. A
  /// name is one path segment.
  [[nodiscard]] Result<std::filesystem::path> find(std::string_view name, const std::string& pointer = {}) const;
  /// All model names in the order of the alphabet.
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  std::vector<std::filesystem::path> paths_;
};

}  // namespace takt::device
