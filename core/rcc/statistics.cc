#include "core/rcc/statistics.h"

namespace takt::rcc {

std::string_view name_of(CyclePhase phase) {
  constexpr std::array<std::string_view, kCyclePhases> kNames = {"devices", "nets", "rules", "guard", "digest"};
  return kNames[static_cast<std::size_t>(phase)];
}

}  // namespace takt::rcc
