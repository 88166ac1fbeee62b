#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/cli.h"

namespace takt::tools {

/// What `takt verify FILE --seeds N` may be told.
struct SeedArguments {
  int seeds = 0;  ///< 0: each file once, with its own seed
  std::uint64_t first_seed = 1;
  int jobs = 0;                 ///< 0: as many as there are processors
  std::optional<int> at_least;  ///< so many have to pass; default: all
  int films = 5;                ///< of failures in the report, at most
  std::string report;           ///< HTML file; empty: none
  std::vector<std::string> sets;
};

/// Adds the options to the verb; `arguments` outlives it.
void add_seed_options(CLI::App& verb, SeedArguments& arguments);
/// What only counts with --seeds although there is none, and what contradicts itself.
[[nodiscard]] Diagnostics check_seed_arguments(const SeedArguments& arguments, const std::vector<std::string>& paths);
/// Runs one scenario with all seeds. @return exit status: kHeld if enough pass and whatever does not ends in order
[[nodiscard]] int verify_seeds(const std::string& file, const SeedArguments& arguments, const Common& common);

}  // namespace takt::tools
