#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"

namespace takt {

/// What an input file may be at most; beyond it libraries under us have crashed (docs/architecture.md, "Bounded
/// input").
struct InputLimits {
  std::size_t bytes = 4u << 20;
  std::size_t depth = 64;
};

/// JSON (RFC 8259, UTF-8) with the rules of every takt file: one value, no duplicate keys, finite numbers, bounded size
/// and depth. Diagnostics carry the JSON pointer, or line and column for a syntax error. Keeps the order of keys.
/// Realtime: setup.
[[nodiscard]] Result<nlohmann::ordered_json> parse_json(std::string_view text, const InputLimits& limits = {});

/// parse_json for a file; the diagnostics name it as `path` is written.
[[nodiscard]] Result<nlohmann::ordered_json> read_json(const std::filesystem::path& path,
                                                       const InputLimits& limits = {});

/// The bytes of a file, at most `max_bytes`; an unreadable, larger or missing file is a diagnostic.
[[nodiscard]] Result<std::string> read_file(const std::filesystem::path& path, std::size_t max_bytes);

/// Resolves `relative` below `root` and refuses what leaves it: absolute paths, "..", links that point outside.
/// `relative` is UTF-8 text from a file; diagnostics are at `pointer`.
[[nodiscard]] Result<std::filesystem::path> resolve_below(const std::filesystem::path& root, std::string_view relative,
                                                          const std::string& pointer);

}  // namespace takt
