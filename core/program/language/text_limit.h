#pragma once

#include <cstddef>

namespace takt::program {

/// A text that an expression makes has at most so many bytes.
inline constexpr std::size_t kMostTextBytes = 64u << 10;

}  // namespace takt::program
