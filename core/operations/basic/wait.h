#pragma once

#include <optional>
#include <string>

#include "core/expression/condition_state.h"
#include "core/operations/table/operation.h"

/// "wait": lets time pass, or waits until a condition holds, and maybe for a time after which that has failed.
/// Realtime: setup.
namespace takt::operations {

struct WaitParameters {
  std::optional<double> seconds = {};                 ///< s
  std::optional<expression::StateSource> until = {};  ///< nothing: `seconds` pass
  std::optional<double> timeout = {};                 ///< s
  std::string name = {}, pointer = {};                ///< for people; in its file
};
[[nodiscard]] const ParameterTable<WaitParameters>& wait_parameters();
[[nodiscard]] Operation wait_operation();

}  // namespace takt::operations
