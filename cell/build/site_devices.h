#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cell/build/device_kind.h"
#include "cell/file/site.h"
#include "core/base/clock.h"
#include "core/device/arm.h"
#include "core/device/driver.h"
#include "core/device/force_torque_sensor.h"
#include "core/device/gripper.h"
#include "core/emulation/slow_arm.h"
#include "core/emulation/slow_force_torque.h"
#include "core/rcc/control_core.h"
#include "core/rcc/phase_lock.h"

namespace takt::cell {

/// Puts between the canonical devices of a cell and their simulated machines what the site says: devices with a cycle
/// and a clock of their own. Also without a word of the site: a machine whose model has a cycle longer than the core's
/// takes set points in that cycle, with an ideal clock and wire. Realtime: setup, but for what reads.
class SiteDevices {
 public:
  SiteDevices(Site site, Nanoseconds period, std::uint64_t seed)
      : site_(std::move(site)), period_(period), seed_(seed), phase_lock_(period) {}

  /// Looks at all devices before any is made: the longest delay, and what of the site fits no device.
  void plan(LoadedDevices devices, Diagnostics& diagnostics);

  /// Its arms are not equally late: it matters which of them cooperate.
  [[nodiscard]] bool may_pad() const;
  /// Arms of one of these groups are not equally late as they are wired now.
  [[nodiscard]] bool differ_in_delay(const ArmGroups& groups) const;

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
  /// The back end of a gripper, and its description with the cycle that it really has.
  struct WiredGripper {
    std::shared_ptr<device::GripperBackend> backend;
    std::shared_ptr<const device::GripperDescription> description;
  };
  [[nodiscard]] WiredGripper wire(const LoadedDevice& device, std::shared_ptr<device::GripperBackend> machine);
  /// The back ends of a block's terminals, and its description with the cycle that it really has.
  struct WiredIo {
    device::IoTerminals terminals;
    std::shared_ptr<const device::IoDescription> description;
  };
  [[nodiscard]] WiredIo wire(const LoadedDevice& device, device::IoTerminals machine);
  /// Its back end belongs to another device, which has to be wired before.
  [[nodiscard]] bool wired_last(const std::string& device) const { return kind_of(device) == kTerminals; }
  /// The block whose terminals are those of this arm's controller; null: there is none.
  [[nodiscard]] std::shared_ptr<const device::IoDescription> terminals_of(const std::string& arm) const;
  /// What the controller of an arm says that the arm feels (row `own_force` of an arm); null: it says nothing of its
  /// own, the external torques are what there is.
  [[nodiscard]] std::shared_ptr<device::ForceTorqueBackend> own_force(const std::string& arm) const;
  /// What went wrong while devices were wired: a port in use, an address that is none of this machine.
  [[nodiscard]] const Diagnostics& problems() const { return problems_; }
  /// The states of what was wired become part of the digest.
  void add_to(rcc::Digest& digest) const;

  [[nodiscard]] const std::map<std::string, std::shared_ptr<emulation::SlowArm>>& slow_arms() const { return arms_; }
  [[nodiscard]] const std::map<std::string, std::shared_ptr<emulation::SlowForceTorque>>& slow_sensors() const {
    return sensors_;
  }
  /// A device that was wired and has no sample yet, or takes no set points; empty if all do.
  [[nodiscard]] std::string waiting_for(const expression::Cell& cell) const;
  /// As site file and command line say it.
  [[nodiscard]] std::string kind_of(const std::string& device) const;

  /// Of every device of the cell, by its name.
  [[nodiscard]] std::map<std::string, device::BackendMode> realities() const;
  /// Share of the planned speed with which a run begins (docs/hardware.md).
  [[nodiscard]] double speed_override() const;
  /// The drivers of arms, by the names of these.
  [[nodiscard]] const std::map<std::string, std::shared_ptr<device::ArmDriver>>& arm_drivers() const {
    return drivers_;
  }
  /// Some device has a driver.
  [[nodiscard]] bool has_drivers() const { return !all_drivers_.empty(); }
  /// Resets the driver of a device, if it has one: after a stop it may accept commands again. Any thread.
  void reset(const std::string& device);
  /// Why a device that waiting_for() names does not become ready; empty: it does not say.
  /// Thread of news().
  [[nodiscard]] std::string why_waiting(const std::string& device, const expression::Cell& cell) const;
  /// The device is reached over a real wire.
  [[nodiscard]] bool on_own_clock(const std::string& device) const {
    const Binding* binding = site_.find(device);
    return binding && binding->own_clock();
  }
  /// Some device is reached over a real wire: the run keeps the machine's time, cycle by cycle.
  [[nodiscard]] bool own_clock() const { return own_clock_; }
  /// The core's time for those; whoever steps the core aligns it and tells it what he leaves out.
  [[nodiscard]] MonotonicClock& clock() { return clock_; }
  /// The arm whose controller's clock paces the core; empty: the machine's does.
  [[nodiscard]] const std::string& master_clock() const { return site_.master_clock; }
  /// For a cycle that is due then (Clock::Reading::machine): by how much it has to begin later for the pace of the
  /// master clock; 0 without one. Cycle thread, between cycles. Realtime: cyclic.
  [[nodiscard]] Nanoseconds pace(Nanoseconds due);
  [[nodiscard]] const rcc::PhaseLock& phase_lock() const { return phase_lock_; }
  /// What drivers have to say since the last call, with the names of their devices.
  [[nodiscard]] std::vector<std::string> news();

 private:
  /// What is to stand before a machine with that cycle, if anything.
  [[nodiscard]] std::optional<emulation::SlowOptions> options_for(const LoadedDevice& device, Nanoseconds cycle) const;

  [[nodiscard]] WiredArm connect(const LoadedDevice& device, const Binding& binding,
                                 std::shared_ptr<device::ArmBackend> machine);
  [[nodiscard]] std::string fault_of(const std::string& device, const expression::Cell& cell) const;
  [[nodiscard]] std::string refusal_of(const LoadedDevice& device, const Binding& binding) const;
  void check_driver(const LoadedDevice& device, const Binding& binding, Diagnostics& diagnostics) const;
  void plan_terminals(const LoadedDevice& block, const Binding& binding, LoadedDevices devices,
                      Diagnostics& diagnostics);
  [[nodiscard]] std::string terminals_refusal(const LoadedDevice& block, const Binding& binding,
                                              LoadedDevices devices) const;
  [[nodiscard]] WiredIo adopt(std::shared_ptr<device::IoDriver> driver, const std::string& name, bool own_clock,
                              std::shared_ptr<const device::IoDescription> description,
                              const device::IoTerminals& machine);
  /// What keeps a device's clock from being the master; empty: nothing.
  [[nodiscard]] std::string master_refusal(LoadedDevices devices) const;
  [[nodiscard]] Nanoseconds delay_of(const LoadedDevice& device, const device::ArmDescription& arm) const;
  [[nodiscard]] Nanoseconds padded_delay(const std::string& arm) const;

  Site site_;
  Nanoseconds period_;
  std::uint64_t seed_;
  std::map<std::string, Nanoseconds, std::less<>> delays_;  ///< of the arms, without padding
  /// Blocks on the terminals of controllers, by their arms.
  std::map<std::string, std::shared_ptr<const device::IoDescription>, std::less<>> terminals_;
  MonotonicClock clock_;  ///< outlives the drivers
  bool own_clock_ = false;
  device::ArmDriver* master_ = nullptr;  ///< whose clock paces the core
  rcc::PhaseLock phase_lock_;
  Diagnostics problems_;
  std::vector<std::string> names_;  ///< of all devices
  std::map<std::string, std::shared_ptr<device::ArmDriver>> drivers_;
  std::map<std::string, std::shared_ptr<device::GripperDriver>> gripper_drivers_;
  std::map<std::string, std::shared_ptr<device::IoDriver>> io_drivers_;
  std::map<std::string, std::shared_ptr<device::DeviceDriver>> all_drivers_;  ///< these, by device
  std::map<std::string, std::shared_ptr<emulation::SlowArm>> arms_;
  std::map<std::string, std::shared_ptr<emulation::SlowForceTorque>> sensors_;
};

}  // namespace takt::cell
