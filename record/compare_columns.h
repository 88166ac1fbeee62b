#pragma once

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "record/compare.h"
#include "record/curves.h"

namespace takt::record {

// The parts of a comparison that recordings and goldens share.

/// Who is compared, under which tolerance.
struct ColumnId {
  std::string topic, column, unit;
};

[[nodiscard]] Tolerance choose_tolerance(const std::vector<ToleranceRule>& rules, std::string_view topic,
                                         std::string_view column, const Tolerance& otherwise);

/// One column of the run under test against the reference. `plot_points` = 0: no curves.
[[nodiscard]] ColumnComparison compare_column(const ColumnId& id, const CurveView& a, const CurveView& b,
                                              const Tolerance& tolerance, std::size_t plot_points);

/// An orientation over time, as four curves.
struct RotationView {
  std::span<const Nanoseconds> time;
  std::array<std::span<const double>, 4> wxyz;
};

/// The name without its last part, if this column and the three after it are the parts of a quaternion: "FRAME".
[[nodiscard]] std::optional<std::string> rotation_at(std::span<const std::string> columns, std::size_t first);

/// Two orientations: the angle between them at the times of A, rad, against zero; with a tube the least one within dt.
[[nodiscard]] ColumnComparison compare_rotation(const ColumnId& id, const RotationView& a, const RotationView& b,
                                                const Tolerance& tolerance, std::size_t plot_points);

/// Events as a sequence: the same (source, name) in the same order, each within dt; texts too if exact.
[[nodiscard]] ColumnComparison compare_events(std::string_view topic, const std::vector<RecordedEvent>& a,
                                              const std::vector<RecordedEvent>& b, const Tolerance& tolerance);

/// The end of the run as a column of its own.
[[nodiscard]] ColumnComparison compare_end(Nanoseconds a, Nanoseconds b, const Tolerance& tolerance);

/// Differences of fingerprints and torn ends, in words.
void note_differences(const Recording& a, std::string_view name_a,
                      const std::map<std::string, std::string>& fingerprint_b, Comparison& comparison);

/// Where steps of the program begin, a thousand at most: more than fit on an axis are of no use.
[[nodiscard]] std::vector<StepMark> steps_of(const Recording& recording);

/// Fills `passed` from columns, missing and, if required, digests.
void judge(const CompareOptions& options, Comparison& comparison);

}  // namespace takt::record
