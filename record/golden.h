#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "record/comparison.h"
#include "record/golden_data.h"
#include "record/recording.h"

namespace takt::record {

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
