#include "sim/machines/vacuum_cup.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include "sim/contact/body_force.h"

namespace takt::sim {
namespace {

using Eigen::Vector3d;

constexpr int kNothing = -1;
/// A lip of fewer points would be tight on an edge.
constexpr std::size_t kFewestPoints = 6;

SimOutputDescription closed() {
  SimOutputDescription wire;
  wire.initial = 0.0;
  return wire;
}

}  // namespace

Result<std::unique_ptr<SimDevice>> SimVacuumCup::make(const mjModel& model, const std::string& robot,
                                                      const device::VacuumCupDescription& cup) {
  Plant plant{.lips = {},
              .point_of_geom = std::vector<int>(static_cast<std::size_t>(model.ngeom), kNothing),
              .body_of_geom = std::vector<int>(model.geom_bodyid, model.geom_bodyid + model.ngeom),
              .own = std::vector<bool>(static_cast<std::size_t>(model.nbody), false)};
  std::size_t points = 0;
  for (const std::string& name : cup.lips) {
    Lip lip{.body = mj_name2id(&model, mjOBJ_BODY, (robot + "/" + name).c_str()), .first = points};
    if (lip.body < 0) return failure(Code::kUnknownName, "", fmt::format("no lip '{}'", name));
    for (int geom = 0; geom < model.ngeom; ++geom) {
      const bool point = model.geom_bodyid[geom] == lip.body && model.geom_type[geom] == mjGEOM_SPHERE &&
                         (model.geom_contype[geom] != 0 || model.geom_conaffinity[geom] != 0);
      if (point) plant.point_of_geom[static_cast<std::size_t>(geom)] = static_cast<int>(points++);
    }
    lip.points = points - lip.first;
    if (lip.points < kFewestPoints) {
      return failure(Code::kWrongSize, "", fmt::format("the lip '{}' has {} spheres", name, lip.points),
                     fmt::format("Give {} or more", kFewestPoints));
    }
    plant.lips.push_back(lip);
  }
  for (int body = 1; body < model.nbody; ++body) {
    const char* name = mj_id2name(&model, mjOBJ_BODY, body);
    plant.own[static_cast<std::size_t>(body)] = name != nullptr && std::string_view(name).starts_with(robot + "/");
  }
  return std::unique_ptr<SimDevice>(new SimVacuumCup(cup, std::move(plant)));
}

SimVacuumCup::SimVacuumCup(const device::VacuumCupDescription& cup, Plant plant)
    : suction(closed()), figures_(cup), plant_(std::move(plant)) {
  touched_.assign(plant_.lips.back().first + plant_.lips.back().points, kNothing);
}

void SimVacuumCup::start(const mjData&) {}

void SimVacuumCup::find_parts(const mjData& data) {
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
  for (Lip& lip : plant_.lips) find_part(lip);
}

/// The body that most of a lip touches, of several the one of the first point.
void SimVacuumCup::find_part(Lip& lip) const {
  const std::span points(touched_.data() + lip.first, lip.points);
  lip.part = kNothing;
  std::ptrdiff_t most = 0;
  for (const int body : points) {
    if (body == kNothing) continue;
    const std::ptrdiff_t count = std::ranges::count(points, body);
    if (count <= most) continue;
    most = count;
    lip.part = body;
  }
  lip.tight = static_cast<double>(most) / static_cast<double>(lip.points);
}

void SimVacuumCup::change_pressure(double duration) {
  const bool open = *suction.wire() >= 0.5;
  double leak = 0.0;
  for (const Lip& lip : plant_.lips) leak += figures_.lip_leak * (1.0 - lip.tight);
  const double drawn = open ? figures_.vacuum_max : 0.0;
  // Exact over a step in which nothing changes: dp/dt = (drawn - (1 + leak) p) / time.
  const double time = open ? figures_.evacuation : figures_.venting;
  const double rest = drawn / (1.0 + leak);
  pressure_ = rest + (pressure_ - rest) * std::exp(-(1.0 + leak) * duration / time);
  switched_ = pressure_ >= (switched_ ? figures_.switch_off : figures_.switch_on);
}

void SimVacuumCup::actuate(mjData& data, const Substep& step) {
  find_parts(data);
  change_pressure(step.duration);
  if (pressure_ <= 0.0) return;
  for (const Lip& lip : plant_.lips) {
    if (lip.part == kNothing) continue;
    const Vector3d mouth = Eigen::Map<const Vector3d>(data.xpos + 3 * lip.body);
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R_WL(data.xmat + 9 * lip.body);
    const Vector3d towards_part = pressure_ * figures_.area * R_WL.col(2);
    add_force(data, lip.body, towards_part, mouth);
    if (lip.part > 0) add_force(data, static_cast<int>(lip.part), -towards_part, mouth);
  }
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
  for (Lip& lip : plant_.lips) {
    state(lip.tight);
    state(lip.part);
  }
  state(pressure_);
  state(switched_);
}

}  // namespace takt::sim
