#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/time.h"
#include "record/recorder.h"

namespace takt::cell {

using record::LogLevel;

/// Who tells what became of the expectations.
inline constexpr std::string_view kExpectationSource = "expectation";

/// One line of what a run tells of itself: on the terminal, with --json, in the recording, by `takt events`.
struct LogEntry {
  Nanoseconds time = 0;  ///< simulated
  std::uint64_t cycle = 0;
  LogLevel level = LogLevel::kInfo;
  std::string source = {};  ///< who: "program", "operator", "fault", "contact", "run", a device, a net
  std::string name = {};    ///< what, a word that programs may rely on: "begin", "retry", "contact"
  std::string step = {};    ///< path of the steps in which it happened: "sort / for_each (2) / grip"; may be empty
  std::string text = {};    ///< for people, with numbers
};

/// How much an event matters (docs/recording.md has the table). Realtime: setup.
[[nodiscard]] LogLevel level_of(std::string_view source, std::string_view name);
/// "debug", "info", "warning", "error".
[[nodiscard]] std::string_view name_of(LogLevel level);
/// The level of this name; nothing: there is none.
[[nodiscard]] std::optional<LogLevel> log_level_named(std::string_view name);
/// All names, the least first.
[[nodiscard]] const std::vector<std::string>& log_level_names();

/// "    3.517 s  warning: program retry: touch the top (1 of 3): no contact  [measure / touch the top]"
[[nodiscard]] std::string to_text(const LogEntry& entry);
/// time_s, cycle, level, source, name, step, text.
[[nodiscard]] nlohmann::ordered_json to_json(const LogEntry& entry);

/// The entries of a run in memory: all of them, or the first and the last ones of very many.
class RunLog {
 public:
  explicit RunLog(std::size_t most = 10'000) : most_(most) {}

  void add(LogEntry entry);
  /// In the order of time.
  [[nodiscard]] std::vector<LogEntry> entries() const;
  /// How many were left out between the first and the last ones.
  [[nodiscard]] std::int64_t omitted() const { return omitted_; }

 private:
  std::size_t most_;
  std::vector<LogEntry> first_;
  std::deque<LogEntry> last_;
  std::int64_t omitted_ = 0;
};

}  // namespace takt::cell
