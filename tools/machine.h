#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/rcc/lateness_times.h"

namespace takt::tools {

/// One thing that matters for a cycle in real time.
struct MachineFinding {
  std::string name;  ///< "kernel"
  bool good = false;
  std::string found;   ///< "6.1.0-rt7 with PREEMPT_RT"
  std::string change;  ///< what to do about it; empty if good
};

/// What the files of a Linux system and its limits for this process say. Nothing is changed for good: scheduling and
/// locked memory are tried, on a thread of their own, and given back.
/// @param root  of the file system; another one in tests. Realtime: setup.
[[nodiscard]] std::vector<MachineFinding> look_at_machine(const std::filesystem::path& root = "/");

/// What a cycle of 1 ms got.
struct MeasuredCycles {
  bool realtime_scheduling = false, locked_memory = false;
  rcc::LatenessTimes wakeups;
};
/// Runs an empty core for so many seconds of wall time, with real-time scheduling and locked memory where permitted.
/// @param processor  the only one that its thread runs on; -1: any
[[nodiscard]] MeasuredCycles measure_cycles(double seconds, int processor = -1);

}  // namespace takt::tools
