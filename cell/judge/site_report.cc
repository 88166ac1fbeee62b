#include "cell/judge/site_report.h"

#include <algorithm>

#include <fmt/format.h>

#include "cell/build/built_cell.h"
#include "cell/build/site_devices.h"

namespace takt::cell {
namespace {

void add_counts(const device::InletCounts& counts, DeviceTiming& timing) {
  timing.lost = counts.lost;
  timing.repeated = counts.repeated;
  timing.reordered = counts.reordered;
}

/// What the estimate says of the device's clock: the agent has it the other way round.
double drift_ppm(double core_per_device) { return 1e6 * (1.0 / (1.0 + core_per_device) - 1.0); }

DeviceTiming timing_of(const std::string& name, const BuiltCell& built, const device::Arm& arm, Nanoseconds age) {
  DeviceTiming timing{.device = name, .backend = built.site->kind_of(name), .declared = arm.timing()};
  timing.sample_age_most = age;
  timing.drives = true;
  const auto slow = built.site->slow_arms().find(name);
  if (slow == built.site->slow_arms().end()) {
    const auto driver = built.site->arm_drivers().find(name);
    if (driver == built.site->arm_drivers().end()) return timing;
    const device::ConnectionCounts connection = driver->second->connection();
    add_counts(connection.samples, timing);
    timing.drift_ppm = drift_ppm(connection.drift);
    timing.dry = connection.dry;
    return timing;
  }
  const emulation::SlowArmReport report = slow->second->report();
  add_counts(report.agent.samples, timing);
  timing.drift_ppm = drift_ppm(report.agent.drift);
  timing.missed_answers = report.missed_answers;
  timing.dry = report.agent.dry;
  if (!report.moved()) return timing;
  timing.delay_least = report.delay_least;
  timing.delay_most = report.delay_most;
  return timing;
}

DeviceTiming timing_of(const std::string& name, const BuiltCell& built, const device::ForceTorqueSensor& sensor,
                       Nanoseconds age) {
  DeviceTiming timing{.device = name, .backend = built.site->kind_of(name), .declared = sensor.timing()};
  timing.sample_age_most = age;
  const auto slow = built.site->slow_sensors().find(name);
  if (slow == built.site->slow_sensors().end()) return timing;
  add_counts(slow->second->report().samples, timing);
  timing.drift_ppm = drift_ppm(slow->second->report().drift);
  return timing;
}

}  // namespace

std::string to_text(const std::map<std::string, device::BackendMode>& realities) {
  std::string text;
  for (const auto& [name, reality] : realities)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, device::name_of(reality));
  return text;
}

SiteWatch::SiteWatch(const BuiltCell& built)
    : built_(built), arm_ages_(built.cell.arms.size()), sensor_ages_(built.cell.sensors.size()) {}

void SiteWatch::watch() {
  std::size_t i = 0;
  for (const auto& [name, arm] : built_.cell.arms) {
    if (arm.device->has_sample()) arm_ages_[i] = std::max(arm_ages_[i], arm.device->sample_age());
    ++i;
  }
  i = 0;
  for (const auto& [name, sensor] : built_.cell.sensors) {
    if (sensor.device->has_sample()) sensor_ages_[i] = std::max(sensor_ages_[i], sensor.device->sample_age());
    ++i;
  }
}

SiteReport SiteWatch::report() const {
  SiteReport report;
  report.realities = built_.site->realities();
  if (!built_.site->master_clock().empty()) {
    const rcc::LatenessTimes& off = built_.site->phase_lock().off();
    report.master = {built_.site->master_clock(), off.count(), off.quantile(0.5), off.quantile(0.99), off.worst()};
  }
  std::size_t i = 0;
  Nanoseconds least = INT64_MAX, most = INT64_MIN;
  for (const auto& [name, arm] : built_.cell.arms) {
    report.devices.push_back(timing_of(name, built_, *arm.device, arm_ages_[i++]));
    least = std::min(least, report.devices.back().delay_least);
    most = std::max(most, report.devices.back().delay_most);
  }
  if (most >= least) report.skew = most - least;
  i = 0;
  for (const auto& [name, sensor] : built_.cell.sensors) {
    report.devices.push_back(timing_of(name, built_, *sensor.device, sensor_ages_[i++]));
    for (const auto& [arm_name, arm] : built_.cell.arms) {
      const device::BackendTiming declared = arm.device->timing();
      report.reactions.push_back(
          {name, arm_name, sensor.device->timing().sample_age + declared.driver_delay + declared.dead_time});
    }
  }
  return report;
}

}  // namespace takt::cell
