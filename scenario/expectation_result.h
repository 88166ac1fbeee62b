#pragma once

#include <string>

namespace takt::scenario {

/// What came of one expectation.
struct ExpectationResult {
  std::string name = {}, kind = {};
  bool passed = false;
  std::string measured = {};  ///< for people: value, unit, bound
  double value = 0.0;         ///< what was measured, in the unit of `measured`
};

}  // namespace takt::scenario
