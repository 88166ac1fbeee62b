#include "cell/build/site_devices.h"

#include <algorithm>

#include <fmt/format.h>

#include "cell/build/shadowed_arm.h"
#include "cell/build/shadowed_devices.h"
#include "core/base/utf8.h"

namespace takt::cell {
namespace {

/// A sample may be missing for as many cycles of the device as its file allows.
template <class Description>
std::shared_ptr<const Description> with_cycle(const Description& model, Nanoseconds cycle) {
  auto adapted = std::make_shared<Description>(model);
  adapted->sample_age_max = model.sample_age_max / model.cycle * cycle;
  adapted->cycle = cycle;
  return adapted;
}

/// Of a binding that was checked.
const device::ArmDriverKind& arm_kind_of(const Binding& binding) {
  return dynamic_cast<const device::ArmDriverKind&>(*device::DriverKinds::global().find(binding.kind));
}

/// Connects a device that is no arm: over its own wire, or in the process around its simulated machine.
template <class Driver, class Kind, class Request, class Machine>
Result<std::shared_ptr<Driver>> connect_device(const Binding& binding, const Request& request, const Clock& clock,
                                               const Machine& machine) {
  const auto& kind = dynamic_cast<const Kind&>(*device::DriverKinds::global().find(binding.kind));
  return binding.own_clock() ? kind.connect(*binding.driver, request, clock)
                             : kind.connect_in_process(*binding.driver, request, machine);
}

/// A back end that keeps the driver that it belongs to.
template <class Backend>
std::map<std::string, std::shared_ptr<Backend>, std::less<>> kept_with(
    const std::shared_ptr<device::IoDriver>& driver,
    const std::map<std::string, std::shared_ptr<Backend>, std::less<>>& terminals) {
  std::map<std::string, std::shared_ptr<Backend>, std::less<>> kept;
  for (const auto& [name, terminal] : terminals) kept[name] = std::shared_ptr<Backend>(driver, terminal.get());
  return kept;
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

/// What keeps the driver of a site from a device; empty: nothing.
std::string SiteDevices::refusal_of(const LoadedDevice& device, const Binding& binding) const {
  const device::DriverKind* kind = device::DriverKinds::global().find(binding.kind);
  if (const auto* arms = dynamic_cast<const device::ArmDriverKind*>(kind)) {
    if (const auto arm = device.as<device::ArmDescription>()) return arms->refuse(*binding.driver, *arm);
  } else if (const auto* grippers = dynamic_cast<const device::GripperDriverKind*>(kind)) {
    if (const auto gripper = device.as<device::GripperDescription>())
      return grippers->refuse(*binding.driver, *gripper);
  } else if (const auto* blocks = dynamic_cast<const device::IoDriverKind*>(kind)) {
    if (const auto io = device.as<device::IoDescription>()) return blocks->refuse(*binding.driver, *io);
  }
  return fmt::format("'{}' is of kind '{}'", device.entry->name, device.kind->name());
}

void SiteDevices::check_driver(const LoadedDevice& device, const Binding& binding, Diagnostics& diagnostics) const {
  const std::string refusal = refusal_of(device, binding);
  if (refusal.empty()) return;
  diagnostics.add({Severity::kError, Code::kIncompatible, binding.file, binding.pointer,
                   fmt::format("'{}' is not reached as '{}': {}", device.entry->name, binding.kind, refusal),
                   "a device that this driver is for"});
}

/// What keeps the terminals of a controller from being those of a block; empty: nothing.
std::string SiteDevices::terminals_refusal(const LoadedDevice& block, const Binding& binding,
                                           LoadedDevices devices) const {
  const auto io = block.as<device::IoDescription>();
  if (!io) return fmt::format("'{}' is of kind '{}'", block.entry->name, block.kind->name());
  const auto arm = std::ranges::find(devices, binding.of, [](const auto& device) { return device->entry->name; });
  if (arm == devices.end() || !(*arm)->as<device::ArmDescription>())
    return fmt::format("there is no arm '{}'", binding.of);
  const Binding* of = site_.find(binding.of);
  if (!of || !of->driver) return fmt::format("'{}' has no driver", binding.of);
  const auto* kind = dynamic_cast<const device::ArmDriverKind*>(device::DriverKinds::global().find(of->kind));
  if (kind == nullptr) return fmt::format("'{}' is reached as '{}', which drives no arms", binding.of, of->kind);
  if (terminals_.contains(binding.of)) return fmt::format("another block has the terminals of '{}'", binding.of);
  return kind->refuse_terminals(*io);
}

void SiteDevices::plan_terminals(const LoadedDevice& block, const Binding& binding, LoadedDevices devices,
                                 Diagnostics& diagnostics) {
  const std::string refusal = terminals_refusal(block, binding, devices);
  if (refusal.empty()) {
    terminals_[binding.of] = block.as<device::IoDescription>();
    return;
  }
  diagnostics.add({Severity::kError, Code::kIncompatible, binding.file, binding.pointer,
                   fmt::format("'{}' is not on the terminals of '{}': {}", block.entry->name, binding.of, refusal),
                   "an I/O block, and an arm whose driver knows the terminals of its controller, such as 'rtde'"});
}

std::shared_ptr<const device::IoDescription> SiteDevices::terminals_of(const std::string& arm) const {
  const auto block = terminals_.find(arm);
  return block == terminals_.end() ? nullptr : block->second;
}

/// From a set point's time to when the machine is told it, without padding; 0: it lives in the core's cycle.
Nanoseconds SiteDevices::delay_of(const LoadedDevice& device, const device::ArmDescription& arm) const {
  const Binding* binding = site_.find(device.entry->name);
  if (binding && binding->driver) {
    // A driver of something else is an error that plan() has reported.
    const auto* kind = dynamic_cast<const device::ArmDriverKind*>(device::DriverKinds::global().find(binding->kind));
    return kind ? kind->delay(*binding->driver, arm, period_) : 0;
  }
  const auto options = options_for(device, arm.cycle);
  return options ? options->delay(period_) : 0;
}

void SiteDevices::plan(LoadedDevices devices, Diagnostics& diagnostics) {
  for (const auto& device : devices) {
    names_.push_back(device->entry->name);
    const Binding* binding = site_.find(device->entry->name);
    if (binding && binding->kind == "slow" && !device->kind->has_backend()) {
      diagnostics.add({Severity::kError, Code::kUnsupported, binding->file, binding->pointer,
                       fmt::format("'{}' is of kind '{}', which cannot be slow", names_.back(), device->kind->name()),
                       "arms and force/torque sensors"});
    }
    if (binding && binding->driver) check_driver(*device, *binding, diagnostics);
    if (binding && binding->kind == kTerminals) plan_terminals(*device, *binding, devices, diagnostics);
    const auto arm = device->as<device::ArmDescription>();
    if (!arm) continue;
    delays_[names_.back()] = delay_of(*device, *arm);
  }
  for (const auto& [name, binding] : site_.devices) {
    if (std::ranges::find(names_, name) != names_.end()) continue;
    diagnostics.add({Severity::kError, Code::kUnknownName, binding.file, binding.pointer,
                     fmt::format("there is no device '{}'", name), nearest_choice(name, names_)});
  }
  if (const std::string refusal = master_refusal(devices); !refusal.empty()) {
    diagnostics.add({Severity::kError, Code::kIncompatible, site_.file, "/master_clock",
                     fmt::format("the clock of '{}' cannot be the master: {}", site_.master_clock, refusal),
                     "an arm that a driver reaches on an address, such as 'fri' or 'rtde'; or leave the key out"});
  }
}

std::string SiteDevices::master_refusal(LoadedDevices devices) const {
  const std::string& name = site_.master_clock;
  if (name.empty()) return {};
  const auto device = std::ranges::find(devices, name, [](const auto& one) { return one->entry->name; });
  if (device == devices.end()) return "there is no such device";
  const auto arm = (*device)->as<device::ArmDescription>();
  if (!arm) return fmt::format("it is of kind '{}'", (*device)->kind->name());
  const Binding* binding = site_.find(name);
  if (!binding || !binding->own_clock()) return "it is simulated, or emulated in this process, in the core's time";
  if (!refusal_of(**device, *binding).empty()) return {};  // reported already
  const device::ArmDriverKind& kind = arm_kind_of(*binding);
  if (!kind.paces()) return fmt::format("'{}' has none, its drives follow the clock of this side", binding->kind);
  if (kind.cycle(*binding->driver, *arm) % period_ != 0) return "its cycle is no multiple of the core's";
  return {};
}

Nanoseconds SiteDevices::pace(Nanoseconds due) {
  return master_ == nullptr ? 0 : phase_lock_.correction(due, master_->packet_time());
}

/// The longest delay of those that the arm cooperates with, itself included.
Nanoseconds SiteDevices::padded_delay(const std::string& arm) const {
  if (!site_.pad_delays) return delays_.at(arm);
  Nanoseconds longest = delays_.at(arm);
  const auto includes = [&longest](Nanoseconds delay) { longest = std::max(longest, delay); };
  if (!site_.cooperating) {
    for (const auto& [name, delay] : delays_) includes(delay);
    return longest;
  }
  for (const ArmSet& group : merged(*site_.cooperating)) {
    if (!group.contains(arm)) continue;
    for (const std::string& name : group) includes(delays_.at(name));
  }
  return longest;
}

bool SiteDevices::may_pad() const {
  const auto differs = [this](const auto& arm) { return arm.second != delays_.begin()->second; };
  return site_.pad_delays && std::ranges::any_of(delays_, differs);
}

bool SiteDevices::differ_in_delay(const ArmGroups& groups) const {
  const auto differ = [this](const auto& group) {
    return std::ranges::any_of(
        group, [&](const std::string& arm) { return padded_delay(arm) != padded_delay(*group.begin()); });
  };
  return site_.pad_delays && std::ranges::any_of(groups, differ);
}

/// An arm behind a driver. Its simulated body is the machine of an emulated controller in this process; with a real
/// wire it follows the arm as a shadow.
SiteDevices::WiredArm SiteDevices::connect(const LoadedDevice& device, const Binding& binding,
                                           std::shared_ptr<device::ArmBackend> machine) {
  const auto model = device.as<device::ArmDescription>();
  const device::ArmDriverKind& kind = arm_kind_of(binding);
  const Nanoseconds padding = padded_delay(device.entry->name) - delays_.at(device.entry->name);
  auto description = with_cycle(*model, kind.cycle(*binding.driver, *model));
  const device::DriverRequest request{
      device.entry->name, description, period_, padding, seed_, terminals_of(device.entry->name)};
  auto driver = binding.own_clock() ? kind.connect(*binding.driver, request, clock_)
                                    : kind.connect_in_process(*binding.driver, request, machine);
  if (!driver) {
    problems_.append(driver.error(), binding.pointer, binding.file);
    return {std::move(machine), model};
  }
  drivers_[request.device] = *driver;
  all_drivers_[request.device] = *driver;
  if (request.device == site_.master_clock) master_ = driver->get();
  if (!binding.own_clock()) return {std::move(*driver), std::move(description)};
  own_clock_ = true;
  return {std::make_shared<ShadowedArm>(std::move(*driver), std::move(machine)), std::move(description)};
}

SiteDevices::WiredGripper SiteDevices::wire(const LoadedDevice& device,
                                            std::shared_ptr<device::GripperBackend> machine) {
  const auto model = device.as<device::GripperDescription>();
  const Binding* binding = site_.find(device.entry->name);
  if (!binding || !binding->driver || !site_.connect) return {std::move(machine), model};
  const auto& kind = dynamic_cast<const device::GripperDriverKind&>(*device::DriverKinds::global().find(binding->kind));
  auto description = with_cycle(*model, kind.cycle(*binding->driver, *model));
  const device::GripperRequest request{device.entry->name, description, period_, seed_};
  auto driver = connect_device<device::GripperDriver, device::GripperDriverKind>(*binding, request, clock_, machine);
  if (!driver) {
    problems_.append(driver.error(), binding->pointer, binding->file);
    return {std::move(machine), model};
  }
  gripper_drivers_[request.device] = *driver;
  all_drivers_[request.device] = *driver;
  if (!binding->own_clock()) return {std::move(*driver), std::move(description)};
  own_clock_ = true;
  return {std::make_shared<ShadowedGripper>(std::move(*driver), std::move(machine)), std::move(description)};
}

SiteDevices::WiredIo SiteDevices::adopt(std::shared_ptr<device::IoDriver> driver, const std::string& name,
                                        bool own_clock, std::shared_ptr<const device::IoDescription> description,
                                        const device::IoTerminals& machine) {
  io_drivers_[name] = driver;
  all_drivers_[name] = driver;
  own_clock_ = own_clock_ || own_clock;
  const device::IoTerminals& wired = driver->terminals();
  device::IoTerminals terminals{kept_with(driver, wired.digital_inputs), kept_with(driver, wired.analog_inputs),
                                kept_with(driver, wired.digital_outputs), kept_with(driver, wired.analog_outputs)};
  if (own_clock) show_outputs(terminals, machine);
  return {std::move(terminals), std::move(description)};
}

SiteDevices::WiredIo SiteDevices::wire(const LoadedDevice& device, device::IoTerminals machine) {
  const auto model = device.as<device::IoDescription>();
  const std::string& name = device.entry->name;
  const Binding* binding = site_.find(name);
  if (binding && binding->kind == kTerminals) {
    const auto arm = drivers_.find(binding->of);
    device::IoDriver* block = arm == drivers_.end() ? nullptr : arm->second->terminals(machine);
    if (block == nullptr) return {std::move(machine), model};  // not connected, or reported
    const auto description = with_cycle(*model, arm->second->timing().cycle);
    return adopt({arm->second, block}, name, on_own_clock(binding->of), description, machine);
  }
  if (!binding || !binding->driver || !site_.connect) return {std::move(machine), model};
  const auto& kind = dynamic_cast<const device::IoDriverKind&>(*device::DriverKinds::global().find(binding->kind));
  auto description = with_cycle(*model, kind.cycle(*binding->driver, *model));
  const device::IoRequest request{name, description, period_, seed_};
  auto driver = connect_device<device::IoDriver, device::IoDriverKind>(*binding, request, clock_, machine);
  if (driver) return adopt(*driver, name, binding->own_clock(), std::move(description), machine);
  problems_.append(driver.error(), binding->pointer, binding->file);
  return {std::move(machine), model};
}

std::shared_ptr<device::ForceTorqueBackend> SiteDevices::own_force(const std::string& arm) const {
  const auto driver = drivers_.find(arm);
  if (driver == drivers_.end()) return nullptr;
  return {driver->second, driver->second->force_torque()};
}

SiteDevices::WiredArm SiteDevices::wire(const LoadedDevice& device, std::shared_ptr<device::ArmBackend> machine) {
  const Binding* binding = site_.find(device.entry->name);
  if (binding && binding->driver && site_.connect) return connect(device, *binding, std::move(machine));
  const auto model = device.as<device::ArmDescription>();
  auto options = options_for(device, model->cycle);
  // An arm that lives in the core's cycle is made late by an agent with that cycle.
  const std::string& name = device.entry->name;
  const Nanoseconds delay = padded_delay(name);
  if (!options && delay > 0) options = emulation::SlowOptions{.cycle = period_};
  if (!options) return {std::move(machine), model};
  options->padding = std::max<Nanoseconds>(0, delay - options->delay(period_));
  auto slow = std::make_shared<emulation::SlowArm>(name, std::move(machine), model->limits, *options, period_, seed_,
                                                   model->modes);
  arms_[name] = slow;
  auto later = std::make_shared<device::ArmDescription>(*with_cycle(*model, options->cycle));
  later->modes = emulation::SlowArm::delayed(model->modes, *options, period_);
  return {slow, std::move(later)};
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
  for (const auto& [name, driver] : all_drivers_) {
    if (!driver->state().empty()) digest.add_block(name + "/wire", driver->state());
  }
}

std::string SiteDevices::waiting_for(const expression::Cell& cell) const {
  for (const auto& [name, slow] : arms_) {
    if (!cell.arms.at(name).device->ready()) return name;
  }
  for (const auto& [name, driver] : drivers_) {
    if (!cell.arms.at(name).device->ready()) return name;
  }
  for (const auto& [name, driver] : gripper_drivers_) {
    if (!cell.grippers.at(name).device->ready()) return name;
  }
  for (const auto& [name, driver] : io_drivers_) {
    if (!driver->ready()) return name;
  }
  for (const auto& [name, slow] : sensors_) {
    if (!cell.sensors.at(name).device->has_sample()) return name;
  }
  return {};
}

std::string SiteDevices::why_waiting(const std::string& device, const expression::Cell& cell) const {
  const auto driver = all_drivers_.find(device);
  if (driver == all_drivers_.end()) return {};
  if (const std::string refusal = driver->second->refusal(); !refusal.empty()) return escape_controls(refusal);
  return escape_controls(fault_of(device, cell));
}

/// In the words of its driver.
std::string SiteDevices::fault_of(const std::string& device, const expression::Cell& cell) const {
  if (drivers_.contains(device)) {
    const device::Arm& arm = *cell.arms.at(device).device;
    return arm.has_sample() ? arm.fault_text()
                            : "nothing has come from its controller; check address, cable and program";
  }
  if (const auto driver = gripper_drivers_.find(device); driver != gripper_drivers_.end()) {
    const device::Gripper& gripper = *cell.grippers.at(device).device;
    return gripper.sample().sequence > 0 ? driver->second->fault_text(gripper.sample().fault)
                                         : "nothing has come from it; check its address, its cable and its settings";
  }
  return io_drivers_.at(device)->fault_text();
}

std::string SiteDevices::kind_of(const std::string& device) const {
  const Binding* binding = site_.find(device);
  return binding ? binding->kind : "sim";
}

std::map<std::string, device::BackendMode> SiteDevices::realities() const {
  std::map<std::string, device::BackendMode> realities;
  for (const std::string& name : names_) {
    const Binding* binding = site_.find(name);
    if (binding && binding->kind == kTerminals) binding = site_.find(binding->of);
    realities[name] = binding && binding->driver ? binding->driver->reality() : device::BackendMode::kSimulated;
  }
  return realities;
}

double SiteDevices::speed_override() const {
  const auto moves = [](const auto& device) { return device.second == device::BackendMode::kHardware; };
  return site_.speed_override.value_or(std::ranges::any_of(realities(), moves) ? kFirstSpeed : 1.0);
}

std::vector<std::string> SiteDevices::news() {
  std::vector<std::string> news;
  for (const auto& [name, driver] : all_drivers_) {
    for (const std::string& line : driver->news()) news.push_back(name + ": " + escape_controls(line));
  }
  return news;
}

void SiteDevices::reset(const std::string& device) {
  if (const auto driver = all_drivers_.find(device); driver != all_drivers_.end()) driver->second->reset();
}

}  // namespace takt::cell
