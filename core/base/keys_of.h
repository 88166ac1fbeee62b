#pragma once

#include <string>
#include <vector>

namespace takt {

/// The keys of a map of names, in its order: what a diagnostic offers (nearest_choice()). Realtime: setup.
template <class Map>
[[nodiscard]] std::vector<std::string> keys_of(const Map& map) {
  std::vector<std::string> keys;
  keys.reserve(map.size());
  for (const auto& [key, value] : map) keys.push_back(key);
  return keys;
}

}  // namespace takt
