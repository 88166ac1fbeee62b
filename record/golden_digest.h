#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "record/recording.h"

namespace takt::record {

/// How many digests there are, and the last one in hexadecimal digits; empty if there is none.
[[nodiscard]] std::pair<std::uint64_t, std::string> last_digest(const Recording& recording);

}  // namespace takt::record
