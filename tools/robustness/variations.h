#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/robustness/process_pool.h"

namespace takt::tools {

/// One scenario, many seeds.
struct VariationPlan {
  std::filesystem::path program;       ///< the takt that runs them
  std::filesystem::path file;          ///< scenario
  std::vector<std::string> more = {};  ///< options of `takt run` that all of them get: "--set", "/seed=3", ...
  std::uint64_t first_seed = 1;
  int seeds = 1;  ///< >= 1
  int jobs = 1;   ///< at a time, >= 1
  int films = 5;  ///< of so many that fail the last seconds are filmed, at most
};

/// What a run found of one expectation.
struct JudgedExpectation {
  std::string name, kind, measured = {}, unit = {};
  bool passed = false, judged = true;                        ///< not judged: it counts neither as passed nor as failed
  std::optional<double> value = {}, lower = {}, upper = {};  ///< in `unit`
};

/// What `takt run --json` reports of a run.
struct RunSummary {
  std::string digest = {};
  double sim_time = 0.0, wall_time = 0.0;  ///< s
  std::vector<JudgedExpectation> expectations = {};
  std::string error = {};  ///< the first, with its pointer; empty: none
};

/// A run with one seed.
struct Variation {
  std::uint64_t seed = 0;
  std::vector<std::string> command;       ///< with which anybody gets the same run
  ProcessEnd end;                         ///< status as of `takt run`, and its report as text
  std::optional<RunSummary> report = {};  ///< nothing: it ended without one
  std::string film = {};                  ///< MP4, the last seconds; empty: not filmed

  [[nodiscard]] bool passed() const { return end.status == 0; }
  /// It was cut off, so that it says nothing: neither passed nor failed.
  [[nodiscard]] bool interrupted() const;
  /// It passed, or it ended by itself with a report that says why not.
  [[nodiscard]] bool ended_in_order() const { return report.has_value(); }
  [[nodiscard]] double sim_time() const;  ///< s; 0 without a report
  /// Why it did not pass: the first error, or the expectations that were not met. Empty of one that passed.
  [[nodiscard]] std::string message() const;
};

/// Runs them all, each in a process of its own, so that one that crashes is a result like any other. A scenario that
/// is refused (status 2) ends all. Realtime: setup, waits.
/// @param interrupt, ended  as PoolOptions; `ended` gets each variation when it is over
/// @return those that were run, by seed. Diagnostics: a process cannot be started.
[[nodiscard]] Result<std::vector<Variation>> run_variations(const VariationPlan& plan,
                                                            const std::atomic<int>* interrupt,
                                                            const std::function<void(const Variation&)>& ended);

/// Runs those that failed again, and keeps a film of the last seconds of each. A film that cannot be made is left out.
/// Realtime: setup, waits.
void film_failures(const VariationPlan& plan, const std::atomic<int>* interrupt, std::vector<Variation>& variations);

}  // namespace takt::tools
