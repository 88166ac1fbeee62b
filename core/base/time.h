#pragma once

#include <cstdint>

namespace takt {

/// Time is whole nanoseconds; doubles in seconds appear only inside formulas (docs/semantics.md, row T1).
using Nanoseconds = std::int64_t;

inline constexpr Nanoseconds kMillisecond = 1'000'000;
inline constexpr Nanoseconds kSecond = 1'000'000'000;

[[nodiscard]] constexpr double to_seconds(Nanoseconds time) { return static_cast<double>(time) * 1e-9; }

}  // namespace takt
