#pragma once

#include <filesystem>
#include <string>

#include "core/base/diagnostics.h"
#include "tools/cli.h"

namespace takt::tools {

/// What a command line may say of the films of failures.
struct FailureFilmArguments {
  std::string folder = "failures";
  bool off = false;
};

/// --failures and --no-film; `arguments` outlives the parser.
void add_failure_film_options(CLI::App& verb, FailureFilmArguments& arguments);

/// When a run failed.
struct FailureMoment {
  double time = 0.0;   ///< s of simulated time
  bool at_end = true;  ///< the run ended then
};

/// Runs a scenario again, which repeats it to the bit, and films the three seconds before the moment and one after it.
/// @return the film: in the folder, named as the scenario; diagnostics: it cannot be made. Realtime: setup.
[[nodiscard]] Result<std::filesystem::path> film_failure(const std::filesystem::path& scenario,
                                                         const FailureMoment& moment,
                                                         const FailureFilmArguments& arguments, const Common& common);

}  // namespace takt::tools
