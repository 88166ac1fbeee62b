#include "app/interfaces/composed_device.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace takt::app {
namespace {

std::vector<std::string> names_of(const std::vector<const Actuator*>& actuators) {
  std::vector<std::string> names;
  for (const Actuator* one : actuators) names.push_back(one->name());
  return names;
}

std::vector<std::string> roles_of(const std::vector<DevicePart>& parts) {
  std::vector<std::string> roles;
  for (const DevicePart& one : parts) roles.push_back(one.role);
  return roles;
}

std::vector<DevicePart> parts_of(std::initializer_list<Actuator> actuators) {
  std::vector<DevicePart> parts;
  for (const Actuator& one : actuators) parts.push_back({one.name(), one});
  return parts;
}

[[noreturn]] void refuse_device(Code code, const std::string& device, std::string message, std::string hint) {
  Diagnostics why;
  why.error(code, pointer_segment(device), std::move(message), std::move(hint));
  throw activity::ActivityError(std::move(why));
}

}  // namespace

ComposedDevice::ComposedDevice(std::string name, std::initializer_list<Actuator> parts)
    : ComposedDevice(std::move(name), parts_of(parts)) {}

ComposedDevice::ComposedDevice(std::string name, std::vector<DevicePart> parts)
    : name_(std::move(name)), parts_(std::move(parts)) {
  if (parts_.empty()) refuse_device(Code::kMissing, name_, "a device without parts", "add at least one actuator");
  activity::Runtime& runtime = parts_.front().actuator.runtime();
  for (auto part = parts_.begin(); part != parts_.end(); ++part) {
    const std::string& own = part->actuator.name();
    if (std::any_of(parts_.begin(), part, [&](const DevicePart& other) { return other.actuator.name() == own; }))
      refuse_device(Code::kDuplicate, name_, fmt::format("'{}' is a part of '{}' twice", own, name_),
                    "name each actuator once");
    if (std::any_of(parts_.begin(), part, [&](const DevicePart& other) { return other.role == part->role; }))
      refuse_device(Code::kDuplicate, name_, fmt::format("'{}' has two parts '{}'", name_, part->role),
                    "give each part a role of its own");
    if (&part->actuator.runtime() != &runtime)
      refuse_device(Code::kConflict, name_,
                    fmt::format("'{}' belongs to another runtime than '{}'", own, parts_.front().actuator.name()),
                    "use actuators of one Runtime");
  }
}

const Actuator* ComposedDevice::find(const std::string& role) const {
  for (const DevicePart& one : parts_)
    if (one.role == role) return &one.actuator;
  for (const DevicePart& one : parts_)
    if (one.actuator.name() == role) return &one.actuator;
  return nullptr;
}

const Actuator& ComposedDevice::part(const std::string& role) const {
  if (const Actuator* found = find(role)) return *found;
  refuse_device(Code::kUnknownName, name_, fmt::format("'{}' has no part '{}'", name_, role),
                nearest_choice(role, roles_of(parts_)));
}

void ComposedDevice::refuse(std::string_view interface) const {
  refuse_device(Code::kUnsupported, name_, fmt::format("'{}' has no {}", name_, interface),
                fmt::format("its parts are {}", fmt::join(roles_of(parts_), ", ")));
}

std::vector<const Actuator*> ComposedDevice::offering(OfferedBy offered_by) const {
  std::vector<const Actuator*> all;
  for (const DevicePart& one : parts_)
    if (offered_by(one.actuator.runtime().cell(), one.actuator.name())) all.push_back(&one.actuator);
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
  for (const DevicePart& part : parts_)
    for (std::string& one : part.actuator.interfaces())
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

}  // namespace takt::app
