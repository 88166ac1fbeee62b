#include "cell/build/device_kind_registry.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

#include "cell/build/device_kinds.h"
#include "core/device/device_file.h"

namespace takt::cell {

DeviceKinds& DeviceKinds::global() {
  static DeviceKinds kinds;
  return kinds;
}

DeviceKinds::DeviceKinds() {
  for (auto& kind : own_device_kinds()) add(std::move(kind));
}

void DeviceKinds::add(std::unique_ptr<DeviceKind> kind) {
  const auto place = std::ranges::lower_bound(kinds_, kind->name(), {}, [](const auto& one) { return one->name(); });
  if (place != kinds_.end() && (*place)->name() == kind->name()) {
    std::fprintf(stderr, "takt: device kind %s is registered twice\n", kind->name().c_str());
    std::abort();
  }
  kinds_.insert(place, std::move(kind));
}

const DeviceKind* DeviceKinds::find(std::string_view name) const {
  const auto found = std::ranges::find(kinds_, name, [](const auto& one) -> std::string_view { return one->name(); });
  return found == kinds_.end() ? nullptr : found->get();
}

std::vector<std::string> DeviceKinds::names() const {
  std::vector<std::string> names;
  for (const auto& kind : kinds_) names.push_back(kind->name());
  return names;
}

Diagnostics DeviceKindRegistration::check() const {
  Diagnostics diagnostics;
  if (name_.empty()) diagnostics.error(Code::kMissing, "", "a device kind has no name");
  if (DeviceKinds::global().find(name_)) {
    diagnostics.error(Code::kDuplicate, "", fmt::format("device kind '{}' is registered already", name_),
                      "Choose another name");
  }
  return diagnostics;
}

Result<ReadModel> read_model(const std::filesystem::path& folder, const std::string& pointer) {
  const auto name = device::read_device_kind(folder);
  if (!name) return std::unexpected(name.error());
  const DeviceKind* kind = DeviceKinds::global().find(*name);
  if (!kind) {
    return failure(
        Code::kInvalidValue, pointer,
        fmt::format("model '{}' is of kind '{}', which is not a device of a cell", folder.filename().string(), *name),
        nearest_choice(*name, DeviceKinds::global().names()));
  }
  auto model = kind->read(folder);
  if (!model) return std::unexpected(std::move(model.error()));
  return ReadModel{kind, std::move(*model)};
}

}  // namespace takt::cell
