#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "cell/build/built_cell.h"
#include "cell/file/description.h"
#include "cell/judge/run_report.h"
#include "cell/run/film_caption.h"
#include "cell/run/film_marks.h"
#include "sim/film/film.h"

namespace takt::cell {

/// The film speaks of its own options ("/render/width"); a user knows those of the command line ("--size").
[[nodiscard]] Diagnostics with_option_names(const Diagnostics& diagnostics);

/// The film of a run: pushes a picture when one is due, cuts when named steps begin, shows time, step, force, what went
/// wrong, and marks beside the scene.
class RunFilm {
 public:
  /// Diagnostics for impossible sizes, unknown cameras or marks, or a path that cannot be written. Pointers are option
  /// names.
  [[nodiscard]] static Result<std::unique_ptr<RunFilm>> open(const RunOptions& options, const Description& description,
                                                             const BuiltCell& built);

  /// Something happened: captions follow it, and where a step or another node has begun the scenario's cut to its
  /// camera, if there is one. @return diagnostics if the film cannot show that camera
  [[nodiscard]] Diagnostics happened(const LogEntry& entry);
  /// What came of the run, if it did not do what it had to: shown in what is filmed from now on.
  void failed(const std::string& text) { caption_.fail(built_.world->time(), text); }
  /// The run is over: its verdict is shown in what is filmed from now on.
  void judged(Verdict verdict, const std::vector<ExpectationResult>& expectations);
  /// What machines touched since the last call; each picture has the greatest forces since the one before, the first
  /// one those of the time of one picture.
  void touched(std::span<const sim::BodyContact> contacts) {
    if (built_.world->time() + picture_time_ >= film_.next_time()) contacts_.add(contacts);
  }
  /// After a cycle: pictures that are due show what is now. @return diagnostics if drawing or encoding failed.
  [[nodiscard]] Diagnostics add_state(const std::string& step, const expression::Biases& biases);
  /// As add_state() with what was shown last, `duration` longer: of a state that cannot go on.
  [[nodiscard]] Diagnostics hold(Nanoseconds duration);
  /// It shows nothing from here on.
  [[nodiscard]] bool is_over() const { return built_.world->time() > end_; }
  [[nodiscard]] Result<sim::FilmReport> close() { return film_.close(); }

 private:
  RunFilm(sim::Film film, std::unique_ptr<FilmMarks> marks, const Description& description, const BuiltCell& built,
          const RunOptions& options);
  [[nodiscard]] Diagnostics cut_to(std::string_view path);
  void show_force(const expression::Biases& biases, sim::Overlay& overlay) const;
  [[nodiscard]] sim::Marks marks_now();
  [[nodiscard]] Diagnostics push_due(const sim::Overlay& overlay, Nanoseconds now);

  sim::Film film_;
  std::unique_ptr<FilmMarks> marks_;
  const Description& description_;
  const BuiltCell& built_;
  bool cuts_;   ///< of the scenario
  bool waits_;  ///< the run, while the film has no room
  Nanoseconds end_;
  Nanoseconds picture_time_;
  bool follows_log_ = false;  ///< which tells what begins; else a program in C++ does, by the name of its step
  std::string step_;
  FilmCaption caption_;
  CommandedPositions commanded_;
  ContactForces contacts_;  ///< since the last picture
  sim::Overlay shown_;
};

}  // namespace takt::cell
