#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cell/run/recorded_models.h"
#include "cell/run/session.h"
#include "record/compare.h"
#include "record/recording.h"

namespace takt::cell {

/// A recorded run, made ready again: its scenario with its models, its seed and its site, drivers left out.
class ReopenedRun {
 public:
  struct Options {
    std::vector<Override> overrides = {};
    std::optional<std::uint64_t> seed = {};
    std::optional<Site> site = {};  ///< in place of the recorded one
  };
  /// @param otherwise  models of a recording that carries none
  /// @return it; or diagnostics: no scenario, models that do not fit, what is wrong with the scenario. Realtime: setup.
  [[nodiscard]] static Result<ReopenedRun> open(const record::Recording& recording,
                                                const device::ModelLibrary& otherwise, const Options& options);

  [[nodiscard]] Session& session() { return *session_; }
  /// Where its program was entered; empty: at its beginning.
  [[nodiscard]] const std::string& entry() const { return entry_; }

 private:
  std::optional<RecordedModels> models_;  ///< outlives the session
  std::unique_ptr<Session> session_;
  std::string entry_;
};

/// Cycles of a recording that has all of them from the first one on. Diagnostics: it has not. Realtime: setup.
[[nodiscard]] Result<std::int64_t> whole_cycles(const record::Recording& recording);

/// What a re-simulation is held against: the states in a recording, and not what the program and the core made of them.
[[nodiscard]] record::CompareOptions states_only();

}  // namespace takt::cell
