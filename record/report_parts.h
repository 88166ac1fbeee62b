#pragma once

#include <string>
#include <vector>

#include "record/compare.h"

namespace takt::record {

// Texts that the report for terminals and the HTML report share.

[[nodiscard]] std::string tolerance_text(const ColumnComparison& column);
/// "identical", "same within tolerances" or "different".
[[nodiscard]] std::string verdict_text(const Comparison& comparison);
[[nodiscard]] std::string digest_text(const Comparison& comparison);

/// The curves of one column as an SVG element: A and the reference B with its tube, below the difference between them;
/// the steps of the program on the axis, as far as their names fit.
[[nodiscard]] std::string draw_column(const ColumnComparison& column, const std::vector<StepMark>& steps);

}  // namespace takt::record
