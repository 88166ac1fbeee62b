#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>

#include "cell/judge/expectation_result.h"
#include "cell/judge/run_log.h"
#include "cell/judge/site_report.h"
#include "core/activity/scheduler.h"
#include "core/base/diagnostics.h"
#include "core/base/time.h"
#include "sim/film/renderer.h"

namespace takt::cell {

struct BuiltCell;
class Operator;

/// A step of the program that is about to begin, for who goes through it step by step.
struct NextStep {
  std::string name, pointer;         ///< of the file
  double sim_time = 0.0;             ///< s
  std::vector<std::string> changed;  ///< variables since the step before: "height = 0.1 m"
};
enum class StepAnswer { kNext, kContinue, kCancel };

/// What a run produces beside its verdict.
struct RunOptions {
  std::filesystem::path video;                                ///< MP4 file; empty = none
  double video_from = 0.0;                                    ///< s of simulated time at which the film begins
  double video_to = std::numeric_limits<double>::infinity();  ///< s at which it ends
  std::string video_failure;  ///< what is wrong with this run: its film says so from its end on, for a second more
  std::string camera;         ///< overrides the film's first camera and its cuts
  std::optional<sim::FreeCamera> view;           ///< a camera that no file has, instead
  std::optional<std::vector<std::string>> show;  ///< marks of the film, instead of the file's
  int width = 1280, height = 720, fps = 25;
  std::filesystem::path record;  ///< MCAP file; empty = none
  double record_last = 0.0;      ///< s: only so much is kept, and written if something goes wrong; 0: all
  bool measure_times = true;
  bool realtime = false;  ///< at most as fast as the wall clock; what is late is counted, and not caught up
  int processor = -1;     ///< in real time: the only one that the cycle runs on, best one that no other thread uses
                          ///< (keep_off_processor()); -1: any
  /// In lock-step: a cycle that takes longer ends the process with status 3 and the name of what is stuck (row L7); 0:
  /// nobody watches, as under a debugger. In real time the clock has its own watchdog.
  Nanoseconds watchdog = 0;
  /// Set from outside (signal handler): 1 = cancel gracefully, 2 = stop now.
  const std::atomic<int>* interrupt = nullptr;
  std::string from;            ///< name of the step at which the program is entered; empty: its beginning
  bool record_blocks = false;  ///< the recording gets the digest of each block too
  bool repeat = true;          ///< the expectation "repeats" runs the scenario a second time
  bool keep_blocks = false;    ///< the core keeps the digests of each cycle's blocks
  /// Called once, when nothing of the run has been refused and before its first cycle.
  std::function<void()> begun;
  /// Called after each cycle of core and world; false ends the run.
  std::function<bool(BuiltCell& built)> after_cycle;
  /// Called with all that happens, as it happens.
  std::function<void(const LogEntry& entry)> tell;
  /// Called before each cycle: somebody at the panel.
  std::function<void(Operator& panel)> operate;
  /// Called before each step of the program, or each activity of one in C++; the simulated time stands meanwhile, so
  /// the run is the same to the bit. Empty: the program is not held up.
  std::function<StepAnswer(const NextStep& next)> before_step;
  /// Called about ten times a second of wall time: simulated time, planned duration, current step.
  std::function<void(double sim_time, double planned, const std::string& step)> progress;
};

/// kRefused: an option of the run was wrong and nothing has moved; kError: the run broke off.
enum class Verdict { kPassed, kFailed, kRefused, kError, kInterrupted };
[[nodiscard]] std::string_view name_of(Verdict verdict);

/// Wall time of a run by part, s. What the parts do beside the run loop (drawing, encoding, writing) is CPU time.
struct Timing {
  double physics = 0, controller = 0, core = 0, program = 0, digest = 0, rendering = 0, recording = 0;
};

/// What a run in real time got of the machine. Times in ns.
struct RealtimeReport {
  bool realtime_scheduling = false, locked_memory = false;  ///< granted
  int processor = -1;                                       ///< the only one that the cycle ran on; -1: any
  struct Lateness {
    Nanoseconds p50 = 0, p99 = 0, p999 = 0, worst = 0;
  };
  Lateness wakeups;                ///< of the cycle's thread
  Lateness begins;                 ///< of its cycles: the same, and what they waited for the program
  std::int64_t cycles_unseen = 0;  ///< that began before the program had looked at the one before
  std::int64_t cycles_not_recorded = 0;
};

struct RunReport {
  Verdict verdict = Verdict::kError;
  Diagnostics diagnostics;             ///< why it is an error
  double sim_time = 0, wall_time = 0;  ///< s
  std::int64_t cycles = 0;
  std::string digest;
  std::vector<ExpectationResult> expectations;
  std::map<std::string, Eigen::Isometry3d, std::less<>> estimates;  ///< fitted poses, world
  Timing timing;
  double core_ns_per_cycle = 0;            ///< mean wall time of a core cycle
  SiteReport site;                         ///< how the devices were reached, and how late
  double core_ns_longest = 0;              ///< the longest
  std::int64_t overruns = 0;               ///< cycles that the wall clock was ahead of, in a run at its pace
  std::optional<RealtimeReport> realtime;  ///< nothing: lock-step
  std::int64_t frames = 0;
  std::vector<activity::Reaction> reactions;  ///< of a program in C++: what events did to motions
  std::vector<std::string> lines;             ///< of a program in C++: what it printed
  std::vector<LogEntry> log;                  ///< what happened
  std::int64_t log_omitted = 0;               ///< entries that are not in it, between its first and its last half
  std::vector<std::string> products;          ///< files written
};

/// Exit status of a program that ends with this verdict: 0 held, 1 did not hold, 2 refused, 3 broke off, 130
/// interrupted.
[[nodiscard]] int exit_status(Verdict verdict);
/// The report of a run as JSON: result, sim_time, wall_time, cycles, digest, expectations, timing, diagnostics.
[[nodiscard]] nlohmann::ordered_json to_json(const RunReport& report);
/// A list of objects: severity, code, file, line and column (null if not known), pointer, message, hint.
[[nodiscard]] nlohmann::ordered_json to_json(Diagnostics diagnostics);
/// A report as it goes to stdout with --json; bytes that are not UTF-8 are replaced.
[[nodiscard]] std::string to_output_text(nlohmann::ordered_json report);
/// The report for a terminal: the verdict, a line per expectation, figures.
[[nodiscard]] std::string to_text(const RunReport& report, const std::string& title);

}  // namespace takt::cell
