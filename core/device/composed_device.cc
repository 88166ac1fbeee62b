#include "core/device/composed_device.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::device {
namespace {

void collect_leaves(std::span<net::Resource* const> parts, std::vector<net::Resource*>& leaves) {
  for (net::Resource* part : parts) {
    if (const auto* whole = dynamic_cast<const net::Composite*>(part)) {
      collect_leaves(whole->parts(), leaves);
    } else {
      leaves.push_back(part);
    }
  }
}

}  // namespace

Result<std::unique_ptr<ComposedDevice>> ComposedDevice::make(std::string name, std::vector<net::Resource*> parts) {
  if (parts.empty())
    return failure(Code::kMissing, "", fmt::format("'{}' has no parts", name), "Name at least one device");
  std::vector<net::Resource*> leaves;
  collect_leaves(parts, leaves);
  auto sorted = leaves;
  std::ranges::sort(sorted);
  if (std::ranges::adjacent_find(sorted) != sorted.end())
    return failure(Code::kDuplicate, "", fmt::format("'{}' contains a device twice", name),
                   "Name each part once, also inside other wholes");
  return std::unique_ptr<ComposedDevice>(new ComposedDevice(std::move(name), std::move(parts), std::move(leaves)));
}

}  // namespace takt::device
