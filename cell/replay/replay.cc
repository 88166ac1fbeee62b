#include "cell/replay/replay.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "cell/build/cell_builder.h"
#include "cell/build/topics.h"
#include "cell/judge/step_window.h"
#include "cell/replay/recorded_run.h"
#include "cell/run/film_caption.h"
#include "cell/run/film_marks.h"
#include "cell/run/recorded_models.h"
#include "cell/run/run_film.h"
#include "cell/run/run_recorder.h"
#include "record/recording.h"
#include "sim/film/film.h"

namespace takt::cell {
namespace {

std::unexpected<Diagnostics> unusable(const std::filesystem::path& file, std::string message, std::string hint = {}) {
  Diagnostics diagnostics;
  diagnostics.add({Severity::kError, Code::kFileNotReadable, file.string(), {}, std::move(message), std::move(hint)});
  return std::unexpected(std::move(diagnostics));
}

/// The recorded signals of these names; empty columns for what is not there.
std::vector<std::vector<double>> signal_columns(const record::Recording& recording,
                                                const std::vector<std::string>& names, Nanoseconds period) {
  std::vector<std::vector<double>> columns(names.size());
  if (columns.empty()) return columns;
  const auto signals = recording.table_every("/signals", period);
  for (std::size_t i = 0; signals && i < columns.size(); ++i) {
    const auto found = std::ranges::find(signals->columns, names[i]);
    if (found != signals->columns.end())
      columns[i] = signals->values[static_cast<std::size_t>(found - signals->columns.begin())];
  }
  return columns;
}

/// What the captions tell, in the order of time: what the program did, and contacts that were faults.
std::vector<LogEntry> told_events(const record::Recording& recording) {
  std::vector<LogEntry> entries;
  for (const std::string_view topic : {record::kProgramTopic, record::kContactTopic}) {
    const auto events = recording.events(topic);
    for (std::size_t i = 0; events && i < events->size(); ++i) {
      const record::RecordedEvent& event = (*events)[i];
      entries.push_back({.time = event.time,
                         .cycle = event.cycle,
                         .level = level_of(event.source, event.name),
                         .source = event.source,
                         .name = event.name,
                         .step = event.step,
                         .text = event.text});
    }
  }
  std::ranges::stable_sort(entries, {}, &LogEntry::time);
  return entries;
}

/// How a run ended, as its recording tells.
struct Ending {
  Verdict verdict = Verdict::kPassed;
  std::size_t held = 0, expectations = 0;
  std::string not_held = {};  ///< the first expectation that did not hold, and what was measured
};

/// Nothing if the recording does not tell: it was cut off, or holds no run of a program.
std::optional<Ending> ending_of(const record::Recording& recording) {
  if (recording.truncated_at()) return std::nullopt;
  Ending ending;
  bool over = false, error = false, interrupted = false;
  recording.for_each_event(record::kExpectationTopic, [&](const record::RecordedEvent& event) {
    ++ending.expectations;
    if (event.name == "held") ++ending.held;
    if (event.name == "not held" && ending.not_held.empty()) ending.not_held = "not held: " + event.text;
    return over = true;
  });
  recording.for_each_event(record::kProgramTopic, [&](const record::RecordedEvent& event) {
    error = error || (event.source == "run" && event.name == "error");
    interrupted = interrupted || (event.source == "run" && event.name == "interrupted");
    return over = true;
  });
  if (!over) return std::nullopt;
  ending.verdict = interrupted                         ? Verdict::kInterrupted
                   : error                             ? Verdict::kError
                   : ending.held < ending.expectations ? Verdict::kFailed
                                                       : Verdict::kPassed;
  return ending;
}

/// The row of a table that counts at a time; times are asked for in their order.
class RowCursor {
 public:
  explicit RowCursor(Result<record::Table> table) : table_(std::move(table)) {}

  /// The newest row at or before `time`; empty: there is none yet.
  [[nodiscard]] std::vector<double> at(Nanoseconds time,
                                       std::size_t most_columns = std::numeric_limits<std::size_t>::max()) {
    if (!table_ || table_->time.empty() || table_->time.front() > time) return {};
    while (row_ + 1 < table_->time.size() && table_->time[row_ + 1] <= time) ++row_;
    std::vector<double> values;
    for (std::size_t i = 0; i < std::min(most_columns, table_->values.size()); ++i)
      values.push_back(table_->values[i][row_]);
    return values;
  }

 private:
  Result<record::Table> table_;
  std::size_t row_ = 0;
};

/// What marks need of a recording beside the positions.
class RecordedMarks {
 public:
  RecordedMarks(const record::Recording& recording, const BuiltCell& built, const FilmShow& show, Nanoseconds period)
      : positions_(built), show_(show), contacts_(recording.table_every(record::kContactForceTopic, period)) {
    for (const CommandedPositions::Machine& machine : positions_.machines())
      if (show.commanded)
        set_points_.emplace_back(recording.table_every(device_topic(machine.name) + "/set_point", period));
  }

  [[nodiscard]] std::vector<double> commanded(Nanoseconds time, const std::vector<double>& qpos) {
    if (!show_.commanded) return {};
    std::vector<double> commanded = qpos;
    for (std::size_t i = 0; i < set_points_.size(); ++i) {
      const CommandedPositions::Machine& machine = positions_.machines()[i];
      CommandedPositions::put(machine, set_points_[i].at(time, machine.joints.size()), commanded);
    }
    return commanded;
  }

  [[nodiscard]] std::vector<ContactForce> contacts(Nanoseconds time) {
    const std::vector<double> row = contacts_.at(time);
    std::vector<ContactForce> forces;
    for (std::size_t i = 0; i + 6 <= row.size() && std::isfinite(row[i]); i += 6)
      forces.push_back({Eigen::Vector3d(row.data() + i), Eigen::Vector3d(row.data() + i + 3)});
    return forces;
  }

 private:
  CommandedPositions positions_;
  const FilmShow& show_;
  std::vector<RowCursor> set_points_;
  RowCursor contacts_;
};

/// The scenario's cuts at the times at which their steps began; with a camera asked for, that one throughout.
std::vector<sim::CameraCut> cuts_of(const Description& description, const std::vector<LogEntry>& events,
                                    const ReplayOptions& options) {
  if (options.view) return {{0, ""}};
  if (!options.camera.empty()) return {{0, options.camera}};
  std::string first = description.film.camera;
  if (first.empty() && !description.cameras.empty()) first = description.cameras.front().name;
  std::vector<sim::CameraCut> cuts{{0, first}};
  for (const LogEntry& event : events) {
    if (event.source != "program" || event.name != "begin") continue;
    const auto cut = std::ranges::find_if(description.film.cuts,
                                          [&](const FilmEntry::Cut& one) { return ends_with(event.step, one.step); });
    if (cut != description.film.cuts.end()) cuts.push_back({event.time, cut->camera});
  }
  return cuts;
}

/// Why these states make no film; empty: they do. A film is as long as its recording, so that two states far from each
/// other would be a film of years.
std::string check_times(const record::Recording& recording, const record::Table& table) {
  constexpr Nanoseconds kMostPerState = 100 * kMillisecond;  // of a film, on average; a run records one per cycle
  constexpr Nanoseconds kLongest = 4 * 3600 * kSecond;
  if (table.time.empty()) return "there is no state in this recording";
  const auto states = static_cast<Nanoseconds>(recording.rows(table.topic));
  const Nanoseconds length = table.time.back() - table.time.front();
  if (length <= std::min(kLongest, kMostPerState * states)) return {};
  return fmt::format("{} states over {:.6g} s", states, to_seconds(length));
}

/// The film of the states between two times, frame by frame: no more than a state is held twice.
class ReplayFilm {
 public:
  ReplayFilm(const record::Recording& recording, const record::Table& states, const BuiltCell& built,
             const Description& description, const FilmShow& show, const ReplayOptions& options)
      : states_(states),
        description_(description),
        options_(options),
        show_(show),
        marks_(built, show_),
        recorded_(recording, built, show_, kSecond / options.fps),
        lamps_(signal_columns(recording, built.world->lamps(), kSecond / options.fps)),
        torches_(signal_columns(recording, marks_.torch_signals(), kSecond / options.fps)),
        force_(recording.table_every(device_topic(description.film.force_sensor) + "/contact_wrench",
                                     kSecond / options.fps)),
        ending_(ending_of(recording)),
        events_(told_events(recording)) {}

  [[nodiscard]] Result<sim::FilmReport> make(const BuiltCell& built) {
    while (first_ < states_.time.size() && to_seconds(states_.time[first_]) < options_.from) ++first_;
    if (first_ == states_.time.size() || to_seconds(states_.time[first_]) > options_.to)
      return failure(
          Code::kOutOfRange, "--from", fmt::format("no state from {:g} to {:g} s", options_.from, options_.to),
          fmt::format("Choose times within the recording, which ends at {:g} s", to_seconds(states_.time.back())));
    auto film = sim::Film::open(built.world->model(), film_options());
    if (!film) return std::unexpected(with_option_names(film.error()));
    for (std::size_t row = 0; row < states_.time.size() && to_seconds(states_.time[row]) <= options_.to; ++row)
      if (!show(row, *film)) break;  // close() tells why
    hold_verdict(*film);
    auto closed = film->close();
    return closed ? closed : std::unexpected(with_option_names(closed.error()));
  }

 private:
  [[nodiscard]] sim::FilmOptions film_options() {
    sim::FilmOptions film;
    film.path = options_.video;
    film.fps = options_.fps;
    film.begin = states_.time[first_];
    film.title = description_.title;
    film.render.width = options_.width;
    film.render.height = options_.height;
    film.workers = options_.jobs;
    film.queue_frames = std::max(film.queue_frames, 2 * options_.jobs);
    film.cuts = cuts_of(description_, events_, options_);
    if (options_.camera.empty() && !options_.view) film.inset_camera = description_.film.inset;
    const double aspect = static_cast<double>(options_.width) / std::max(1, options_.height);
    film.free_camera = options_.view ? *options_.view : marks_.fitting_camera(row_of(states_, 0), aspect);
    return film;
  }

  static std::vector<double> row_of(const record::Table& table, std::size_t row) {
    std::vector<double> values;
    for (const auto& column : table.values) values.push_back(column[row]);
    return values;
  }

  /// The frames from this state on, until the next one; before the first frame marks look on.
  bool show(std::size_t row, sim::Film& film) {
    const Nanoseconds time = states_.time[row];
    for (; event_ < events_.size() && events_[event_].time <= time; ++event_) caption_.happened(events_[event_]);
    const bool is_last = row + 1 == states_.time.size();
    const Nanoseconds until = is_last ? time + 1 : states_.time[row + 1];
    const bool looks_back = time + static_cast<Nanoseconds>(1e9 * std::min(show_.trace_s, 1e6)) >= states_.time[first_];
    if (row < first_ && !looks_back && torches_.empty()) return true;  // a seam stays
    qpos_ = row_of(states_, row);
    const auto contacts = recorded_.contacts(time);
    const auto now = [row](const std::vector<std::vector<double>>& columns) {
      std::vector<double> values;
      for (const auto& column : columns) values.push_back(row < column.size() ? column[row] : 0.0);
      return values;
    };
    marked_ = marks_.at({time, qpos_, recorded_.commanded(time, qpos_), contacts, now(torches_)});
    lit_ = now(lamps_);
    while (row >= first_ && film.next_time() < until)
      if (!push(film)) return false;
    return true;
  }

  bool push(sim::Film& film) {
    sim::Overlay overlay;
    caption_.write(film.next_time(), {}, overlay);
    show_force(film.next_time(), overlay);
    return film.push(qpos_, lit_, overlay, marked_).has_value();
  }

  /// As the film of the run: a second more, with the verdict.
  void hold_verdict(sim::Film& film) {
    if (!ending_ || to_seconds(states_.time.back()) > options_.to) return;
    for (; event_ < events_.size(); ++event_) caption_.happened(events_[event_]);
    caption_.judge(ending_->verdict, ending_->held, ending_->expectations);
    if (!ending_->not_held.empty()) caption_.fail(film.next_time(), ending_->not_held);
    for (int i = 0; i < options_.fps; ++i)
      if (!push(film)) return;
  }

  /// The force at the time of the picture, where the film of the scenario shows one and it was recorded.
  void show_force(Nanoseconds time, sim::Overlay& overlay) {
    const std::vector<double> force = force_.at(time, 3);
    if (force.size() < 3) return;
    overlay.force_N = Eigen::Map<const Eigen::Vector3d>(force.data()).norm();
    overlay.force_label = description_.film.force_sensor;
    overlay.force_limit_N = description_.film.force_limit_N;
  }

  const record::Table& states_;
  const Description& description_;
  const ReplayOptions& options_;
  FilmShow show_;
  FilmMarks marks_;
  RecordedMarks recorded_;
  std::vector<std::vector<double>> lamps_, torches_;
  RowCursor force_;
  std::optional<Ending> ending_;
  std::vector<LogEntry> events_;
  FilmCaption caption_;
  std::size_t event_ = 0, first_ = 0;
  std::vector<double> qpos_, lit_;
  sim::Marks marked_;
};

/// Options that have nothing to do with the recording.
Diagnostics check_options(const ReplayOptions& options) {
  Diagnostics diagnostics;
  if (options.fps < 1 || options.fps > sim::kMostFps)
    diagnostics.error(Code::kOutOfRange, "--fps", fmt::format("{} pictures per second", options.fps),
                      fmt::format("Choose 1 to {}", sim::kMostFps));
  if (options.to < options.from)
    diagnostics.error(Code::kOutOfRange, "--to", fmt::format("{:g} s is before {:g} s", options.to, options.from),
                      "Give a time after --from");
  FilmShow show;
  if (options.show) choose_marks(*options.show, "--show", show, diagnostics);
  return diagnostics;
}

}  // namespace

Result<std::int64_t> render_recording(const std::filesystem::path& recording, const device::ModelLibrary& models,
                                      const ReplayOptions& options) {
  if (Diagnostics diagnostics = check_options(options); diagnostics.has_errors())
    return std::unexpected(std::move(diagnostics));
  auto opened = record::Recording::open(recording);
  if (!opened) return std::unexpected(std::move(opened.error()));
  auto description = recorded_scenario(*opened);
  if (!description) {
    description.error().set_file(recording.string());
    return std::unexpected(std::move(description.error()));
  }
  const auto recorded = RecordedModels::unpack(*opened);
  if (!recorded) return std::unexpected(recorded.error());
  Diagnostics warnings;
  auto built = build_cell(*description, *recorded ? (*recorded)->library() : models, false, warnings);
  if (!built) return std::unexpected(std::move(built.error()));
  // No more than a state a picture is held, however long the recording is.
  const Nanoseconds period = kSecond / options.fps;
  const auto table = opened->table_every("/state", period);
  if (!table) return std::unexpected(table.error());
  if (static_cast<int>(table->values.size()) != built->world->model()->nq) {
    return unusable(
        recording,
        fmt::format("states of {} positions for a model of {}", table->values.size(), built->world->model()->nq),
        "the models that it was recorded with");
  }
  if (auto wrong = check_times(*opened, *table); !wrong.empty()) return unusable(recording, std::move(wrong));
  FilmShow show = description->film.show;
  Diagnostics checked;
  if (options.show) choose_marks(*options.show, "--show", show, checked);
  const auto report = ReplayFilm(*opened, *table, *built, *description, show, options).make(*built);
  if (!report) return std::unexpected(report.error());
  return report->frames;
}

}  // namespace takt::cell
