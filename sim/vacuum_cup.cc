#include "sim/vacuum_cup.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "sim/body_force.h"

namespace takt::sim {
namespace {

using Eigen::Vector3d;

constexpr int kNothing = -1;
/// A lip of fewer points would be tight on an edge.
constexpr int kFewestPoints = 6;

SimOutputDescription closed() {
  SimOutputDescription wire;
  wire.initial = 0.0;
  return wire;
}

}  // namespace

Result<std::unique_ptr<SimDevice>> SimVacuumCup::make(const mjModel& model, const std::string& robot,
                                                      const device::VacuumCupDescription& cup) {
  Plant plant{.lip = mj_name2id(&model, mjOBJ_BODY, (robot + "/" + cup.lip).c_str()),
              .point_of_geom = std::vector<int>(static_cast<std::size_t>(model.ngeom), kNothing),
              .body_of_geom = std::vector<int>(model.geom_bodyid, model.geom_bodyid + model.ngeom),
              .own = std::vector<bool>(static_cast<std::size_t>(model.nbody), false),
              .points = 0};
  if (plant.lip < 0) return failure(Code::kUnknownName, "", fmt::format("no lip '{}'", cup.lip));
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const bool point = model.geom_bodyid[geom] == plant.lip && model.geom_type[geom] == mjGEOM_SPHERE &&
                       (model.geom_contype[geom] != 0 || model.geom_conaffinity[geom] != 0);
    if (point) plant.point_of_geom[static_cast<std::size_t>(geom)] = plant.points++;
  }
  for (int body = 1; body < model.nbody; ++body) {
    const char* name = mj_id2name(&model, mjOBJ_BODY, body);
    plant.own[static_cast<std::size_t>(body)] = name != nullptr && std::string_view(name).starts_with(robot + "/");
  }
  if (plant.points < kFewestPoints) {
    return failure(Code::kWrongSize, "", fmt::format("the lip '{}' has {} spheres", cup.lip, plant.points),
                   fmt::format("{} or more", kFewestPoints));
  }
  return std::unique_ptr<SimDevice>(new SimVacuumCup(cup, std::move(plant)));
}

SimVacuumCup::SimVacuumCup(const device::VacuumCupDescription& cup, Plant plant)
    : suction(closed()), figures_(cup), plant_(std::move(plant)) {
  touched_.assign(static_cast<std::size_t>(plant_.points), kNothing);
}

void SimVacuumCup::start(const mjData&) {}

/// The body that most of the lip touches, of several the one of the first point.
void SimVacuumCup::find_part(const mjData& data) {
  std::ranges::fill(touched_, kNothing);
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    for (int side = 0; side < 2; ++side) {
      const int geom = contact.geom[side], other = contact.geom[1 - side];
      if (geom < 0 || other < 0 || contact.dist > 0.0) continue;
      const int point = plant_.point_of_geom[static_cast<std::size_t>(geom)];
      const int body = plant_.body_of_geom[static_cast<std::size_t>(other)];
      if (point >= 0 && !plant_.own[static_cast<std::size_t>(body)]) touched_[static_cast<std::size_t>(point)] = body;
    }
  }
  part_ = kNothing;
  std::ptrdiff_t most = 0;
  for (const int body : touched_) {
    if (body == kNothing) continue;
    const std::ptrdiff_t count = std::ranges::count(touched_, body);
    if (count <= most) continue;
    most = count;
    part_ = body;
  }
  tight_ = static_cast<double>(most) / plant_.points;
}

void SimVacuumCup::change_pressure(double duration) {
  const bool open = *suction.wire() >= 0.5;
  const double leak = figures_.lip_leak * (1.0 - tight_);
  const double drawn = open ? figures_.vacuum_max : 0.0;
  // Exact over a step in which nothing changes: dp/dt = (drawn - (1 + leak) p) / time.
  const double time = open ? figures_.evacuation : figures_.venting;
  const double rest = drawn / (1.0 + leak);
  pressure_ = rest + (pressure_ - rest) * std::exp(-(1.0 + leak) * duration / time);
  switched_ = pressure_ >= (switched_ ? figures_.switch_off : figures_.switch_on);
}

void SimVacuumCup::actuate(mjData& data, const Substep& step) {
  find_part(data);
  change_pressure(step.duration);
  if (part_ == kNothing || pressure_ <= 0.0) return;
  const Vector3d mouth = Eigen::Map<const Vector3d>(data.xpos + 3 * plant_.lip);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R_WL(data.xmat + 9 * plant_.lip);
  const Vector3d towards_part = pressure_ * figures_.area * R_WL.col(2);
  add_force(data, plant_.lip, towards_part, mouth);
  if (part_ > 0) add_force(data, static_cast<int>(part_), -towards_part, mouth);
}

void SimVacuumCup::measure(const mjData&, Nanoseconds now) {
  if (now % figures_.cycle != 0) return;
  const double step = figures_.resolution;
  holding.take(switched_ ? 1.0 : 0.0, now);
  vacuum.take(step > 0.0 ? std::round(pressure_ / step) * step : pressure_, now);
}

void SimVacuumCup::stream(StateStream& state) {
  suction.stream(state);
  for (SimGauge* gauge : {&holding, &vacuum}) gauge->stream_reading(state);
  for (double* value : {&tight_, &pressure_}) state(*value);
  state(part_);
  state(switched_);
}

}  // namespace takt::sim
