#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "tools/robustness/child_process.h"

namespace takt::tools {

/// How command lines are carried out side by side.
struct PoolOptions {
  int jobs = 1;  ///< processes at a time, >= 1
  /// Counts what the user asks for: 1 = no more are started, and each that runs is asked to end (SIGINT); each further
  /// one is passed on as well. Null: nobody asks.
  const std::atomic<int>* interrupt = nullptr;
  /// Called at each end, in the order of the ends. @return false: start no more, ask those that run to end
  std::function<bool(std::size_t index, const ProcessEnd& end)> ended = {};
};

/// Runs all command lines, each in a process of its own, at most `jobs` at a time, started in their order.
/// @return an end for each, in their order; of one that was not started the default. Diagnostics: one could not be
/// started; those that ran have been ended then. Realtime: setup, waits.
[[nodiscard]] Result<std::vector<ProcessEnd>> run_processes(const std::vector<std::vector<std::string>>& commands,
                                                            const PoolOptions& options);

}  // namespace takt::tools
