#pragma once

#include <string>
#include <vector>

#include "core/expression/state.h"

namespace takt::expression {

/// A number inside a state that is compared with a constant.
struct Comparison {
  RealSensor quantity;
  std::string text;  ///< "wrist above 30": what the number is of, and its bound in the unit of the number
};

/// The comparisons of a state, each text once, in the order of the formula. Realtime: setup.
[[nodiscard]] std::vector<Comparison> comparisons_of(const State& state);

}  // namespace takt::expression
