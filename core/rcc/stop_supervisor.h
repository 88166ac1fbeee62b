#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/device/arm.h"
#include "core/device/emergency_stop.h"
#include "core/rcc/executor.h"

namespace takt::rcc {

/// What stops nets from outside: emergency-stop latches, lost devices, somebody who wants everything to end (rows S1,
/// S3, S4). Owned by the core; the cycle thread calls begin() and finish() in each cycle. Realtime: cyclic but for
/// add().
class StopSupervisor {
 public:
  explicit StopSupervisor(Executor& executor) : executor_(executor) {}

  void add(device::EmergencyStop* stop) { latches_.push_back(stop); }
  void add(device::Arm* arm) { arms_.push_back({.arm = arm}); }
  /// Everything ends in the next cycle, with this cause; of several that ask before that cycle, with the first one's.
  /// Needs no room and is never refused. Any thread, wait-free.
  void stop_all(net::Cause::Code code, std::string_view text);

  /// Before the nets are evaluated: what can come to rest on its path begins to.
  void begin(std::int64_t cycle);
  /// After it: the rest is aborted, and brakes are closed. Starts are allowed in this cycle if nothing stops.
  void finish(std::int64_t cycle);

 private:
  /// Brakes are closed once: somebody may open them again before the latch is reset.
  struct Braked {
    device::Arm* arm;
    bool closed = false;
  };
  void close_brakes(bool at_once);
  /// Of those that are latched the one with the lowest category; nullptr: none is.
  [[nodiscard]] const device::EmergencyStop* strongest() const;
  [[nodiscard]] static net::Cause cause_of(const device::EmergencyStop& stop, std::int64_t cycle);

  /// The cause of stop_all() if somebody has asked; takes it.
  [[nodiscard]] std::optional<net::Cause> take_stop_of_all();

  Executor& executor_;
  std::vector<device::EmergencyStop*> latches_;
  std::vector<Braked> arms_;
  // The flag alone stops. The cause is one thread's at a time: who finds it being written leaves it.
  enum class CauseIs : std::uint8_t { kFree, kBeingWritten, kWritten };
  std::atomic<bool> everything_ = false;
  std::atomic<CauseIs> cause_is_ = CauseIs::kFree;
  net::Cause cause_;
};

}  // namespace takt::rcc
