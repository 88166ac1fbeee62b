#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/device/backend.h"
#include "core/device/driver.h"

namespace takt::cell {

struct BuiltCell;

/// How a device of a run was reached: what its back end declares, and what was measured. All times in ns.
struct DeviceTiming {
  std::string device, backend;
  device::BackendTiming declared;
  Nanoseconds sample_age_most = 0;  ///< at the beginning of a cycle; of those samples that were there
  /// From a set point's time to when the machine was told it; only for arms, with the true clocks at hand.
  bool drives = false;
  Nanoseconds delay_least = 0, delay_most = 0;
  std::uint64_t lost = 0, repeated = 0, reordered = 0;  ///< samples
  std::uint64_t missed_answers = 0, dry = 0;
  double drift_ppm = 0.0;  ///< of the device's clock against the core's, as estimated
};

/// The certificate of a site (row O7): from an event at a sensor to when the arm is told of it, for a net that reacts
/// in the same cycle. Each cycle that the net's own certificate has adds a period.
struct SiteReaction {
  std::string sensor, arm;
  Nanoseconds most = 0;
};

/// How well the core kept the pace of a device (rcc::PhaseLock). Times in ns.
struct MasterReport {
  std::string device;
  std::int64_t cycles = 0;  ///< since the core first was in phase
  Nanoseconds off_p50 = 0, off_p99 = 0, off_worst = 0;
};

struct SiteReport {
  std::vector<DeviceTiming> devices;
  std::optional<MasterReport> master;  ///< nothing: the machine's clock paces the core
  std::vector<SiteReaction> reactions;
  /// What is on the other end, for every device of the cell.
  std::map<std::string, device::BackendMode> realities;
  /// Between the arms, or of one arm against itself: how far apart set points of one cycle arrived (row T1).
  Nanoseconds skew = 0;
};

/// "arm EMULATED, wrist SIM".
[[nodiscard]] std::string to_text(const std::map<std::string, device::BackendMode>& realities);

/// Watches the devices of a cell during a run.
class SiteWatch {
 public:
  explicit SiteWatch(const BuiltCell& built);
  /// After each cycle. Realtime: cyclic.
  void watch();
  [[nodiscard]] SiteReport report() const;

 private:
  const BuiltCell& built_;
  std::vector<Nanoseconds> arm_ages_, sensor_ages_;  // in the order of the cell's names
};

}  // namespace takt::cell
