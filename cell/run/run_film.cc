#include "cell/run/run_film.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cell/judge/step_window.h"
#include "core/expression/device_sensors.h"

namespace takt::cell {
namespace {

/// The camera of the first picture: asked for, else of the scenario's film, else its first.
std::string first_camera(const RunOptions& options, const Description& description) {
  if (options.view) return "";
  if (!options.camera.empty()) return options.camera;
  if (!description.film.camera.empty()) return description.film.camera;
  return description.cameras.empty() ? "" : description.cameras.front().name;
}

bool own_cuts(const RunOptions& options) { return options.camera.empty() && !options.view; }

std::span<const double> positions(const BuiltCell& built) { return built.world->positions(); }

Nanoseconds to_time(double seconds) {
  return seconds < 1e9 ? static_cast<Nanoseconds>(std::llround(1e9 * seconds))
                       : std::numeric_limits<Nanoseconds>::max();
}

}  // namespace

Diagnostics with_option_names(const Diagnostics& diagnostics) {
  Diagnostics renamed;
  for (Diagnostic diagnostic : diagnostics.list()) {
    if (diagnostic.pointer == "/path" || diagnostic.pointer == "/ffmpeg") diagnostic.pointer = "--video";
    if (diagnostic.pointer.starts_with("/render")) diagnostic.pointer = "--size";
    if (diagnostic.pointer == "/fps") diagnostic.pointer = "--fps";
    if (diagnostic.pointer.starts_with("/cuts")) diagnostic.pointer = "--camera";
    if (diagnostic.pointer.starts_with("/workers")) diagnostic.pointer = "--jobs";
    renamed.add(std::move(diagnostic));
  }
  return renamed;
}

Result<std::unique_ptr<RunFilm>> RunFilm::open(const RunOptions& options, const Description& description,
                                               const BuiltCell& built) {
  FilmShow show = description.film.show;
  Diagnostics diagnostics;
  if (options.show) choose_marks(*options.show, "--show", show, diagnostics);
  auto marks = std::make_unique<FilmMarks>(built, show);
  sim::FilmOptions film;
  film.path = options.video;
  film.fps = options.fps;
  film.begin = to_time(options.video_from);
  film.title = description.title;
  film.render.width = options.width;
  film.render.height = options.height;
  const double aspect = static_cast<double>(options.width) / std::max(1, options.height);
  film.free_camera = options.view ? *options.view : marks->fitting_camera(positions(built), aspect);
  film.cuts = {{0, first_camera(options, description)}};
  if (own_cuts(options)) film.inset_camera = description.film.inset;
  diagnostics.append(sim::check_film(built.world->model(), film));
  if (diagnostics.has_errors()) return std::unexpected(with_option_names(diagnostics));
  auto opened = sim::Film::open(built.world->model(), film);
  if (!opened) return std::unexpected(with_option_names(opened.error()));
  return std::unique_ptr<RunFilm>(new RunFilm(std::move(*opened), std::move(marks), description, built, options));
}

RunFilm::RunFilm(sim::Film film, std::unique_ptr<FilmMarks> marks, const Description& description,
                 const BuiltCell& built, const RunOptions& options)
    : film_(std::move(film)),
      marks_(std::move(marks)),
      description_(description),
      built_(built),
      cuts_(own_cuts(options)),
      waits_(!options.realtime),
      end_(to_time(options.video_to)),
      picture_time_(kSecond / options.fps),
      commanded_(built),
      contacts_(built) {}

Diagnostics RunFilm::happened(const LogEntry& entry) {
  caption_.happened(entry);
  if (entry.source != "program" || entry.name != "begin") return {};
  follows_log_ = true;
  return cut_to(entry.step);
}

/// @param path  of the node that has begun
Diagnostics RunFilm::cut_to(std::string_view path) {
  const auto& cuts = description_.film.cuts;
  const auto cut = std::ranges::find_if(cuts, [&](const FilmEntry::Cut& one) { return ends_with(path, one.step); });
  if (!cuts_ || cut == cuts.end()) return {};
  const auto shown = film_.set_camera(cut->camera);
  return shown ? Diagnostics{} : with_option_names(shown.error());
}

Diagnostics RunFilm::add_state(const std::string& step, const expression::Biases& biases) {
  if (step != step_) {
    step_ = step;
    if (Diagnostics failed = follows_log_ ? Diagnostics{} : cut_to(step); failed.has_errors()) return failed;
  }
  const Nanoseconds now = built_.world->time();
  if (now < film_.next_time() || now > end_) return {};
  sim::Overlay overlay;
  caption_.write(now, step, overlay);
  show_force(biases, overlay);
  return push_due(overlay, now);
}

void RunFilm::judged(Verdict verdict, const std::vector<ExpectationResult>& expectations) {
  const auto held = std::ranges::count_if(expectations, &ExpectationResult::passed);
  caption_.judge(verdict, static_cast<std::size_t>(held), expectations.size());
}

Diagnostics RunFilm::hold(Nanoseconds duration) {
  const Nanoseconds now = built_.world->time();
  if (now + duration > end_) return {};
  caption_.write(now, step_, shown_);
  return push_due(shown_, now + duration);
}

void RunFilm::show_force(const expression::Biases& biases, sim::Overlay& overlay) const {
  const auto sensor = built_.cell.sensors.find(description_.film.force_sensor);
  if (sensor == built_.cell.sensors.end()) return;
  const auto felt = contact_wrench(built_.cell, sensor->first, biases);  // as the conditions in the nets have it
  overlay.force_N = norm(force(felt)).now().value_or(std::numeric_limits<double>::quiet_NaN());
  overlay.force_label = description_.film.force_sensor;
  overlay.force_limit_N = description_.film.force_limit_N;
}

sim::Marks RunFilm::marks_now() {
  const auto qpos = positions(built_);
  const auto forces = contacts_.take();
  std::vector<double> torches;
  for (const std::string& signal : marks_->torch_signals()) {
    const auto& input = *built_.cell.digital_inputs.at(signal);
    torches.push_back(input.has_sample() && input.sample().value ? 1.0 : 0.0);
  }
  return marks_->at({built_.world->time(), qpos, commanded_.now(qpos), forces, torches});
}

/// In lock-step the run waits for the film; in real time a picture that has no room yet comes later.
Diagnostics RunFilm::push_due(const sim::Overlay& overlay, Nanoseconds now) {
  if (now < film_.next_time() || !(waits_ || film_.has_room())) return {};
  shown_ = overlay;
  const sim::Marks marks = marks_now();
  while (now >= film_.next_time() && (waits_ || film_.has_room())) {
    if (auto pushed = film_.push(built_.world->data(), overlay, marks); !pushed)
      return with_option_names(pushed.error());
  }
  return {};
}

}  // namespace takt::cell
