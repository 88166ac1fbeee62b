#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include "core/base/time.h"
#include "core/rcc/control_core.h"

namespace takt::rcc {

/// Watches from a thread of its own that the cycle of a core goes on (row L7). A primitive that never returns cannot be
/// ended from inside; but while no set points come, the rings of the I/O agents run dry and the agents stop their
/// devices within limits. The watchdog says on stderr what is stuck, waits as long as that stopping may take, and ends
/// the process with status 3, without destructors: they could wait for the thread that is stuck.
///
/// It costs the cycle two relaxed stores a cycle, one a net and one a primitive. Not for lock-step under a debugger.
class Watchdog {
 public:
  struct Options {
    Nanoseconds limit = 100 * kMillisecond;  ///< a cycle that takes longer is stuck
    Nanoseconds grace = 500 * kMillisecond;  ///< for the I/O agents, from then to the end of the process
    /// Called once, in the watchdog's thread, before the grace begins; for what must be written down. May be empty.
    std::function<void(const Stall&)> on_stall = {};
  };
  static constexpr int kExitStatus = 3;

  /// Watches from now until it is destroyed. `core` must outlive it. Realtime: setup.
  Watchdog(const ControlCore& core, const Options& options);

 private:
  void watch(const std::stop_token& stop) const;
  [[noreturn]] void end_process(const Stall& stall) const;

  const ControlCore& core_;
  Options options_;
  std::jthread thread_;
};

}  // namespace takt::rcc
