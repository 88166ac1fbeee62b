#pragma once

#include <cstdint>

namespace takt::rcc {

/// How much slower than the reference machine this one is: 1 = the same, 2 = twice the time. Measured once, outside the
/// cycle, on virtual calls over memory that caches hold, as nets are made of; the fastest of many rounds, so that what
/// else the machine does at that moment does not count. Realtime: setup, some milliseconds.
[[nodiscard]] double machine_factor();

}  // namespace takt::rcc
