#pragma once

#include <optional>
#include <string>

namespace takt::cell {

/// What came of one expectation.
struct ExpectationResult {
  std::string name = {}, kind = {};
  bool passed = false;
  bool judged = true;                            ///< false: the run says neither yes nor no; `passed` is false then
  std::string measured = {};                     ///< for people: value, unit, bound
  double value = 0.0;                            ///< what was measured, in `unit`
  std::string unit = {};                         ///< "m", "N", "s"; empty: a count, a share or a plain number
  std::optional<double> lower = {}, upper = {};  ///< what `value` has to keep, in `unit`
};

}  // namespace takt::cell
