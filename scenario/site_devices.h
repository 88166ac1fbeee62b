#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/device/arm.h"
#include "core/device/force_torque_sensor.h"
#include "core/emulation/slow_arm.h"
#include "core/emulation/slow_force_torque.h"
#include "core/rcc/control_core.h"
#include "scenario/device_kind.h"
#include "scenario/site.h"

namespace takt::scenario {

/// Puts between the canonical devices of a cell and their simulated machines what the site says: devices with a cycle
/// and a clock of their own. Also without a word of the site: a machine whose model has a cycle longer than the core's
/// takes set points in that cycle, with an ideal clock and wire. Realtime: setup, but for what reads.
class SiteDevices {
 public:
  SiteDevices(Site site, Nanoseconds period, std::uint64_t seed)
      : site_(std::move(site)), period_(period), seed_(seed) {}

  /// Looks at all devices before any is made: the longest delay, and what of the site fits no device.
  void plan(LoadedDevices devices, Diagnostics& diagnostics);

  /// The back end of an arm, and its description with the cycle that it really has.
  struct WiredArm {
    std::shared_ptr<device::ArmBackend> backend;
    std::shared_ptr<const device::ArmDescription> description;
  };
  [[nodiscard]] WiredArm wire(const LoadedDevice& device, std::shared_ptr<device::ArmBackend> machine);
  struct WiredSensor {
    std::shared_ptr<device::ForceTorqueBackend> backend;
    std::shared_ptr<const device::ForceTorqueDescription> description;
  };
  [[nodiscard]] WiredSensor wire(const LoadedDevice& device, std::shared_ptr<device::ForceTorqueBackend> machine);
  /// The states of what was wired become part of the digest.
  void add_to(rcc::Digest& digest) const;

  [[nodiscard]] const std::map<std::string, std::shared_ptr<emulation::SlowArm>>& slow_arms() const { return arms_; }
  [[nodiscard]] const std::map<std::string, std::shared_ptr<emulation::SlowForceTorque>>& slow_sensors() const {
    return sensors_;
  }
  /// A device that was wired and has no sample yet, or takes no set points; empty if all do.
  [[nodiscard]] std::string waiting_for(const command::Cell& cell) const;
  /// As site file and command line say it.
  [[nodiscard]] std::string kind_of(const std::string& device) const;

 private:
  /// What is to stand before a machine with that cycle, if anything.
  [[nodiscard]] std::optional<emulation::SlowOptions> options_for(const LoadedDevice& device, Nanoseconds cycle) const;

  Site site_;
  Nanoseconds period_;
  std::uint64_t seed_;
  Nanoseconds longest_delay_ = 0;  ///< of the arms, if they are padded
  std::map<std::string, std::shared_ptr<emulation::SlowArm>> arms_;
  std::map<std::string, std::shared_ptr<emulation::SlowForceTorque>> sensors_;
};

}  // namespace takt::scenario
