#pragma once

#include <nlohmann/json_fwd.hpp>

namespace takt {

/// `json` without the noise that arithmetic leaves in the last digits: 1.7000000000000002 becomes 1.7. A number is
/// replaced if one of at most 12 digits is within four units of the last place; all others keep every bit. Realtime:
/// setup.
[[nodiscard]] nlohmann::ordered_json without_noise(nlohmann::ordered_json json);

}  // namespace takt
