#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cell/replay/resimulation.h"
#include "record/recording.h"

namespace takt::cell {

/// A recorded run that is run again, held against the recorded digests, and can be looked at in any cycle, back and
/// forth. Every so many cycles the run forks a snapshot, a process that waits; to be in a cycle, the snapshot before it
/// forks another one, which goes on to that cycle. So everything is as it was: nets, devices, program, simulation.
/// Thread: one; the process must have no other threads when it begins. Realtime: setup.
class TimeTravel {
 public:
  struct Options {
    std::int64_t every = 1000;  ///< cycles from one snapshot to the next; more where there would be more than kMost
  };
  static constexpr std::int64_t kMost = 64;

  /// Begins to run again; of a recording that was cut off no farther than it goes. @param run  of the recording;
  /// outlives this. @return diagnostics: a recording without cycles
  [[nodiscard]] static Result<TimeTravel> begin(const record::Recording& recording, ReopenedRun& run,
                                                const Options& options);
  TimeTravel(TimeTravel&&) noexcept;
  TimeTravel& operator=(TimeTravel&&) noexcept;
  ~TimeTravel();

  /// Cycles of the recording.
  [[nodiscard]] std::int64_t cycles() const;
  /// Cycles from one snapshot to the next.
  [[nodiscard]] std::int64_t every() const;

  /// What to tell of a cycle.
  struct Question {
    std::int64_t cycle = 0;  ///< at its end; cycles() and more: after the end of the run
    std::string ports;       ///< pattern of the ports and values that are told, '*' any characters; empty: none
    bool why = false;        ///< the cancels that fired until then
  };
  /// @return {"cycle", "time", "step", "digest_equal", "first_difference", "ended", "nets": [{"name", "ports": {...}}],
  /// "devices": [...], "simulation": {...}, "cancels": [...], "cancel_texts": [...]}; or that the process is gone.
  [[nodiscard]] Result<nlohmann::ordered_json> ask(const Question& question);

 private:
  struct Impl;
  explicit TimeTravel(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace takt::cell
