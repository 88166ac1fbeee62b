#pragma once

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/net/value.h"

namespace takt::net {

/// Text for people, made without allocation and cut to what a Text holds. Realtime: cyclic.
template <class... Args>
[[nodiscard]] Text format_text(fmt::format_string<Args...> format, Args&&... args) {
  std::array<char, 63> buffer;
  const auto end = fmt::format_to_n(buffer.data(), buffer.size(), format, std::forward<Args>(args)...);
  return Text(std::string_view(buffer.data(), std::min(end.size, buffer.size())));
}

}  // namespace takt::net
