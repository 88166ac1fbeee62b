#pragma once

#include <string>
#include <vector>

#include "cell/judge/run_log.h"
#include "cell/judge/run_report.h"
#include "sim/film/overlay.h"

namespace takt::cell {

/// What a film says of the program: the step at work with the path that leads to it, what went wrong, for some seconds,
/// and at the end the verdict. Compositions without a name of their own ("branch", "try") are no steps to a reader, and
/// are left out where something else is known. From a run as it happens, or from the events of its recording. Thread:
/// one at a time. Realtime: setup.
class FilmCaption {
 public:
  /// Something happened; in the order of time.
  void happened(const LogEntry& entry);
  /// Something to be shown from `time` on, as an error.
  void fail(Nanoseconds time, const std::string& text);
  /// The run is over: the verdict takes the place of the step. @param held, expectations  how many of how many
  void judge(Verdict verdict, std::size_t held, std::size_t expectations);
  /// Writes step, path, note and time of `time`. @param step  where no step of the program is known, as in one in C++
  void write(Nanoseconds time, const std::string& step, sim::Overlay& overlay) const;

 private:
  void follow_steps(const LogEntry& entry);
  void show(Nanoseconds time, LogLevel level, std::string text);

  std::vector<std::string> running_;  ///< paths of the steps, the one that began last at the end
  std::string note_, verdict_;
  sim::Overlay::Tone tone_ = sim::Overlay::Tone::kPlain;  ///< of the verdict
  Nanoseconds since_ = 0;
  LogLevel level_ = LogLevel::kDebug;
};

}  // namespace takt::cell
