#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cell/build/built_cell.h"
#include "cell/judge/contact_log.h"
#include "cell/judge/expectation_result.h"
#include "cell/judge/run_log.h"
#include "core/activity/context.h"

namespace takt::cell {

/// What expectations may look at when a run has ended.
struct Outcome {
  const BuiltCell& built;
  const activity::Variables& variables;
  const std::vector<std::string>& steps_begun;
  double sim_time = 0.0;  ///< s
  std::string digest;
  std::function<std::string()> run_again;  ///< digest of a second run of the same scenario; may be empty
  const ContactLog::Summaries& contacts;   ///< who touched whom
  std::size_t standing = 0;                ///< pairs that stand on each other since the start
};

/// One statement about a run: watches while it runs, judges when it has ended. Only expectations may look at the truth
/// of the simulation (row D6).
class Expectation {
 public:
  virtual ~Expectation() = default;
  /// Once, before the first cycle. @param variables  what the program knows; they outlive the run
  virtual void begin(const activity::Variables& variables) { (void)variables; }
  /// After every cycle. Realtime: cyclic.
  virtual void watch(const BuiltCell& built) { (void)built; }
  /// Before the cycle in which a step begins.
  virtual void step_begins(std::string_view name) { (void)name; }
  /// Steps have begun or ended. @param paths  of those that run now: "sort / for_each (2) / grip"
  virtual void steps_run(std::span<const std::string> paths) { (void)paths; }
  /// Something has happened.
  virtual void happened(const LogEntry& entry) { (void)entry; }
  [[nodiscard]] virtual ExpectationResult judge(const Outcome& outcome) const = 0;
};

}  // namespace takt::cell
