#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace takt::rcc {

/// The phases of a cycle whose wall time is measured on request.
enum class CyclePhase : std::uint8_t { kDevices, kNets, kRules, kGuard, kDigest };
inline constexpr int kCyclePhases = 5;

[[nodiscard]] std::string_view name_of(CyclePhase phase);

/// Where the wall time of the cycles went. Never part of a result: two equal runs differ here and nowhere else.
struct Statistics {
  std::int64_t cycles = 0;
  std::int64_t measured_cycles = 0;                   ///< 0 unless measuring was asked for
  std::array<std::int64_t, kCyclePhases> phase_ns{};  ///< sums, by CyclePhase
  std::int64_t total_ns = 0;                          ///< sum over measured cycles
  std::int64_t max_ns = 0;                            ///< longest measured cycle
  std::int64_t overruns = 0;                          ///< real time only: cycles that began late
  std::int64_t events_dropped = 0;                    ///< more events in a cycle than the buffer holds
};

}  // namespace takt::rcc
