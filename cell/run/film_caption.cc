#include "cell/run/film_caption.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::cell {
namespace {

constexpr Nanoseconds kShown = 4 * kSecond;
/// What follows from a failure comes at once, and the failure says more.
constexpr Nanoseconds kFirstCounts = kSecond;
constexpr std::string_view kPathSeparator = " / ";

}  // namespace

void FilmCaption::happened(const LogEntry& entry) {
  follow_steps(entry);
  if (entry.level < LogLevel::kWarning) return;
  show(entry.time, entry.level,
       entry.text.empty() ? fmt::format("{} {}", entry.source, entry.name)
                          : fmt::format("{} {}: {}", entry.source, entry.name, entry.text));
}

void FilmCaption::fail(Nanoseconds time, const std::string& text) { show(time, LogLevel::kError, text); }

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
    const std::string& path = running_.back();
    const std::size_t last = path.rfind(kPathSeparator);
    overlay.step = last == path.npos ? path : path.substr(last + kPathSeparator.size());
    if (last != path.npos) overlay.path = path.substr(0, last);
  }
  if (!note_.empty() && time - since_ < kShown) overlay.note = note_;
}

}  // namespace takt::cell
