#pragma once

#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/device/arm.h"
#include "core/net/compiled_net.h"

namespace takt::rcc {

/// Groups of arms, by their names, that share none.
using SeparateArms = std::vector<std::set<std::string, std::less<>>>;

/// Reports a net that drives arms of two groups. Arms of no group are free. Realtime: setup.
void check_cooperation(const net::CompiledNet& net, std::span<device::Arm* const> arms, const SeparateArms& groups,
                       Diagnostics& diagnostics);

}  // namespace takt::rcc
