#pragma once

#include <string>
#include <string_view>

#include "core/net/unit.h"

namespace takt::net {

/// The unit in which files give a number, beside the SI unit in which takt computes.
struct FileUnit {
  Dimension dimension;        ///< of the SI unit
  double si_per_unit = 1.0;   ///< SI value of one unit: pi / 180 for degrees
  double units_per_si = 1.0;  ///< its inverse, kept apart so that neither direction rounds twice
};

/// Reads "N", "deg/s", "m/s^2", "1": SI units and degrees. An empty text means a number without a unit.
/// Asserts on a text that is no unit: texts come from tables, not from users. Realtime: setup.
[[nodiscard]] FileUnit file_unit(std::string_view text);

/// The part of a key that names the unit: "_m_s2" of "m/s^2", "_Nm_rad" of "Nm/rad"; empty for no unit.
[[nodiscard]] std::string key_suffix(std::string_view unit);

}  // namespace takt::net
