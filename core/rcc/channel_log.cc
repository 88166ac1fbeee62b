#include "core/rcc/channel_log.h"

#include <fmt/format.h>

#include "core/rcc/control_core.h"

namespace takt::rcc {

Diagnostics LatchReplay::before_step(ControlCore& core) {
  Diagnostics diagnostics;
  for (; next_ < latches_.size() && latches_[next_].cycle <= core.cycle(); ++next_) {
    const Latch& latch = latches_[next_];
    device::Channel* channel = core.find_channel(latch.channel);
    if (channel == nullptr) {
      diagnostics.error(Code::kUnknownName, {}, fmt::format("there is no channel '{}' to replay", latch.channel));
      continue;
    }
    const auto written = latch.value ? channel->write(*latch.value) : channel->write_null();
    if (written != device::Channel::Written::kDone || latch.cycle != core.cycle())
      diagnostics.error(Code::kNotPossibleNow, {},
                        fmt::format("channel '{}' cannot be replayed in cycle {}", latch.channel, latch.cycle));
  }
  return diagnostics;
}

}  // namespace takt::rcc
