#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/net/description.h"
#include "core/net/registry.h"

namespace takt::net {

/// The parameters that the type demands, each with its example; an empty object where it demands none. A device is
/// named as its kind ("arm"). Realtime: setup.
[[nodiscard]] nlohmann::ordered_json example_parameters(const PrimitiveInfo& info);

/// A minimal net around one primitive, ready to load where its devices are there: id "example", every input that must
/// be fed has a constant, and a Termination "end" that never holds. Realtime: setup.
[[nodiscard]] NetDescription example_net(const PrimitiveInfo& info);

}  // namespace takt::net
