#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"

namespace takt::motion {

/// How hard the path parameter s may be braked on a part of a path (docs/motion.md, "Stops"). At rate r of the path
/// clock a stop keeps every limit with
///
///     deceleration of s   D <= min(deceleration - (deceleration - deceleration_at_full_rate) r^2, product / r)
///     third derivative    |s'''| <= jerk - jerk_by_cube r^3 - jerk_by_product r D
///
/// As JSON: [s_end, deceleration, deceleration_at_full_rate, product, jerk, jerk_by_cube, jerk_by_product].
struct StopCell {
  double s_end = 1.0;                                                          ///< it begins where the last one ends
  double deceleration = std::numeric_limits<double>::infinity();               ///< 1/s^2
  double deceleration_at_full_rate = std::numeric_limits<double>::infinity();  ///< 1/s^2, not above it
  double product = std::numeric_limits<double>::infinity();                    ///< of D and r, 1/s^2
  double jerk = std::numeric_limits<double>::infinity();                       ///< 1/s^3
  double jerk_by_cube = 0.0;                                                   ///< 1/s^3
  double jerk_by_product = 0.0;                                                ///< 1/s
};

/// Cells from s = 0 to s = 1. Empty: nothing is known.
using StopTable = std::vector<StopCell>;

/// One bounded quantity at one point of a path: derivatives by s, and its limits.
struct StopLoad {
  double first = 0.0;   ///< its length
  double along = 0.0;   ///< part of the second derivative in the direction of the first; < 0: against it
  double across = 0.0;  ///< part at right angles to it (vectors only)
  double third = 0.0;   ///< length of the third one
  double acceleration = std::numeric_limits<double>::infinity();
  double jerk = std::numeric_limits<double>::infinity();
};

/// The cell in which all loads keep their limits. @param fastest  largest s' of the law there, 1/s   Realtime: setup.
[[nodiscard]] StopCell stop_cell(std::span<const StopLoad> loads, double fastest, double s_end);

/// What keeps both; empty if one is empty. Realtime: setup.
[[nodiscard]] StopTable common(const StopTable& a, const StopTable& b);

/// Neighbours that differ by less than some per cent become one cell, which keeps the limits of both. Realtime: setup.
[[nodiscard]] StopTable simplified(const StopTable& table);

/// Adds a table of a path that becomes the part of another one that ends at s_end: its cells are of that path's s.
/// Realtime: setup.
void append(StopTable& table, const StopTable& part, double s_end);

[[nodiscard]] nlohmann::ordered_json to_json(const StopTable& table);
/// Diagnostics: no list of cells, entries that are no numbers, cells that do not go from s = 0 to 1. Realtime: setup.
[[nodiscard]] Result<StopTable> stop_table_from_json(const nlohmann::ordered_json& json, const std::string& pointer);

}  // namespace takt::motion
