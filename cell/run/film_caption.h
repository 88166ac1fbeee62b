#pragma once

#include <string>
#include <vector>

#include "cell/judge/run_log.h"
#include "sim/film/overlay.h"

namespace takt::cell {

/// What a film says of the program: the step at work with the path that leads to it, and what went wrong, for some
/// seconds. From a run as it happens, or from the events of its recording. Thread: one at a time. Realtime: setup.
class FilmCaption {
 public:
  /// Something happened; in the order of time.
  void happened(const LogEntry& entry);
  /// Something to be shown from `time` on, as an error.
  void fail(Nanoseconds time, const std::string& text);
  /// Writes step, path, note and time of `time`. @param step  where no step of the program is known, as in one in C++
  void write(Nanoseconds time, const std::string& step, sim::Overlay& overlay) const;

 private:
  void follow_steps(const LogEntry& entry);
  void show(Nanoseconds time, LogLevel level, std::string text);

  std::vector<std::string> running_;  ///< paths of the steps, the one that began last at the end
  std::string note_;
  Nanoseconds since_ = 0;
  LogLevel level_ = LogLevel::kDebug;
};

}  // namespace takt::cell
