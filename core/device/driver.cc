#include "core/device/driver.h"

#include <algorithm>

namespace takt::device {

std::string_view name_of(BackendMode reality) {
  if (reality == BackendMode::kSimulated) return "SIM";
  return reality == BackendMode::kEmulated ? "EMULATED" : "HARDWARE";
}

DriverKinds& DriverKinds::global() {
  static DriverKinds kinds;
  return kinds;
}

void DriverKinds::add(std::unique_ptr<DriverKind> kind) {
  if (find(kind->name()) == nullptr) kinds_.push_back(std::move(kind));
}

const DriverKind* DriverKinds::find(std::string_view name) const {
  const auto found = std::ranges::find_if(kinds_, [&](const auto& kind) { return kind->name() == name; });
  return found == kinds_.end() ? nullptr : found->get();
}

}  // namespace takt::device
