#include "scenario/replay.h"

#include <algorithm>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "record/recording.h"
#include "scenario/cell_builder.h"
#include "scenario/recorded_models.h"
#include "scenario/recorded_run.h"
#include "sim/film.h"

namespace takt::scenario {
namespace {

std::unexpected<Diagnostics> unusable(const std::filesystem::path& file, std::string message, std::string hint = {}) {
  Diagnostics diagnostics;
  diagnostics.add({Severity::kError, Code::kFileNotReadable, file.string(), {}, std::move(message), std::move(hint)});
  return std::unexpected(std::move(diagnostics));
}

/// The recorded signals that light something, in the order of the world's lamps; empty columns for what is not there.
std::vector<std::vector<double>> lamp_columns(const record::Recording& recording, const sim::World& world,
                                              Nanoseconds period) {
  std::vector<std::vector<double>> columns(world.lamps().size());
  if (columns.empty()) return columns;
  const auto signals = recording.table_every("/signals", period);
  for (std::size_t i = 0; signals && i < columns.size(); ++i) {
    const auto found = std::ranges::find(signals->columns, world.lamps()[i]);
    if (found != signals->columns.end())
      columns[i] = signals->values[static_cast<std::size_t>(found - signals->columns.begin())];
  }
  return columns;
}

/// The recorded positions; the overlay shows time and step.
std::vector<sim::FilmState> states_for_film(const record::Table& table, const std::vector<std::vector<double>>& lamps,
                                            const std::vector<record::RecordedEvent>& events) {
  std::vector<sim::FilmState> states;
  std::size_t event = 0;
  std::string step;
  for (std::size_t row = 0; row < table.time.size(); ++row) {
    for (; event < events.size() && events[event].time <= table.time[row]; ++event) {
      if (events[event].name == "begin") step = events[event].text;
    }
    sim::FilmState state;
    state.time = state.overlay.time = table.time[row];
    state.overlay.step = step;
    for (const auto& column : table.values) state.qpos.push_back(column[row]);
    for (const auto& lamp : lamps) state.lamps.push_back(row < lamp.size() ? lamp[row] : 0.0);
    states.push_back(std::move(state));
  }
  return states;
}

/// The scenario's cuts at the times at which their steps began; with a camera asked for, that one throughout.
std::vector<sim::CameraCut> cuts_of(const Description& description, const std::vector<record::RecordedEvent>& events,
                                    const std::string& camera) {
  if (!camera.empty()) return {{0, camera}};
  std::string first = description.film.camera;
  if (first.empty() && !description.cameras.empty()) first = description.cameras.front().name;
  std::vector<sim::CameraCut> cuts{{0, first}};
  for (const record::RecordedEvent& event : events) {
    if (event.name != "begin") continue;
    for (const FilmEntry::Cut& cut : description.film.cuts) {
      if (cut.step == event.text) cuts.push_back({event.time, cut.camera});
    }
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

}  // namespace

Result<std::int64_t> render_recording(const std::filesystem::path& recording, const device::ModelLibrary& models,
                                      const ReplayOptions& options) {
  if (options.fps < 1 || options.fps > sim::kMostFps)
    return failure(Code::kOutOfRange, "--fps", fmt::format("{} pictures per second", options.fps),
                   fmt::format("1 to {}", sim::kMostFps));
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
  sim::FilmOptions film;
  film.path = options.video;
  film.fps = options.fps;
  film.title = description->title;
  film.render.width = options.width;
  film.render.height = options.height;
  const auto events = opened->events("/program").value_or(std::vector<record::RecordedEvent>{});
  film.cuts = cuts_of(*description, events, options.camera);
  if (options.camera.empty()) film.inset_camera = description->film.inset;
  const auto states = states_for_film(*table, lamp_columns(*opened, *built->world, period), events);
  const auto report = sim::film_from_states(built->world->model(), states, film);
  if (!report) return std::unexpected(report.error());
  return report->frames;
}

}  // namespace takt::scenario
