#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/form_of.h"

namespace takt::cell {

/// "copies": so many, each one step (m) further.
struct Copies {
  std::int64_t count = 0;
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
};
[[nodiscard]] const FormOf<Copies>& copies_form();

extern const NameRule kParameterName;
/// The values that a parameter may have.
struct ParameterRange {
  Range range = kAnyNumber;
  bool whole = false;
  std::vector<std::string> choices = {};
};
[[nodiscard]] const FormOf<ParameterRange>& parameter_range_form();

/// Writes out what a scenario file says once for many (docs/scenarios.md):
/// - a text "$NAME" outside of programs is the value of `parameters`; the program has them as variables, and
///   `parameter_ranges` says what may be given to them;
/// - an object or an expectation with `copies` stands for as many; "#" in its texts is the number of the copy,
///   from 1, and each copy stands one `step_m` further.
/// `copies`, `parameters` and their ranges are gone then. Pointers of diagnostics are those of the file.
/// Realtime: setup.
void write_out_copies(nlohmann::ordered_json& document, Diagnostics& diagnostics);

}  // namespace takt::cell
