#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "scenario/cell_builder.h"
#include "scenario/description.h"
#include "scenario/run_report.h"
#include "sim/film.h"

namespace takt::scenario {

/// The film of a run: pushes a picture when one is due, cuts when named steps begin, shows time, step and force.
class RunFilm {
 public:
  /// Diagnostics for impossible sizes, unknown cameras or a path that cannot be written. Pointers are option names.
  [[nodiscard]] static Result<std::unique_ptr<RunFilm>> open(const RunOptions& options, const Description& description,
                                                             const BuiltCell& built);

  /// A named step has begun, also one of several at a time: the scenario's cut to its camera, if there is one.
  [[nodiscard]] Diagnostics step_begins(std::string_view name);
  /// After a cycle: pictures that are due show what is now. @return diagnostics if drawing or encoding failed.
  [[nodiscard]] Diagnostics add_state(const std::string& step, const command::Biases& biases);
  [[nodiscard]] Result<sim::FilmReport> close() { return film_.close(); }

 private:
  RunFilm(sim::Film film, const Description& description, const BuiltCell& built, const RunOptions& options);

  sim::Film film_;
  const Description& description_;
  const BuiltCell& built_;
  bool cuts_;   ///< of the scenario
  bool waits_;  ///< the run, while the film has no room
  std::string step_;
};

}  // namespace takt::scenario
