#pragma once

#include <memory>
#include <string>

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

  /// After each cycle. @return diagnostics if drawing or encoding failed.
  [[nodiscard]] Diagnostics add_cycle(const std::string& step, const command::Biases& biases);
  [[nodiscard]] Result<sim::FilmReport> close() { return film_.close(); }

 private:
  RunFilm(sim::Film film, const Description& description, const BuiltCell& built, bool cuts);

  sim::Film film_;
  const Description& description_;
  const BuiltCell& built_;
  bool cuts_;
  std::string step_;
};

}  // namespace takt::scenario
