#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/activity/program.h"
#include "core/base/time.h"
#include "scenario/cell_builder.h"
#include "scenario/description.h"
#include "scenario/expectations.h"
#include "scenario/site_report.h"

namespace takt::scenario {

/// What a run produces beside its verdict.
struct RunOptions {
  std::filesystem::path video;  ///< MP4 file; empty = none
  std::string camera;           ///< overrides the film's first camera and its cuts
  int width = 1280, height = 720, fps = 25;
  std::filesystem::path record;  ///< MCAP file; empty = none
  bool measure_times = true;
  bool realtime = false;  ///< at most as fast as the wall clock; what is late is counted, and not caught up
  /// Set from outside (signal handler): 1 = cancel gracefully, 2 = stop now.
  const std::atomic<int>* interrupt = nullptr;
  std::string from;            ///< name of the step at which the program is entered; empty: its beginning
  bool record_blocks = false;  ///< the recording gets the digest of each block too
  bool repeat = true;          ///< the expectation "repeats" runs the scenario a second time
  bool keep_blocks = false;    ///< the core keeps the digests of each cycle's blocks
  /// Called after each cycle of core and world; false ends the run.
  std::function<bool(BuiltCell& built)> after_cycle;
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

struct RunReport {
  Verdict verdict = Verdict::kError;
  Findings findings;                   ///< why it is an error
  double sim_time = 0, wall_time = 0;  ///< s
  std::int64_t cycles = 0;
  std::string digest;
  std::vector<ExpectationResult> expectations;
  std::map<std::string, Eigen::Isometry3d, std::less<>> estimates;  ///< fitted poses, world
  Timing timing;
  double core_ns_per_cycle = 0;  ///< mean wall time of a core cycle
  SiteReport site;               ///< how the devices were reached, and how late
  double core_ns_longest = 0;    ///< the longest
  std::int64_t overruns = 0;     ///< cycles that the wall clock was ahead of, in a run at its pace
  std::int64_t frames = 0;
  std::vector<std::string> products;  ///< files written
};

/// How a scenario file is read.
struct OpenOptions {
  std::vector<Override> overrides;
  std::optional<std::uint64_t> seed;  ///< in place of the file's
  bool measure_times = false;         ///< let the core measure its phases
  Site site = {};                     ///< back ends of the devices
};

/// A scenario made ready: built, its program parsed and rehearsed, its expectations made. Runs once.
class Session {
 public:
  /// Reads a file and makes it ready. @return the session, or everything that is wrong with the scenario, errors of
  /// form and unknown names together; nothing has moved then. Realtime: setup.
  [[nodiscard]] static Result<std::unique_ptr<Session>> open(const std::filesystem::path& file,
                                                             const device::ModelLibrary& models,
                                                             const OpenOptions& options = {});
  /// The same for a description that is right in form. `models` must outlive the session.
  [[nodiscard]] static Result<std::unique_ptr<Session>> create(Description description,
                                                               const device::ModelLibrary& models,
                                                               bool measure_times = false);
  ~Session();

  [[nodiscard]] const Description& description() const { return description_; }
  [[nodiscard]] const activity::Program& program() const { return program_; }
  [[nodiscard]] const BuiltCell& built() const { return built_; }
  [[nodiscard]] const Findings& warnings() const { return warnings_; }
  /// Planned duration of the program, s: nominal values, guarded motions to their end.
  [[nodiscard]] double planned_duration() const { return planned_duration_; }

  /// The nets that the program's steps would load, as far as they can be known before a run. Realtime: setup.
  [[nodiscard]] std::vector<activity::RehearsedNet> nets() const;

  /// Runs to the end of the program (or its failure, the time limit, an interrupt) and judges.
  [[nodiscard]] RunReport run(const RunOptions& options);

 private:
  class Run;
  Session(Description description, activity::Program program, BuiltCell built)
      : description_(std::move(description)), program_(std::move(program)), built_(std::move(built)) {}

  const device::ModelLibrary* models_ = nullptr;
  Description description_;
  activity::Program program_;
  BuiltCell built_;
  std::vector<std::unique_ptr<Expectation>> expectations_;
  Findings warnings_;
  double planned_duration_ = 0.0;
  bool second_run_ = false;
};

}  // namespace takt::scenario
