#include "scenario/site_devices.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::scenario {
namespace {

/// A sample may be missing for as many cycles of the device as its file allows.
template <class Description>
std::shared_ptr<const Description> with_cycle(const Description& model, Nanoseconds cycle) {
  auto adapted = std::make_shared<Description>(model);
  adapted->sample_age_max = model.sample_age_max / model.cycle * cycle;
  adapted->cycle = cycle;
  return adapted;
}

}  // namespace

std::optional<emulation::SlowOptions> SiteDevices::options_for(const LoadedDevice& device, Nanoseconds cycle) const {
  const Binding* binding = site_.find(device.entry->name);
  if (binding && binding->kind == "slow") {
    emulation::SlowOptions options = binding->slow;
    if (options.cycle == 0) options.cycle = cycle;
    options.wire.hold_back = options.cycle + options.cycle / 2;
    return options;
  }
  if (cycle <= period_) return std::nullopt;
  return emulation::SlowOptions{.cycle = cycle};
}

void SiteDevices::plan(LoadedDevices devices, Diagnostics& diagnostics) {
  std::vector<std::string> names;
  int arm_count = 0;
  Nanoseconds longest = 0;
  for (const auto& device : devices) {
    names.push_back(device->entry->name);
    const Binding* binding = site_.find(device->entry->name);
    if (binding && binding->kind == "slow" && !device->kind->has_backend()) {
      diagnostics.add({Severity::kError, Code::kUnknownName, binding->file, binding->pointer,
                       fmt::format("'{}' is of kind '{}', which cannot be slow", names.back(), device->kind->name()),
                       "arms and force/torque sensors"});
    }
    const auto arm = device->as<device::ArmDescription>();
    if (!arm) continue;
    ++arm_count;
    if (const auto options = options_for(*device, arm->cycle)) longest = std::max(longest, options->delay(period_));
  }
  if (site_.pad_delays && arm_count > 1) longest_delay_ = longest;
  for (const auto& [name, binding] : site_.devices) {
    if (std::ranges::find(names, name) != names.end()) continue;
    diagnostics.add({Severity::kError, Code::kUnknownName, binding.file, binding.pointer,
                     fmt::format("there is no device '{}'", name), nearest_choice(name, names)});
  }
}

SiteDevices::WiredArm SiteDevices::wire(const LoadedDevice& device, std::shared_ptr<device::ArmBackend> machine) {
  const auto model = device.as<device::ArmDescription>();
  auto options = options_for(device, model->cycle);
  // An arm that lives in the core's cycle is made late by an agent with that cycle.
  if (!options && longest_delay_ > 0) options = emulation::SlowOptions{.cycle = period_};
  if (!options) return {std::move(machine), model};
  options->padding = std::max<Nanoseconds>(0, longest_delay_ - options->delay(period_));
  const std::string& name = device.entry->name;
  auto slow = std::make_shared<emulation::SlowArm>(name, std::move(machine), model->limits, *options, period_, seed_);
  arms_[name] = slow;
  auto stiff = std::make_shared<device::ArmDescription>(*with_cycle(*model, options->cycle));
  stiff->modes = {};  // what lies between resamples positions and nothing else
  return {slow, std::move(stiff)};
}

SiteDevices::WiredSensor SiteDevices::wire(const LoadedDevice& device,
                                           std::shared_ptr<device::ForceTorqueBackend> machine) {
  const auto model = device.as<device::ForceTorqueDescription>();
  const Binding* binding = site_.find(device.entry->name);
  // The simulated sensor keeps the cycle of its model by itself.
  if (!binding || binding->kind != "slow") return {std::move(machine), model};
  const auto options = options_for(device, model->cycle);
  const std::string& name = device.entry->name;
  auto slow = std::make_shared<emulation::SlowForceTorque>(name, std::move(machine), *options, period_, seed_);
  sensors_[name] = slow;
  return {slow, with_cycle(*model, options->cycle)};
}

void SiteDevices::add_to(rcc::Digest& digest) const {
  for (const auto& [name, arm] : arms_) digest.add_block(name + "/wire", arm->state().bytes());
  for (const auto& [name, sensor] : sensors_) digest.add_block(name + "/wire", sensor->state().bytes());
}

std::string SiteDevices::waiting_for(const command::Cell& cell) const {
  for (const auto& [name, slow] : arms_) {
    if (!cell.arms.at(name).device->ready()) return name;
  }
  for (const auto& [name, slow] : sensors_) {
    if (!cell.sensors.at(name).device->has_sample()) return name;
  }
  return {};
}

std::string SiteDevices::kind_of(const std::string& device) const {
  const Binding* binding = site_.find(device);
  return binding ? binding->kind : "sim";
}

}  // namespace takt::scenario
