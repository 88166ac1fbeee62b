#pragma once

#include <optional>
#include <string>

#include "core/operations/table/operation.h"

/// "net": runs a net of the cell to its end. Realtime: setup.
namespace takt::operations {

struct NetParameters {
  std::string net = {};                     ///< of the cell
  std::optional<double> cancel_after = {};  ///< s
  double within = 60.0;                     ///< s; a net that runs longer is a failure
  std::optional<double> monitor_rate = {};  ///< Hz, at which its monitors are shown while it runs; nothing: at its end
  std::string name = {}, pointer = {};      ///< for people; in its file
};
[[nodiscard]] const ParameterTable<NetParameters>& net_parameters();
[[nodiscard]] Operation net_operation();

}  // namespace takt::operations
