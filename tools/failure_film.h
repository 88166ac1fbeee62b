#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cell/run/interruptions.h"
#include "core/base/diagnostics.h"
#include "tools/cli.h"

namespace takt::tools {

/// What a command line may say of the films of failures.
struct FailureFilmArguments {
  std::string folder = {};  ///< empty: that of the user's other files of no importance
  bool off = false;
};

/// --failures and --no-film; `arguments` outlives the parser.
void add_failure_film_options(CLI::App& verb, FailureFilmArguments& arguments);

/// When a run failed.
struct FailureMoment {
  double time = 0.0;   ///< s of simulated time
  bool at_end = true;  ///< the run ended then
  /// It failed because it was interrupted; `time` does not count.
  std::optional<cell::Interruptions::Case> interruption = {};
};

/// Runs a scenario again, which repeats it to the bit, and films the three seconds before the moment and one after it;
/// of an interruption the three seconds before it and what comes of it.
/// @return the film: in the folder, named as the scenario, and after the interruption ("touch_cancel_1200.mp4");
/// diagnostics: it cannot be made. Realtime: setup.
[[nodiscard]] Result<std::filesystem::path> film_failure(const std::filesystem::path& scenario,
                                                         const FailureMoment& moment,
                                                         const FailureFilmArguments& arguments, const Common& common);

}  // namespace takt::tools
