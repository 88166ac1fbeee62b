#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/random.h"

namespace takt::test {

/// All words that mean something in a net file: keys, primitive types, ports, parameters, devices.
[[nodiscard]] std::vector<std::string> net_words();

/// A net file with one to four things changed in a way that keeps its form: a primitive more or less, a link between
/// ports that exist, a parameter, a delay, a fragment around some primitives. Text that is no net comes back as it is,
/// written anew.
[[nodiscard]] std::string mutated_net(const nlohmann::ordered_json& net, Random& random);

}  // namespace takt::test
