#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/expression/cell.h"

namespace takt::cell {

/// The newest value of a signal, digital ones as 0 or 1: sampled of an input, sent of an output. Nothing: it has none.
/// Realtime: cyclic.
using SignalReader = std::function<std::optional<double>()>;

/// A digital or analog input or output of a cell.
struct NamedSignal {
  std::string name;
  std::string unit;  ///< empty for a digital one
  bool digital = true;
  SignalReader read;
};

/// All signals of a cell: digital inputs, digital outputs, analog inputs, analog outputs, each by name.
/// Realtime: setup.
[[nodiscard]] std::vector<NamedSignal> signals_of(const expression::Cell& cell);

}  // namespace takt::cell
