#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "record/comparison.h"
#include "record/recording.h"

namespace takt::record {

/// The tolerance of a column when nobody states one, by its unit: rad 2e-3, m 5e-4, N 0.5, Nm 0.2, ...
[[nodiscard]] Tolerance default_tolerance(std::string_view topic, std::string_view unit);

/// Compares two recordings. Diagnostics: an unreadable file. Realtime: setup.
[[nodiscard]] Result<Comparison> compare_recordings(const std::filesystem::path& a, const std::filesystem::path& b,
                                                    const CompareOptions& options = {});
[[nodiscard]] Comparison compare(const Recording& a, const Recording& b, const CompareOptions& options = {});

/// For a terminal: the verdict first, then the columns that are outside, at most `most` lines of each kind.
[[nodiscard]] std::string to_text(const Comparison& comparison, std::size_t most = 20);
/// For machines; no curves inside.
[[nodiscard]] nlohmann::ordered_json to_json(const Comparison& comparison);
/// For people: one self-contained HTML page with the curves, the tube and the deviation of each column.
[[nodiscard]] std::string to_html(const Comparison& comparison);
/// to_html into a file.
[[nodiscard]] Result<void> write_report(const Comparison& comparison, const std::filesystem::path& path);

}  // namespace takt::record
