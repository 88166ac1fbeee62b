#include "cell/judge/run_log.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::cell {
namespace {

/// What an event of a source means; an empty source stands for any. The first row that fits counts.
struct LevelRow {
  std::string_view source, name;
  LogLevel level;
};
constexpr LevelRow kLevels[] = {
    {"program", "begin", LogLevel::kDebug},
    {"program", "end", LogLevel::kDebug},
    {"program", "let", LogLevel::kDebug},
    {"program", "branch", LogLevel::kDebug},
    {"program", "text", LogLevel::kDebug},
    {"program", "stop", LogLevel::kInfo},
    {"program", "no blend", LogLevel::kInfo},
    {"program", "failed", LogLevel::kWarning},
    {"program", "retry", LogLevel::kWarning},
    {"program", "handled", LogLevel::kWarning},
    {"operator", "cancel", LogLevel::kWarning},
    {"operator", "abort", LogLevel::kWarning},
    {"contact", "unexpected", LogLevel::kError},
    {"contact", "forgotten", LogLevel::kWarning},
    {kExpectationSource, "held", LogLevel::kDebug},
    {kExpectationSource, "not held", LogLevel::kWarning},
    {"fault", "", LogLevel::kWarning},
    {"", "fault", LogLevel::kError},
    {"", "guard", LogLevel::kError},
    {"", "lost", LogLevel::kWarning},
    {"run", "error", LogLevel::kError},
    {"run", "interrupted", LogLevel::kWarning},
};

}  // namespace

LogLevel level_of(std::string_view source, std::string_view name) {
  const auto row = std::ranges::find_if(kLevels, [&](const LevelRow& one) {
    return (one.source.empty() || one.source == source) && (one.name.empty() || one.name == name);
  });
  return row == std::end(kLevels) ? LogLevel::kInfo : row->level;
}

const std::vector<std::string>& log_level_names() {
  static const std::vector<std::string> names{"debug", "info", "warning", "error"};
  return names;
}

std::string_view name_of(LogLevel level) {
  const int number = std::clamp(static_cast<int>(level), 1, 4);  // "fatal" is an error too
  return log_level_names()[static_cast<std::size_t>(number - 1)];
}

std::optional<LogLevel> log_level_named(std::string_view name) {
  const auto found = std::ranges::find(log_level_names(), name);
  if (found == log_level_names().end()) return std::nullopt;
  return static_cast<LogLevel>(found - log_level_names().begin() + 1);
}

std::string to_text(const LogEntry& entry) {
  const bool marked = entry.level >= LogLevel::kWarning;
  const std::string what = entry.source == entry.name ? entry.name : entry.source + " " + entry.name;
  std::string text = fmt::format("{:9.3f} s  {}{}", to_seconds(entry.time),
                                 marked ? fmt::format("{}: ", name_of(entry.level)) : "", what);
  if (!entry.text.empty()) text += fmt::format(": {}", entry.text);
  if (!entry.step.empty()) text += fmt::format("  [{}]", entry.step);
  return text;
}

nlohmann::ordered_json to_json(const LogEntry& entry) {
  return {{"time_s", to_seconds(entry.time)},
          {"cycle", entry.cycle},
          {"level", name_of(entry.level)},
          {"source", entry.source},
          {"name", entry.name},
          {"step", entry.step},
          {"text", entry.text}};
}

void RunLog::add(LogEntry entry) {
  if (first_.size() < most_ / 2) return first_.push_back(std::move(entry));
  last_.push_back(std::move(entry));
  if (last_.size() <= most_ - most_ / 2) return;
  last_.pop_front();
  ++omitted_;
}

std::vector<LogEntry> RunLog::entries() const {
  std::vector<LogEntry> all = first_;
  all.insert(all.end(), last_.begin(), last_.end());
  return all;
}

}  // namespace takt::cell
