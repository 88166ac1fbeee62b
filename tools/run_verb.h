#pragma once

#include <nlohmann/json_fwd.hpp>

#include "scenario/session.h"
#include "tools/cli.h"

namespace takt::tools {

/// The report of a run as JSON: result, sim_time, wall_time, cycles, digest, expectations, timing, findings.
[[nodiscard]] nlohmann::ordered_json to_json(const scenario::RunReport& report);
/// The report for a terminal: the verdict, a line per expectation, figures.
[[nodiscard]] std::string to_text(const scenario::RunReport& report, const std::string& title);
[[nodiscard]] int exit_status(scenario::Verdict verdict);

/// Makes SIGINT count instead of ending the process; the number of signals so far.
[[nodiscard]] const std::atomic<int>& catch_interrupts();

}  // namespace takt::tools
