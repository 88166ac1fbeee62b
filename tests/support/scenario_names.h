#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace takt::test {

/// Names of the scenarios of the repository, in order: "touch" for scenarios/touch.json.
inline std::vector<std::string> scenario_names() {
  std::vector<std::string> names;
  std::error_code nowhere;  // run from another folder: no names, and gtest complains of a test without parameters
  for (const auto& entry : std::filesystem::directory_iterator("scenarios", nowhere)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(".json") && !name.ends_with(".golden.json")) names.push_back(entry.path().stem().string());
  }
  std::ranges::sort(names);
  return names;
}

}  // namespace takt::test
