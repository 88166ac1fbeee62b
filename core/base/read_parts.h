#pragma once

#include "core/base/object_reader.h"

namespace takt {

/// The key "name": a text that is not empty, or `fallback` if there is none. Realtime: setup.
[[nodiscard]] std::string read_name(ObjectReader& reader, const std::string& fallback);

/// A vector that says where to, with a length from 1e-9 to 1e9; as it was written, not of length 1. Realtime: setup.
[[nodiscard]] Eigen::Vector3d read_direction(ObjectReader& reader, std::string_view key,
                                             const Eigen::Vector3d& fallback);

}  // namespace takt
