#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/net/composite.h"

namespace takt::device {

/// Several devices under one name, an arm with its gripper: controllable by part, under the names of the parts, or as a
/// whole (docs/devices.md, "Composed devices"). It has no sample and no guard of its own: those are its parts'.
class ComposedDevice final : public net::Composite {
 public:
  static constexpr std::string_view kKind = "composed_device";

  /// @param parts  at least one, made before it; owned by the core, as this one is
  /// @return the device, or a diagnostic for a part that stands in it twice, directly or through others. Realtime:
  /// setup.
  [[nodiscard]] static Result<std::unique_ptr<ComposedDevice>> make(std::string name,
                                                                    std::vector<net::Resource*> parts);

  [[nodiscard]] std::string_view kind() const override { return kKind; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::span<net::Resource* const> parts() const override { return parts_; }
  /// The devices that it is made of in the end. Realtime: cyclic.
  [[nodiscard]] std::span<net::Resource* const> leaves() const { return leaves_; }

 private:
  ComposedDevice(std::string name, std::vector<net::Resource*> parts, std::vector<net::Resource*> leaves)
      : name_(std::move(name)), parts_(std::move(parts)), leaves_(std::move(leaves)) {}

  std::string name_;
  std::vector<net::Resource*> parts_, leaves_;
};

}  // namespace takt::device
