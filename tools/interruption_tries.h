#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cell/run/interruptions.h"
#include "tools/cli.h"

namespace takt::tools {

/// At which cycles a verified scenario is interrupted; 0: never.
struct InterruptionArguments {
  std::int64_t cancel_every = 0, pause_every = 0, abort_every = 0, fault_every = 0;

  [[nodiscard]] bool any() const { return cancel_every > 0 || pause_every > 0 || abort_every > 0 || fault_every > 0; }
};

/// Adds the options to the verb; `arguments` outlives it.
void add_interruption_options(CLI::App& verb, InterruptionArguments& arguments);

/// What came of it.
struct InterruptionTries {
  int cancels = 0, pauses = 0, aborts = 0, faults = 0;
  std::vector<std::string> failures;  ///< "cancel in cycle 1200: ..."
  std::vector<cell::Interruptions::Case> failed;
  std::vector<std::string> films;  ///< of the first failure of each kind
  Diagnostics diagnostics;         ///< why it could not be tried

  [[nodiscard]] bool held() const { return failures.empty() && !diagnostics.has_errors(); }
};
/// Runs the scenario once more and tries it: at each of these cycles the process is forked, and the child is
/// interrupted. It has to come to rest within its limits, with nothing held, and to end.
[[nodiscard]] InterruptionTries try_interruptions(const std::filesystem::path& file,
                                                  const InterruptionArguments& arguments, const Common& common);
[[nodiscard]] nlohmann::ordered_json to_json(const InterruptionTries& tries);
/// "  ok   interruptions                34 cancels, 34 aborts"
[[nodiscard]] std::string to_text(const InterruptionTries& tries);

}  // namespace takt::tools
