// Kind "tool": passive, it gives an arm its tool centre point.
#include "core/device/device_file.h"
#include "scenario/cell_builder.h"
#include "scenario/cell_models.h"
#include "scenario/device_kinds.h"

namespace takt::scenario {
namespace {

using device::ToolDescription;

class ToolKind final : public DeviceKind {
 public:
  ToolKind() : DeviceKind("tool") {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override { return device::read_tool(folder); }
  bool needs_arm() const override { return true; }

  /// The tool centre point of the arm that carries it, through whatever is between.
  void add(const LoadedDevice& device, LoadedDevices, BuiltCell& built) const override {
    const auto model = device.as<ToolDescription>();
    command::MountedArm& arm = built.cell.arms[carrying_arm(device)->entry->name];
    arm.X_FT = pose_on_arm(device) * model->X_MT;
    arm.ball_radius = model->ball_radius;
  }
};

}  // namespace

std::unique_ptr<DeviceKind> tool_kind() { return std::make_unique<ToolKind>(); }

}  // namespace takt::scenario
