#include "cell/run/emulation_run.h"

#include <algorithm>

#include <pthread.h>
#include <sys/mman.h>

#include <fmt/format.h>

#include "cell/build/cell_builder.h"
#include "cell/build/cell_models.h"
#include "cell/build/signal_devices.h"
#include "core/base/clock.h"
#include "core/device/driver.h"

namespace takt::cell {
namespace {

/// What the machine grants is taken.
void ask_for_realtime() {
  constexpr int kPriority = 80;
  const sched_param parameters{.sched_priority = kPriority};
  (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  (void)mlockall(MCL_CURRENT | MCL_FUTURE);
}

void sleep_until(Nanoseconds machine) {
  const timespec time{machine / kSecond, machine % kSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == EINTR) continue;
}

bool on_a_wire(const Binding& binding) { return binding.own_clock(); }

std::string name_and(const std::string& name, const std::string& why) { return fmt::format("'{}': {}", name, why); }

}  // namespace

Result<std::unique_ptr<EmulationRun>> EmulationRun::create(Description description,
                                                           const device::ModelLibrary& models) {
  const Site site = std::exchange(description.site, {});
  const Description described = description;
  Diagnostics warnings;
  auto built = build_cell(description, models, false, warnings);
  if (!built) return std::unexpected(std::move(built.error()));
  Diagnostics diagnostics = check_faults_of_machines(described.faults);
  auto faults = make_faults(described.faults, *built);
  if (!faults) diagnostics.append(faults.error());
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  std::unique_ptr<EmulationRun> run(new EmulationRun(std::move(*built), std::move(*faults), described.seed));
  Diagnostics ignored;  // found nothing when the cell was built
  const auto devices = load_devices(described, models, ignored);
  diagnostics.append(run->add_emulators(site, devices, described.seed));
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return run;
}

/// An arm's controller, with the block that has its terminals, if there is one.
Result<std::unique_ptr<device::ControllerEmulator>> EmulationRun::arm_emulator(const std::string& name,
                                                                               const Site& site, LoadedDevices devices,
                                                                               std::uint64_t seed) {
  const Binding& binding = site.devices.at(name);
  const auto& kind = dynamic_cast<const device::ArmDriverKind&>(*device::DriverKinds::global().find(binding.kind));
  const auto refused = [&](const std::string& why) { return failure(Code::kIncompatible, {}, name_and(name, why)); };
  const auto arm = built_.cell.arms.find(name);
  if (arm == built_.cell.arms.end()) return failure(Code::kUnknownName, {}, fmt::format("there is no arm '{}'", name));
  auto model = std::make_shared<const device::ArmDescription>(arm->second.device->description());
  if (const std::string why = kind.refuse(*binding.driver, *model); !why.empty()) return refused(why);
  const auto block = std::ranges::find_if(devices, [&](const auto& device) {
    const Binding* of = site.find(device->entry->name);
    return of && of->kind == kTerminals && of->of == name;
  });
  device::DriverRequest request{name, model, built_.core->period(), 0, seed};
  if (block != devices.end()) {
    request.terminals = (*block)->as<device::IoDescription>();
    if (!request.terminals) return refused(fmt::format("'{}' is no I/O block", (*block)->entry->name));
    if (const std::string why = kind.refuse_terminals(*request.terminals); !why.empty()) return refused(why);
  }
  auto emulator = kind.emulate(*binding.driver, request, built_.borrowed<device::ArmBackend>(built_.world->arm(name)));
  if (!emulator) return emulator;
  (*emulator)->set_tool(arm->second.device->tool());
  (*emulator)->set_brakes([this, name] { built_.world->arm(name)->brake(); },
                          [this, name] { built_.world->arm(name)->release_brakes(); });
  if (request.terminals) (*emulator)->set_terminals(simulated_terminals(*(*block)->entry, *request.terminals, built_));
  return emulator;
}

Result<std::unique_ptr<device::ControllerEmulator>> EmulationRun::emulator_of(const std::string& name, const Site& site,
                                                                              LoadedDevices devices,
                                                                              std::uint64_t seed) {
  const Binding& binding = site.devices.at(name);
  const device::DriverKind* found = device::DriverKinds::global().find(binding.kind);
  const Nanoseconds period = built_.core->period();
  const auto refused = [&](const std::string& why) { return failure(Code::kIncompatible, {}, name_and(name, why)); };
  if (dynamic_cast<const device::ArmDriverKind*>(found)) return arm_emulator(name, site, devices, seed);
  if (const auto* grippers = dynamic_cast<const device::GripperDriverKind*>(found)) {
    const auto gripper = built_.cell.grippers.find(name);
    if (gripper == built_.cell.grippers.end())
      return failure(Code::kUnknownName, {}, fmt::format("there is no gripper '{}'", name));
    auto model = std::make_shared<const device::GripperDescription>(gripper->second.device->description());
    if (const std::string why = grippers->refuse(*binding.driver, *model); !why.empty()) return refused(why);
    return grippers->emulate(*binding.driver, {name, model, period, seed},
                             built_.borrowed<device::GripperBackend>(built_.world->gripper(name)));
  }
  const auto& blocks = dynamic_cast<const device::IoDriverKind&>(*found);
  const auto block = std::ranges::find(devices, name, [](const auto& device) { return device->entry->name; });
  const auto model = block == devices.end() ? nullptr : (*block)->as<device::IoDescription>();
  if (!model) return failure(Code::kUnknownName, {}, fmt::format("there is no I/O block '{}'", name));
  if (const std::string why = blocks.refuse(*binding.driver, *model); !why.empty()) return refused(why);
  return blocks.emulate(*binding.driver, {name, model, period, seed},
                        simulated_terminals(*(*block)->entry, *model, built_));
}

Diagnostics EmulationRun::add_emulators(const Site& site, LoadedDevices devices, std::uint64_t seed) {
  Diagnostics diagnostics;
  for (const auto& [name, binding] : site.devices) {
    if (!on_a_wire(binding)) continue;
    auto emulator = emulator_of(name, site, devices, seed);
    if (!emulator) {
      diagnostics.append(emulator.error(), binding.pointer);
      continue;
    }
    emulators_.push_back({name, std::move(*emulator)});
    served_.push_back({name, binding.kind, binding.driver->address});
  }
  if (emulators_.empty() && !diagnostics.has_errors()) {
    diagnostics.error(Code::kRequires, "--backend", "no device has a driver on a wire, so there is nothing to emulate",
                      "Give --backend arm=fri:127.0.0.1, or --site FILE");
  }
  return diagnostics;
}

void EmulationRun::tell(const Options& options, const std::string& who, const std::string& what) const {
  if (options.tell) options.tell(fmt::format("{:.3f} s  {}: {}", to_seconds(built_.world->time()), who, what));
}

void EmulationRun::tell_news(const Options& options) {
  for (const Emulated& one : emulators_) {
    for (const std::string& line : one.emulator->news()) tell(options, one.device, line);
  }
}

/// What a person does at an arm: its own stop, and the reset after it has stopped by itself.
void EmulationRun::carry_out_commands(const Options& options) {
  while (const auto line = options.next_command ? options.next_command() : std::nullopt) {
    const std::size_t blank = line->find(' ');
    const std::string what = line->substr(0, blank), name = blank == std::string::npos ? "" : line->substr(blank + 1);
    const auto served = std::ranges::find(emulators_, name, &Emulated::device);
    sim::SimArm* arm = served == emulators_.end() ? nullptr : built_.world->arm(name);
    if (arm != nullptr && what == "reset") {
      arm->release_brakes();
      tell(options, name, "reset");
    } else if (arm != nullptr && what == "stop") {
      arm->stop(device::StopCategory::kStopThenBrakes);
      tell(options, name, "stopped at the machine");
    } else if (!line->empty()) {
      tell(options, *line, "is neither 'reset ARM' nor 'stop ARM' of an arm that is emulated");
    }
  }
}

/// Clients see a controller whose clock stood.
void EmulationRun::tell_lost_time(const Options& options, Nanoseconds lost) {
  constexpr Nanoseconds kWorthTelling = 100 * kMillisecond;
  constexpr double kPause = 5.0;  // s between two lines
  const double now = to_seconds(built_.world->time());
  if (lost - lost_told_ < kWorthTelling || now < next_tell_) return;
  next_tell_ = now + kPause;
  tell(options, "clock",
       fmt::format("lost {:.2f} s: this machine is too slow, or too busy", to_seconds(lost - lost_told_)));
  lost_told_ = lost;
}

EmulationRun::Report EmulationRun::run(const Options& options) {
  constexpr std::int64_t kNewsEvery = 50;  // cycles
  constexpr double kLostShare = 0.01;      // of the time, from which on it is worth a warning
  if (options.realtime) ask_for_realtime();
  const Nanoseconds period = built_.core->period();
  Faults faults(faults_, built_, seed_,
                [&](auto kind, auto text) { tell(options, std::string(kind), std::string(text)); });
  Nanoseconds origin = MonotonicClock::machine_time();
  Report report;
  for (std::int64_t cycle = 0; options.interrupt == nullptr || options.interrupt->load() == 0; ++cycle) {
    const Nanoseconds due = origin + cycle * period;
    const std::int64_t late = (MonotonicClock::machine_time() - due) / period;
    if (late > 0) {
      report.overruns += late;
      origin += late * period;
    }
    sleep_until(origin + cycle * period);
    faults.apply(cycle * period);
    for (const Emulated& one : emulators_) one.emulator->advance(cycle * period);
    if (!built_.world->step()) {
      report.diagnostics.error(Code::kSystem, {}, built_.world->divergence());
      break;
    }
    if (cycle % kNewsEvery != 0) continue;
    tell_lost_time(options, report.overruns * period);
    tell_news(options);
    carry_out_commands(options);
  }
  tell_news(options);
  report.sim_time = to_seconds(built_.world->time());
  const double lost = to_seconds(report.overruns * period), whole = report.sim_time + lost;
  if (lost > kLostShare * whole) {
    report.diagnostics.warning(Code::kOverBudget, {},
                               fmt::format("the machines' clock lost {:.2f} of {:.2f} s", lost, whole),
                               options.realtime ? "Run less beside it" : "Give --realtime, or run less beside it");
  }
  return report;
}

}  // namespace takt::cell
