#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/device/channel.h"

namespace takt::rcc {

class ControlCore;

/// A value from outside, with the cycle that took it in (row D2).
struct Latch {
  std::int64_t cycle = -1;
  std::string channel;
  std::optional<device::ChannelValue> value = {};  ///< empty: null
};

/// Gives a core the values from outside in the cycles in which a recorded run took them, so that a run in real time
/// is repeated in lock-step, bit for bit. Call before each step. Realtime: setup.
class LatchReplay {
 public:
  /// @param latches  in the order of their cycles, as ControlCore::take_latches() gave them
  explicit LatchReplay(std::vector<Latch> latches) : latches_(std::move(latches)) {}
  /// @return what could not be written: a channel that is absent, of another type, or written by nets.
  Diagnostics before_step(ControlCore& core);

 private:
  std::vector<Latch> latches_;
  std::size_t next_ = 0;
};

}  // namespace takt::rcc
