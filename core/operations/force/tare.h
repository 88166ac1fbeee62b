#pragma once

#include <cstdint>
#include <string>

#include "core/operations/table/operation.h"

/// "tare": averages a force/torque sensor at rest and keeps the offset for all later conditions. Realtime: setup.
namespace takt::operations {

struct TareParameters {
  std::string sensor = {};              ///< empty: the only one
  std::int64_t cycles = 500;            ///< that are averaged
  std::string name = {}, pointer = {};  ///< for people; in its file
};
[[nodiscard]] const ParameterTable<TareParameters>& tare_parameters();
[[nodiscard]] Operation tare_operation();

}  // namespace takt::operations
