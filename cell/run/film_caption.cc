#include "cell/run/film_caption.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/program/tree/node.h"

namespace takt::cell {
namespace {

constexpr Nanoseconds kShown = 4 * kSecond;
/// What follows from a failure comes at once, and the failure says more.
constexpr Nanoseconds kFirstCounts = kSecond;
constexpr std::string_view kPathSeparator = " / ";

/// "try", "repeat (2)": a composition that is called by its type, as those without a name are.
bool is_type(std::string_view segment) {
  const std::string_view name = segment.ends_with(')') ? segment.substr(0, segment.rfind(" (")) : segment;
  return std::ranges::any_of(program::node_kinds(), [&](const program::NodeKind& kind) { return kind.name == name; });
}

/// The segments of a path that say something; all of them if none does.
std::vector<std::string_view> said(std::string_view path) {
  std::vector<std::string_view> all, named;
  while (!path.empty()) {
    const std::size_t end = path.find(kPathSeparator);
    all.push_back(path.substr(0, end));
    if (!is_type(all.back())) named.push_back(all.back());
    path.remove_prefix(end == path.npos ? path.size() : end + kPathSeparator.size());
  }
  return named.empty() ? all : named;
}

}  // namespace

void FilmCaption::happened(const LogEntry& entry) {
  follow_steps(entry);
  if (entry.level < LogLevel::kWarning) return;
  show(entry.time, entry.level,
       entry.text.empty() ? fmt::format("{} {}", entry.source, entry.name)
                          : fmt::format("{} {}: {}", entry.source, entry.name, entry.text));
}

void FilmCaption::fail(Nanoseconds time, const std::string& text) { show(time, LogLevel::kError, text); }

void FilmCaption::judge(Verdict verdict, std::size_t held, std::size_t expectations) {
  verdict_ = name_of(verdict);
  if (expectations > 0 && (verdict == Verdict::kPassed || verdict == Verdict::kFailed))
    verdict_ += fmt::format(": {} of {} expectations held", held, expectations);
  tone_ = verdict == Verdict::kPassed ? sim::Overlay::Tone::kGood : sim::Overlay::Tone::kBad;
}

void FilmCaption::show(Nanoseconds time, LogLevel level, std::string text) {
  const bool shown = !note_.empty() && time - since_ < kShown;
  if (shown && (level < level_ || (level == LogLevel::kError && level_ == level && time - since_ < kFirstCounts)))
    return;
  note_ = std::move(text);
  since_ = time;
  level_ = level;
}

void FilmCaption::follow_steps(const LogEntry& entry) {
  if (entry.source != "program") return;
  if (entry.name == "begin") {
    running_.push_back(entry.step);
  } else if (entry.name == "end" || entry.name == "failed") {
    const auto step = std::ranges::find(running_, entry.step);
    if (step != running_.end()) running_.erase(step);
  }
}

void FilmCaption::write(Nanoseconds time, const std::string& step, sim::Overlay& overlay) const {
  overlay.time = time;
  overlay.step = step;
  if (!running_.empty()) {
    std::vector<std::string_view> segments = said(running_.back());
    overlay.step = segments.back();
    segments.pop_back();
    overlay.path = fmt::format("{}", fmt::join(segments, kPathSeparator));
  }
  if (!verdict_.empty()) {
    overlay.step = verdict_;
    overlay.step_tone = tone_;
    overlay.path.clear();
  }
  if (!note_.empty() && time - since_ < kShown) overlay.note = note_;
}

}  // namespace takt::cell
