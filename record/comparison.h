#pragma once

#include <bitset>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/base/time.h"

namespace takt::record {

/// How closely a column must follow the other run.
enum class ToleranceKind {
  kExact,       ///< the same samples at the same times, bit for bit
  kTube,        ///< within dv of the reference somewhere within dt around each time
  kFeatures,    ///< only what Tolerance::features names: values within dv, times within dt
  kReportOnly,  ///< shown, never judged
};

/// What is left of a curve when its course does not matter. All are reported; a tolerance says which are judged.
enum class Feature : std::uint8_t {
  kMax,
  kMin,
  kMean,  ///< over time
  kEnd,
  kPeak,      ///< greatest magnitude: of a force
  kSettling,  ///< s: from then on it stays within dv of its last value
  kPath,      ///< length of the way up and down, without turns smaller than dv; judged within 2 dv for each turn
  kDuration,  ///< s: from the first value to the last
};
inline constexpr std::size_t kFeatureCount = 8;
using FeatureSet = std::bitset<kFeatureCount>;
/// "max", "min", "mean", "end", "peak", "settling", "path", "duration".
[[nodiscard]] std::string_view name_of(Feature feature);
/// All of them, in the order of their numbers.
[[nodiscard]] std::vector<std::string> feature_names();
/// Adds the feature of a name to `features`; what is none goes to `diagnostics`.
void judge_feature(const std::string& name, const std::string& pointer, FeatureSet& features, Diagnostics& diagnostics);

struct Tolerance {
  ToleranceKind kind = ToleranceKind::kTube;
  Nanoseconds dt = 5 * kMillisecond;  ///< half width of the tube in time; for events the window; for times of features
  double dv = 0.0;                    ///< half width in value, in the column's unit
  FeatureSet features{0b1111};        ///< that are judged, by number; default: max, min, mean, end
  friend bool operator==(const Tolerance&, const Tolerance&) = default;
};

/// A tolerance for the columns whose "topic" and "column" match; '*' stands for any run of characters.
struct ToleranceRule {
  std::string topic = "*";
  std::string column = "*";
  Tolerance tolerance;
};

struct CompareOptions {
  /// The first rule that matches counts; without one the default of the column's unit (default_tolerance).
  std::vector<ToleranceRule> rules;
  /// Two runs of the same build must have the same digests: one differing bit is a failure, whatever the tolerances.
  bool require_equal_digests = false;
  /// Only the curves of these topics are compared, '*' stands for any run of characters; no digests, no events. Empty:
  /// all, but for what was commanded.
  std::vector<std::string> topics = {};
  /// Points kept per curve for the report.
  std::size_t plot_points = 1200;
  /// Values of both recordings that are in memory at a time; 0: mcap::ReadLimits::kTableValues. More are compared in
  /// several passes over the files.
  std::size_t values_at_a_time = 0;
};

/// The first cycle whose digests differ; state of the two runs before it is equal to the bit.
struct DigestDifference {
  std::uint64_t cycle = 0;
  Nanoseconds time = 0;
  std::uint64_t a = 0, b = 0;
  std::string block = {};  ///< the first block that differs, if both recordings tell blocks apart
  std::string bit = {};    ///< block, place and bit in words, if somebody ran both again
};

/// A value of one feature in both runs.
struct FeatureDifference {
  std::string name;  ///< of the feature
  double a = 0.0, b = 0.0;
  bool passed = true;
  bool judged = true;
};

/// A curve thinned for drawing: least and greatest value of each stretch of time are kept. NaN = null.
struct PlotCurve {
  std::vector<double> time_s, value;
};

/// What came out for one column (or for one channel of events).
struct ColumnComparison {
  std::string topic, column, unit;
  Tolerance tolerance;
  bool passed = true;
  /// Greatest distance of A from the reference's tube axis, already with the freedom dt in time; inf if one run has
  /// null where the other has a value.
  double max_deviation = 0.0;
  /// The greatest difference at equal times, without any freedom: for people.
  double max_difference = 0.0;
  Nanoseconds time = 0;  ///< of max_deviation
  /// The first time outside; nothing: it is inside, or judged by features, which have no time.
  std::optional<Nanoseconds> first_outside = {};
  double first_a = std::numeric_limits<double>::quiet_NaN();
  double first_b = std::numeric_limits<double>::quiet_NaN();  ///< the values there
  double a = std::numeric_limits<double>::quiet_NaN();
  double b = std::numeric_limits<double>::quiet_NaN();  ///< the values there
  std::uint64_t samples_outside = 0;
  std::vector<FeatureDifference> features;
  std::string note;            ///< in words, if numbers do not say it
  PlotCurve curve_a, curve_b;  ///< for the report; curve_b is empty where both are equal throughout
};

/// When a step of the program began.
struct StepMark {
  double time_s = 0.0;
  std::string name;
};

/// How much of a recording a comparison judged.
struct JudgedShare {
  std::size_t channels = 0, channels_in_file = 0;  ///< with messages
  std::uint64_t messages = 0, messages_in_file = 0;
};

/// Where a run first leaves its reference.
struct Departure {
  Nanoseconds time = 0;
  std::string step = {};  ///< path of the step that runs then; empty: none does, or the run has no steps
  std::string topic, column, unit;
  double a = std::numeric_limits<double>::quiet_NaN();
  double b = std::numeric_limits<double>::quiet_NaN();
  std::string note = {};  ///< of events, in words
};

/// How long a step took in both runs; a step that only one of them has lacks the other's duration.
struct StepDuration {
  std::string step;       ///< its path, with "#2" for the second time that it runs
  Nanoseconds begin = 0;  ///< in A, or where only B has it in B
  std::optional<Nanoseconds> a = {}, b = {};
  bool same = true;  ///< within the window of events
};

/// A value that the scenarios of two recordings do not share. Empty: it is not there.
struct ScenarioDifference {
  std::string pointer, a, b;
};

/// Two runs side by side. A is the run under test, B the reference (the second recording, or a golden).
struct Comparison {
  std::string name_a, name_b;
  bool identical = false;  ///< equal digests in every cycle, same number of cycles
  bool passed = false;     ///< every judged column is inside, no channel is missing
  bool digests_compared = false;
  std::optional<DigestDifference> first_difference;
  std::uint64_t cycles_a = 0, cycles_b = 0;
  Nanoseconds end_a = 0, end_b = 0;
  std::vector<ColumnComparison> columns;  ///< in the order of the recordings
  std::vector<std::string> missing;       ///< what only one side has, or cannot be read; fails the comparison
  JudgedShare judged_a, judged_b;         ///< of a golden: its columns, and its points
  std::vector<std::string> not_judged;    ///< topics with messages that say nothing to the verdict
  std::optional<Departure> departure;     ///< if a column with a time is outside
  std::vector<StepDuration> durations;    ///< of the steps of the program, in the order of A
  std::vector<ScenarioDifference> scenario_differences;  ///< a hundred at most
  std::vector<std::string> notes;                        ///< differing fingerprints, truncation: reported, not judged
  std::vector<StepMark> steps;                           ///< of A, for the report
  std::string film_a, film_b;                            ///< MP4 files as they are, for the report; empty: none
};

}  // namespace takt::record
