#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/base/time.h"
#include "record/compare.h"
#include "record/recording.h"

namespace takt::record {

/// One column of a golden: points chosen so that straight lines between them stay within `thinning` of every sample.
struct GoldenColumn {
  std::string topic, column, unit;
  Tolerance tolerance;
  double thinning = 0.0;              ///< in the column's unit, a quarter of the tolerance, or half of it if need be
  std::vector<double> time_s, value;  ///< NaN = null from here to the next point
};

struct GoldenEvent {
  std::string topic, source, name;
  double time_s = 0.0;
};

/// A run that a person has looked at and approved, small enough for the repository. It is compared with tolerances, so
/// that it holds across machines and harmless changes of code; whether the digest is still the same is told, and judged
/// only on request (row D5).
struct Golden {
  std::string scenario;  ///< as the caller names it
  std::string reason;    ///< why this run is right, in words; never empty
  std::map<std::string, std::string> fingerprint;
  std::uint64_t cycles = 0;
  double end_s = 0.0;
  std::string digest;  ///< of the last cycle, 16 hexadecimal digits; empty if the run has none
  std::vector<GoldenColumn> columns;
  Tolerance event_tolerance;
  std::vector<GoldenEvent> events;
};

struct BlessOptions {
  std::string scenario;
  std::string reason;
  /// Tolerances as in a comparison; columns of kReportOnly are left out.
  std::vector<ToleranceRule> rules;
  /// Topics that go in, with '*'; empty: every table but takt.SimState.
  std::vector<std::string> topics;
  /// Above this the golden is refused: it would not stay in a repository's review.
  std::size_t max_bytes = 100'000;
};

/// A golden from a run. Diagnostics: no reason, a truncated recording, no columns, too large (with the largest
/// columns).
[[nodiscard]] Result<Golden> make_golden(const Recording& recording, const BlessOptions& options);

[[nodiscard]] std::string golden_to_text(const Golden& golden);
[[nodiscard]] Result<Golden> golden_from_json(const nlohmann::ordered_json& json);
[[nodiscard]] Result<Golden> read_golden(const std::filesystem::path& path);

/// A run against a golden, with the golden's tolerances; rules in `options` come before them.
[[nodiscard]] Comparison compare_with_golden(const Recording& recording, const Golden& golden,
                                             const CompareOptions& options = {});

/// `takt bless`: recording in, golden file out; returns what was written.
[[nodiscard]] Result<Golden> bless(const std::filesystem::path& recording, const std::filesystem::path& golden,
                                   const BlessOptions& options);
/// `takt verify`: recording against golden file.
[[nodiscard]] Result<Comparison> verify(const std::filesystem::path& recording, const std::filesystem::path& golden,
                                        const CompareOptions& options = {});

}  // namespace takt::record
