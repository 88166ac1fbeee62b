#include "core/rcc/cooperation.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::rcc {

void check_cooperation(const net::CompiledNet& net, std::span<device::Arm* const> arms, const SeparateArms& groups,
                       Diagnostics& diagnostics) {
  const device::Arm* first = nullptr;  // of a group
  SeparateArms::const_iterator group = groups.end();
  for (const net::Resource* claim : net.claims()) {
    const auto arm = std::ranges::find(arms, claim);
    if (arm == arms.end()) continue;
    const auto own = std::ranges::find_if(groups, [&](const auto& one) { return one.contains((*arm)->name()); });
    if (own == groups.end()) continue;
    if (first == nullptr) {
      first = *arm;
      group = own;
    } else if (group != own) {
      diagnostics.error(Code::kConflict, "",
                        fmt::format("one net drives '{}' and '{}', which are not among the arms that cooperate",
                                    first->name(), (*arm)->name()),
                        "Name a group of cooperating arms that has both, or make a net for each");
    }
  }
}

}  // namespace takt::rcc
