#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cell/build/built_cell.h"
#include "cell/faults/faults.h"
#include "cell/file/description.h"
#include "cell/judge/expectations.h"
#include "cell/judge/run_report.h"
#include "core/base/time.h"
#include "core/program/tree/program.h"
#include "record/recording.h"

namespace takt::cell {

/// How a scenario file is read.
struct OpenOptions {
  std::vector<Override> overrides;
  std::optional<std::uint64_t> seed;  ///< in place of the file's
  bool measure_times = false;         ///< let the core measure its phases
  Site site = {};                     ///< back ends of the devices
  bool realtime = false;              ///< RunOptions::realtime will be set: nets have to fit into half of a period
  bool all_may_fail = false;  ///< every device gets a fault point (BuiltCell::fault_points), whatever the file's faults
  std::filesystem::path image = {};  ///< gets a picture of the first collision of the rehearsal; empty: none
};

/// A scenario made ready: built, its program parsed and rehearsed, its expectations made. Runs once.
class Session {
 public:
  /// Reads a file and makes it ready. Models that lie beside the file are found first. @return the session, or
  /// everything that is wrong with the scenario, errors of form and unknown names together; nothing has moved then.
  /// Realtime: setup.
  [[nodiscard]] static Result<std::unique_ptr<Session>> open(const std::filesystem::path& file,
                                                             const device::ModelLibrary& models,
                                                             const OpenOptions& options = {});
  /// The same for a description that is right in form. @param warnings  of its reading
  [[nodiscard]] static Result<std::unique_ptr<Session>> create(Description description,
                                                               const device::ModelLibrary& models,
                                                               bool measure_times = false, Diagnostics warnings = {});
  ~Session();

  [[nodiscard]] const Description& description() const { return description_; }
  [[nodiscard]] const program::Program& program() const { return program_; }
  [[nodiscard]] const BuiltCell& built() const { return built_; }
  [[nodiscard]] const Diagnostics& warnings() const { return warnings_; }
  /// Planned duration of the program, s: nominal values, guarded motions to their end.
  [[nodiscard]] double planned_duration() const { return planned_duration_; }

  /// The nets that the program's steps would load, as far as they can be known before a run. Realtime: setup.
  [[nodiscard]] std::vector<operations::RehearsedNet> nets() const;

  /// Runs to the end of the program (or its failure, the time limit, an interrupt) and judges.
  [[nodiscard]] RunReport run(const RunOptions& options);

  /// Runs so many cycles of the cell without its program: its devices get what they were commanded in the recording.
  /// Nothing is judged. Instead of run(); a recording that does not fit is refused.
  [[nodiscard]] RunReport run_commands(const record::Recording& recording, std::int64_t cycles,
                                       const RunOptions& options);

 private:
  class Run;
  Session(Description description, program::Program program, BuiltCell built)
      : description_(std::move(description)), program_(std::move(program)), built_(std::move(built)) {}

  device::ModelLibrary models_{std::vector<std::filesystem::path>()};
  Description description_;
  program::Program program_;
  BuiltCell built_;
  std::vector<std::unique_ptr<Expectation>> expectations_;
  std::vector<ScheduledFault> faults_;
  Diagnostics warnings_;
  double planned_duration_ = 0.0;
  std::shared_ptr<const activity::MeanwhileSpaces> meanwhile_;  ///< what the rehearsal found for its moves
  bool second_run_ = false;
};

}  // namespace takt::cell
