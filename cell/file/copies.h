#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"

namespace takt::cell {

/// Writes out what a scenario file says once for many (docs/scenarios.md):
/// - a text "$NAME" outside of programs is the value of `parameters`; the program has them as variables, and
///   `parameter_ranges` says what may be given to them;
/// - an object or an expectation with `copies` stands for as many; "#" in its texts is the number of the copy,
///   from 1, and each copy stands one `step_m` further.
/// `copies`, `parameters` and their ranges are gone then. Pointers of diagnostics are those of the file.
/// Realtime: setup.
void write_out_copies(nlohmann::ordered_json& document, Diagnostics& diagnostics);

}  // namespace takt::cell
