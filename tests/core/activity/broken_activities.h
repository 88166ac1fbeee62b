#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/core/activity/activity_cell.h"

namespace takt::test {

/// A wrong use of activities in C++, which throws ActivityError.
struct BrokenActivity {
  std::string what;
  std::function<void(ActivityCell& cell)> wrong;
  std::string place;
  Code code;
  std::vector<std::string> names = {};  ///< in message or hint
  bool moves = false;                   ///< something moved rightly before; else no set point ever changes
};
[[nodiscard]] std::vector<BrokenActivity> broken_activities();
/// Control modes, springs, guiding by hand.
[[nodiscard]] std::vector<BrokenActivity> broken_modes();
/// Parts, loads, tools, frames.
[[nodiscard]] std::vector<BrokenActivity> broken_beliefs();

}  // namespace takt::test
