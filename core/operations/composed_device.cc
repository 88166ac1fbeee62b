#include "core/operations/composed_device.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace takt::activity {
namespace {

std::vector<std::string> names_of(const auto& actuators) {
  std::vector<std::string> names;
  for (const auto& one : actuators) {
    if constexpr (std::is_pointer_v<std::remove_cvref_t<decltype(one)>>) {
      names.push_back(one->name());
    } else {
      names.push_back(one.name());
    }
  }
  return names;
}

[[noreturn]] void refuse_device(Code code, const std::string& device, std::string message, std::string hint) {
  Diagnostics why;
  why.error(code, pointer_segment(device), std::move(message), std::move(hint));
  throw ActivityError(std::move(why));
}

}  // namespace

ComposedDevice::ComposedDevice(std::string name, std::vector<Actuator> parts)
    : name_(std::move(name)), parts_(std::move(parts)) {
  if (parts_.empty()) refuse_device(Code::kMissing, name_, "a device without parts", "at least one actuator");
  for (auto part = parts_.begin(); part != parts_.end(); ++part) {
    if (std::any_of(parts_.begin(), part, [&](const Actuator& other) { return other.name() == part->name(); }))
      refuse_device(Code::kDuplicate, name_, fmt::format("'{}' is a part of '{}' twice", part->name(), name_),
                    "each actuator once");
    if (&part->runtime() != &parts_.front().runtime())
      refuse_device(Code::kConflict, name_,
                    fmt::format("'{}' belongs to another runtime than '{}'", part->name(), parts_.front().name()),
                    "actuators of one Runtime");
  }
}

const Actuator& ComposedDevice::part(const std::string& name) const {
  const auto found = std::ranges::find(parts_, name, [](const Actuator& one) { return one.name(); });
  if (found == parts_.end())
    refuse_device(Code::kUnknownName, name_, fmt::format("'{}' has no part '{}'", name_, name),
                  nearest_choice(name, names_of(parts_)));
  return *found;
}

std::vector<const Actuator*> ComposedDevice::offering(OfferedBy offered_by) const {
  std::vector<const Actuator*> all;
  for (const Actuator& part : parts_)
    if (offered_by(part.runtime().cell(), part.name())) all.push_back(&part);
  return all;
}

const Actuator& ComposedDevice::the_one(std::string_view interface, OfferedBy offered_by) const {
  const auto all = offering(offered_by);
  if (all.empty())
    refuse_device(Code::kUnsupported, name_, fmt::format("no part of '{}' has {}", name_, interface),
                  fmt::format("they offer {}", fmt::join(interfaces(), ", ")));
  if (all.size() > 1)
    refuse_device(Code::kConflict, name_, fmt::format("{} parts of '{}' have {}", all.size(), name_, interface),
                  fmt::format("part() of one of {}", fmt::join(names_of(all), ", ")));
  return *all.front();
}

std::vector<std::string> ComposedDevice::interfaces() const {
  std::vector<std::string> all;
  std::map<std::string, int> counts;
  for (const Actuator& part : parts_)
    for (std::string& one : part.interfaces())
      if (++counts[one] == 1) all.push_back(std::move(one));
  std::erase_if(all, [&](const std::string& one) { return counts[one] > 1; });
  return all;
}

std::vector<const Actuator*> ComposedDevice::arms() const { return offering(&PtpInterface::offered_by); }

void ComposedDevice::set_speed(double rate) const {
  for (const Actuator* arm : arms()) arm->set_speed(rate);
}
void ComposedDevice::pause() const {
  for (const Actuator* arm : arms()) arm->pause();
}
void ComposedDevice::resume() const {
  for (const Actuator* arm : arms()) arm->resume();
}

}  // namespace takt::activity
