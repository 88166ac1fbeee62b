#include "scenario/emulation_run.h"

#include <pthread.h>
#include <sys/mman.h>

#include <fmt/format.h>

#include "core/base/clock.h"
#include "core/device/driver.h"

namespace takt::scenario {
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

}  // namespace

Result<std::unique_ptr<EmulationRun>> EmulationRun::create(Description description,
                                                           const device::ModelLibrary& models) {
  const Site site = std::exchange(description.site, {});
  Diagnostics warnings;
  auto built = build_cell(description, models, false, warnings);
  if (!built) return std::unexpected(std::move(built.error()));
  std::unique_ptr<EmulationRun> run(new EmulationRun(std::move(*built)));
  Diagnostics diagnostics = run->add_emulators(site, description.seed);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return run;
}

Diagnostics EmulationRun::add_emulators(const Site& site, std::uint64_t seed) {
  Diagnostics diagnostics;
  for (const auto& [name, binding] : site.devices) {
    const auto arm = built_.cell.arms.find(name);
    if (!on_a_wire(binding)) continue;
    if (arm == built_.cell.arms.end()) {
      diagnostics.error(Code::kUnknownName, binding.pointer, fmt::format("there is no arm '{}'", name));
      continue;
    }
    const device::Arm& device = *arm->second.device;
    const device::DriverKind& kind = *device::DriverKinds::global().find(binding.kind);
    auto description = std::make_shared<const device::ArmDescription>(device.description());
    if (const std::string refusal = kind.refuse(*binding.driver, *description); !refusal.empty()) {
      diagnostics.error(Code::kIncompatible, binding.pointer, fmt::format("'{}': {}", name, refusal));
      continue;
    }
    auto emulator = kind.emulate(*binding.driver, {name, description, built_.core->period(), 0, seed},
                                 built_.borrowed<device::ArmBackend>(built_.world->arm(name)));
    if (!emulator) {
      diagnostics.append(emulator.error(), binding.pointer);
      continue;
    }
    (*emulator)->set_tool(device.tool());
    emulators_.push_back({name, std::move(*emulator)});
    served_.push_back({name, binding.kind, binding.driver->address});
  }
  if (emulators_.empty() && !diagnostics.has_errors()) {
    diagnostics.error(Code::kRequires, "--backend", "no arm has a driver on a wire, so there is nothing to emulate",
                      "--backend arm=fri:127.0.0.1, or --site FILE");
  }
  return diagnostics;
}

void EmulationRun::tell_news(const Options& options) {
  for (const Emulated& one : emulators_) {
    for (const std::string& line : one.emulator->news()) {
      if (options.tell)
        options.tell(fmt::format("{:.3f} s  {}: {}", to_seconds(built_.world->time()), one.device, line));
    }
  }
}

EmulationRun::Report EmulationRun::run(const Options& options) {
  constexpr std::int64_t kNewsEvery = 50;  // cycles
  if (options.realtime) ask_for_realtime();
  const Nanoseconds period = built_.core->period();
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
    for (const Emulated& one : emulators_) one.emulator->advance(cycle * period);
    if (!built_.world->step()) {
      report.diagnostics.error(Code::kSystem, {},
                               fmt::format("the physics diverged at {:.3f} s", to_seconds(built_.world->time())));
      break;
    }
    if (cycle % kNewsEvery == 0) tell_news(options);
  }
  tell_news(options);
  report.sim_time = to_seconds(built_.world->time());
  return report;
}

}  // namespace takt::scenario
