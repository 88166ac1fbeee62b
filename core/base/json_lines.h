#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace takt {

/// `json` as people write it, in lines of about 120 characters, without a line end at its end: what fits into a line
/// stands in one, an array of numbers or short texts fills its lines. It reads back as the same value. Realtime: setup.
[[nodiscard]] std::string in_lines(const nlohmann::ordered_json& json);

}  // namespace takt
