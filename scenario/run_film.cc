#include "scenario/run_film.h"

#include <algorithm>

#include "core/kinematics/chain.h"

namespace takt::scenario {
namespace {

/// The camera of the first picture: asked for, else of the scenario's film, else its first.
std::string first_camera(const RunOptions& options, const Description& description) {
  if (!options.camera.empty()) return options.camera;
  if (!description.film.camera.empty()) return description.film.camera;
  return description.cameras.empty() ? "" : description.cameras.front().name;
}

/// Force on the tool without its weight and bias, N: what the conditions in the nets compare.
double contact_force(const command::MountedSensor& sensor, const BuiltCell& built, const command::Biases& biases) {
  const auto& arm = built.cell.arms.find(sensor.arm)->second;
  const Eigen::Isometry3d X_WB = built.cell.frames.pose(sensor.arm).value_or(Eigen::Isometry3d::Identity());
  const Eigen::Matrix3d R_WS =
      X_WB.linear() * arm.device->description().chain->forward(arm.device->sample().q).linear() * sensor.X_FS.linear();
  Eigen::Vector3d force = sensor.device->sample().wrench.force;
  force -= sensor.tool_mass * (R_WS.transpose() * built.cell.gravity_W);
  const auto bias = biases.find(sensor.device->name());
  if (bias != biases.end()) force -= bias->second.force;
  return force.norm();
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
  film.title = description.title;
  film.render.width = options.width;
  film.render.height = options.height;
  film.cuts = {{0, first_camera(options, description)}};
  if (options.camera.empty()) film.inset_camera = description.film.inset;
  auto opened = sim::Film::open(built.world->model(), film);
  if (!opened) return std::unexpected(as_run_options(opened.error()));
  return std::unique_ptr<RunFilm>(new RunFilm(std::move(*opened), description, built, options.camera.empty()));
}

RunFilm::RunFilm(sim::Film film, const Description& description, const BuiltCell& built, bool cuts)
    : film_(std::move(film)), description_(description), built_(built), cuts_(cuts) {}

Diagnostics RunFilm::add_cycle(const std::string& step, const command::Biases& biases) {
  if (step != step_) {
    step_ = step;
    const auto& cuts = description_.film.cuts;
    const auto cut = std::ranges::find(cuts, step, &FilmEntry::Cut::step);
    if (cuts_ && cut != cuts.end()) {
      if (auto shown = film_.set_camera(cut->camera); !shown) return std::move(shown.error());
    }
  }
  if (built_.world->time() < film_.next_time()) return {};
  sim::Overlay overlay;
  overlay.step = step;
  overlay.time = built_.world->time();
  const auto sensor = built_.cell.sensors.find(description_.film.force_sensor);
  if (sensor != built_.cell.sensors.end()) {
    overlay.force_N = contact_force(sensor->second, built_, biases);
    overlay.force_limit_N = description_.film.force_limit_N;
  }
  auto pushed = film_.push(built_.world->data(), overlay);
  return pushed ? Diagnostics{} : std::move(pushed.error());
}

}  // namespace takt::scenario
