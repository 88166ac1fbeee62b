#pragma once

#include <string>
#include <vector>

#include "record/comparison.h"

namespace takt::record {

// Texts that the report for terminals and the HTML report share.

[[nodiscard]] std::string tolerance_text(const ColumnComparison& column);
/// "identical", "same within tolerances" or "different".
[[nodiscard]] std::string verdict_text(const Comparison& comparison);
[[nodiscard]] std::string digest_text(const Comparison& comparison);
/// "4.094 s, step 'main / touch': /arm/set_point a2.position is 0.5123 rad, not 0.5098 rad".
[[nodiscard]] std::string departure_text(const Departure& departure);
/// "'main / touch', from 3.210 s on: 1.236 s, not 1.200 s (+0.036 s)".
[[nodiscard]] std::string duration_text(const StepDuration& step);
/// "/program/steps/3/velocity_m_s: 0.2575, not 0.25".
[[nodiscard]] std::string difference_text(const ScenarioDifference& difference);
/// How much of both files was judged.
[[nodiscard]] std::string share_text(const Comparison& comparison);
/// The columns that are outside, by the time at which they first are.
[[nodiscard]] std::vector<const ColumnComparison*> failed_columns(const Comparison& comparison);
/// The steps that took another time, by their begin.
[[nodiscard]] std::vector<const StepDuration*> other_durations(const Comparison& comparison);

/// The curves of one column as an SVG element: A and the reference B with its tube, below the difference between them;
/// the steps of the program on the axis, as far as their names fit.
[[nodiscard]] std::string draw_column(const ColumnComparison& column, const std::vector<StepMark>& steps);

}  // namespace takt::record
