#pragma once

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "record/comparison.h"
#include "record/curves.h"
#include "record/recording.h"

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

/// Whether the texts of events are judged with them.
enum class Texts { kIgnored, kJudged };

/// Events as a sequence: the same (source, name) in the same order, each within dt; if exact, their texts too.
[[nodiscard]] ColumnComparison compare_events(std::string_view topic, const std::vector<RecordedEvent>& a,
                                              const std::vector<RecordedEvent>& b, const Tolerance& tolerance,
                                              Texts texts = Texts::kIgnored);

/// The end of the run as a column of its own.
[[nodiscard]] ColumnComparison compare_end(Nanoseconds a, Nanoseconds b, const Tolerance& tolerance);

/// A stretch of time in which one curve has samples and the other has none.
struct Hole {
  Nanoseconds from = 0, to = 0;  ///< first and last sample that only the other one has
  std::size_t samples = 0;
};
/// The first hole of `times` against those of `reference` up to `end`. Where all times are times of the reference,
/// each one that is missing counts; else those that are farther from any than `window` and than the reference's own
/// spacing there.
[[nodiscard]] std::optional<Hole> find_hole(std::span<const Nanoseconds> times, std::span<const Nanoseconds> reference,
                                            Nanoseconds end, Nanoseconds window);

/// Adds to `missing`, up to as many as somebody could read.
void note_missing(std::string text, Comparison& comparison);
/// Damage of a recording: what is lost fails the comparison, a torn end is a note.
void note_damage(const Recording& recording, std::string_view name, Comparison& comparison);
/// Messages of a topic that are no rows of its table, or no events.
void note_lost_rows(const Recording& recording, const std::string& topic, std::size_t rows, std::string_view name,
                    Comparison& comparison);
void note_lost_rows(const Recording& recording, const Table& table, std::string_view name, Comparison& comparison);
void note_hole(const std::string& topic, std::string_view name, const std::optional<Hole>& hole,
               Comparison& comparison);

/// How much of a recording the columns of a comparison have judged.
[[nodiscard]] JudgedShare judged_share(const Recording& recording, const Comparison& comparison);
/// Lists the topics that say nothing to the verdict; if nothing does, that fails the comparison.
void note_unjudged(const Recording& a, const Recording& b, Comparison& comparison);

/// Differences of fingerprints, and damage (note_damage), in words.
void note_differences(const Recording& a, std::string_view name_a,
                      const std::map<std::string, std::string>& fingerprint_b, Comparison& comparison);

/// Up to when both runs have to have samples. Where one ends earlier, its last cycles may lack some: its end is judged
/// by itself.
[[nodiscard]] Nanoseconds common_end(const Comparison& comparison);

/// Where steps of the program begin, a thousand at most: more than fit on an axis are of no use.
[[nodiscard]] std::vector<StepMark> steps_of(const Recording& recording);

/// Fills `passed` from columns, missing and, if required, digests.
void judge(const CompareOptions& options, Comparison& comparison);

}  // namespace takt::record
