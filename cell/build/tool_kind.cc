// Kind "tool": passive, it gives an arm its tool centre point.
#include "cell/build/device_kinds.h"
#include "core/device/device_file.h"

namespace takt::cell {
namespace {

using device::ToolDescription;

class ToolKind final : public DeviceKind {
 public:
  ToolKind() : DeviceKind("tool") {}

  Result<ModelPointer> read(const std::filesystem::path& folder) const override { return device::read_tool(folder); }
  bool needs_arm() const override { return true; }

  std::optional<Eigen::Isometry3d> tcp(const device::ModelDescription& model) const override {
    return dynamic_cast<const ToolDescription&>(model).X_MT;
  }
  device::ToolTip tip(const device::ModelDescription& model) const override {
    return dynamic_cast<const ToolDescription&>(model).tip;
  }
};

}  // namespace

std::unique_ptr<DeviceKind> tool_kind() { return std::make_unique<ToolKind>(); }

}  // namespace takt::cell
