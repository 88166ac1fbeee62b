#include "scenario/run_film.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/expression/device_sensors.h"

namespace takt::scenario {
namespace {

/// The camera of the first picture: asked for, else of the scenario's film, else its first.
std::string first_camera(const RunOptions& options, const Description& description) {
  if (!options.camera.empty()) return options.camera;
  if (!description.film.camera.empty()) return description.film.camera;
  return description.cameras.empty() ? "" : description.cameras.front().name;
}

/// The film speaks of its own options; a user knows those of the command line.
Diagnostics as_run_options(const Diagnostics& diagnostics) {
  Diagnostics renamed;
  for (Diagnostic diagnostic : diagnostics.list()) {
    if (diagnostic.pointer == "/path" || diagnostic.pointer == "/ffmpeg") diagnostic.pointer = "--video";
    if (diagnostic.pointer.starts_with("/render")) diagnostic.pointer = "--size";
    if (diagnostic.pointer == "/fps") diagnostic.pointer = "--fps";
    if (diagnostic.pointer.starts_with("/cuts")) diagnostic.pointer = "--camera";
    renamed.add(std::move(diagnostic));
  }
  return renamed;
}

}  // namespace

Result<std::unique_ptr<RunFilm>> RunFilm::open(const RunOptions& options, const Description& description,
                                               const BuiltCell& built) {
  sim::FilmOptions film;
  film.path = options.video;
  film.fps = options.fps;
  film.begin = std::llround(1e9 * options.video_from);
  film.title = description.title;
  film.render.width = options.width;
  film.render.height = options.height;
  film.cuts = {{0, first_camera(options, description)}};
  if (options.camera.empty()) film.inset_camera = description.film.inset;
  auto opened = sim::Film::open(built.world->model(), film);
  if (!opened) return std::unexpected(as_run_options(opened.error()));
  return std::unique_ptr<RunFilm>(new RunFilm(std::move(*opened), description, built, options));
}

RunFilm::RunFilm(sim::Film film, const Description& description, const BuiltCell& built, const RunOptions& options)
    : film_(std::move(film)),
      description_(description),
      built_(built),
      cuts_(options.camera.empty()),
      waits_(!options.realtime) {}

Diagnostics RunFilm::step_begins(std::string_view name) {
  const auto& cuts = description_.film.cuts;
  const auto cut = std::ranges::find(cuts, name, &FilmEntry::Cut::step);
  if (!cuts_ || cut == cuts.end()) return {};
  const auto shown = film_.set_camera(cut->camera);
  return shown ? Diagnostics{} : shown.error();
}

Diagnostics RunFilm::add_state(const std::string& step, const command::Biases& biases) {
  if (step != step_) {
    step_ = step;
    if (Diagnostics failed = step_begins(step); failed.has_errors()) return failed;
  }
  if (built_.world->time() < film_.next_time()) return {};
  sim::Overlay overlay;
  overlay.step = step;
  overlay.time = built_.world->time();
  const auto sensor = built_.cell.sensors.find(description_.film.force_sensor);
  if (sensor != built_.cell.sensors.end()) {
    const auto felt = contact_wrench(built_.cell, sensor->first, biases);  // as the conditions in the nets have it
    overlay.force_N = norm(force(felt)).now().value_or(std::numeric_limits<double>::quiet_NaN());
    overlay.force_limit_N = description_.film.force_limit_N;
  }
  // In lock-step the run waits for the film; in real time a picture that has no room yet comes later.
  while (built_.world->time() >= film_.next_time() && (waits_ || film_.has_room())) {
    if (auto pushed = film_.push(built_.world->data(), overlay); !pushed) return std::move(pushed.error());
  }
  return {};
}

}  // namespace takt::scenario
