#include "sim/contact/drive_law.h"

#include <algorithm>
#include <span>
#include <string>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "sim/contact/contact_law.h"
#include "sim/contact/spring_row.h"

namespace takt::sim {
namespace {

using Eigen::Vector3d;

constexpr double kShearModulus = 79e9;  // Pa, steel
constexpr double kHexagon = 0.1154;     // torsion constant of a hexagon over the fourth power of its width across flats
constexpr double kKeyDampingTime = 0.002;  // s, damping over stiffness, as that of contacts of steel
// rad each way: a key of 5 mm is 0.1 mm narrower than its socket in the mean (ISO 2936, ISO 4762), sqrt(3) 0.1 / 5.
constexpr double kPlay = 0.035;
constexpr double kBeyond = 0.001;  // m beyond mouth and bottom
constexpr double kAligned = 0.95;  // cosine between the axes
// Of stiffness times step squared, chosen by trial: with two fifths of it, some screws held askew still diverged.
constexpr double kInertiaShare = 1.0 / 15.0;
constexpr double kAfterTouch = 0.02;  // s for which the inertia stays: a screw that rattles touches in every few steps
constexpr double kEngaged = 0.8;  // of the depth: a bit that is higher does not turn the screw: there are the chamfers

using DriveJacobian = Eigen::Map<Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>>;

Pose body_pose(const mjData& data, int body) {
  Pose X = Pose::Identity();
  X.translation() = Eigen::Map<const Vector3d>(data.xpos + 3 * body);
  X.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data.xmat + 9 * body);
  return X;
}

/// Nm/rad, of a hexagon key from its holder to its end.
double key_stiffness(double width, double length) {
  return kShearModulus * kHexagon * width * width * width * width / length;
}

/// rad, of the flanks beyond the play.
double stretch_of(double twist) { return twist - std::clamp(twist, -kPlay, kPlay); }

}  // namespace

std::vector<ScrewSocket> sockets_of(const mjModel& model, const WorldDescription& description) {
  std::vector<ScrewSocket> sockets;
  for (const ObjectDescription& object : description.objects) {
    for (std::size_t i = 0; object.screw && i < object.shapes.size(); ++i) {
      if (i == object.screw->shank) continue;
      const auto* head = std::get_if<kinematics::Cylinder>(&object.shapes[i].shape);
      for (const world::Bore& bore : object.shapes[i].bores) {
        const int body = mj_name2id(&model, mjOBJ_BODY, object.name.c_str());
        sockets.push_back({.body = body,
                           .mass = model.body_mass[body],
                           .inertia = Eigen::Map<const Vector3d>(model.body_inertia + 3 * body).minCoeff(),
                           .X_OS = object.shapes[i].X_OG * bore.X_SB * Eigen::Translation3d(0, 0, -bore.depth),
                           .radius = bore.radius,
                           .depth = bore.depth,
                           .head_radius = head ? head->radius : bore.radius});
      }
    }
  }
  return sockets;
}

BitInSocket look_into(const ScrewSocket& socket, const mjData& data, int bit, double reach) {
  const Pose X_WB = body_pose(data, bit), X_WS = body_pose(data, socket.body) * socket.X_OS;
  BitInSocket seen{.p_S = X_WS.inverse(Eigen::Isometry) * (X_WB * Vector3d(0, 0, reach))};
  seen.inside = seen.p_S.head<2>().norm() < socket.radius && seen.p_S.z() > -kBeyond &&
                seen.p_S.z() < socket.depth + kBeyond && X_WS.linear().col(2).dot(X_WB.linear().col(2)) < -kAligned;
  return seen;
}

double reach_of(const mjModel& model, int bit) {
  double reach = 0.0;
  for (int i = 0; i < model.body_geomnum[bit]; ++i) {
    const int geom = model.body_geomadr[bit] + i;
    if (model.geom_type[geom] == mjGEOM_CYLINDER)
      reach = std::max(reach, model.geom_pos[3 * geom + 2] + model.geom_size[3 * geom + 1]);
  }
  return reach;
}

DriveLaw::DriveLaw(const mjModel& model, const WorldDescription& description)
    : sockets_(sockets_of(model, description)),
      jacobians_(12 * static_cast<std::size_t>(model.nv)),
      row_(static_cast<Eigen::Index>(model.nv)) {
  const double h = model.opt.timestep;
  for (const RobotDescription& robot : description.robots) {
    for (const std::string& link : robot.bits) {
      const std::string name = robot.name + "/" + link;
      const int body = mj_name2id(&model, mjOBJ_BODY, name.c_str());
      const int equality = mj_name2id(&model, mjOBJ_EQUALITY, (name + "/drive").c_str());
      if (body < 0 || equality < 0) continue;
      bits_.push_back({.body = body, .equality = equality, .reach = reach_of(model, body)});
      for (const ScrewSocket& socket : sockets_) {
        const char* screw = mj_id2name(&model, mjOBJ_BODY, socket.body);
        const auto& object = *std::ranges::find(description.objects, std::string(screw), &ObjectDescription::name);
        const ContactPair pair = combine(robot.surface(link), object.contact, description.contact_rules);
        bits_.back().inertia.push_back(kInertiaShare * h * h * pair.stiffness);
      }
    }
  }
}

std::int64_t DriveLaw::socket_around(const mjData& data, const Bit& bit) const {
  for (std::size_t i = 0; i < sockets_.size(); ++i) {
    const BitInSocket seen = look_into(sockets_[i], data, bit.body, bit.reach);
    if (seen.inside && seen.p_S.z() < kEngaged * sockets_[i].depth) return static_cast<std::int64_t>(i);
  }
  return -1;
}

/// The socket of the screw that the bit touches in this state; -1: none.
std::int64_t DriveLaw::touching(const mjModel& model, const mjData& data, const Bit& bit) const {
  for (const mjContact& contact : std::span(data.contact, static_cast<std::size_t>(data.ncon))) {
    if (contact.geom[0] < 0 || contact.geom[1] < 0) continue;
    const int first = model.geom_bodyid[contact.geom[0]], second = model.geom_bodyid[contact.geom[1]];
    if (first != bit.body && second != bit.body) continue;
    const auto screw = std::ranges::find(sockets_, first == bit.body ? second : first, &ScrewSocket::body);
    if (screw != sockets_.end()) return screw - sockets_.begin();
  }
  return -1;
}

/// What MuJoCo has to know: which bodies the constraint is between.
void DriveLaw::apply(mjModel& model, mjData& data, const Bit& bit) const {
  const std::int64_t screw = partner(bit);
  data.eq_active[bit.equality] = screw >= 0 ? 1 : 0;
  if (screw < 0) return;
  model.eq_obj1id[bit.equality] = sockets_[static_cast<std::size_t>(screw)].body;
  model.eq_obj2id[bit.equality] = bit.body;
}

bool DriveLaw::watch(mjModel& model, mjData& data) {
  bool changed = false;
  for (Bit& bit : bits_) {
    const std::int64_t before = partner(bit), socket = socket_around(data, bit);
    if (socket != bit.socket) bit.twist = 0.0;  // in the middle of its play
    bit.socket = socket;
    bit.since += model.opt.timestep;
    if (const std::int64_t screw = touching(model, data, bit); screw >= 0) {
      bit.touched = screw;
      bit.since = 0.0;
    } else if (bit.since > kAfterTouch) {
      bit.touched = -1;
      bit.since = 0.0;
    }
    if (partner(bit) == before) continue;
    apply(model, data, bit);
    changed = true;
  }
  return changed;
}

/// Where the rows of a bit act on the screw, in the world.
struct DriveLaw::Axes {
  Vector3d point, along, u, v;  ///< m, the screw's centre of mass; unit: the axis of the bit, and across
};

DriveLaw::Axes DriveLaw::axes_of(const mjData& data, const Bit& bit) const {
  const int screw = sockets_[static_cast<std::size_t>(partner(bit))].body;
  const Eigen::Matrix3d R_WB = body_pose(data, bit.body).linear();
  return {.point = Eigen::Map<const Vector3d>(data.xipos + 3 * screw),
          .along = R_WB.col(2),
          .u = R_WB.col(0),
          .v = R_WB.col(1)};
}

void DriveLaw::prepare(const mjModel& model, mjData& data) {
  for (Bit& bit : bits_) {
    const int row = partner(bit) >= 0 ? row_of_equality(data, bit.equality) : -1;
    if (row < 0) continue;
    silence_rows(model, data, row, 6);
    if (bit.touched == partner(bit)) set_inertias(model, data, bit, row);
    if (bit.socket >= 0) set_turn(model, data, bit, row + 5);
  }
}

/// Three rows for the centre of mass of the screw, two for its tilt, one for its turn.
void DriveLaw::set_inertias(const mjModel& model, mjData& data, const Bit& bit, int row) {
  const auto nv = static_cast<Eigen::Index>(model.nv);
  const auto index = static_cast<std::size_t>(bit.touched);
  const ScrewSocket& socket = sockets_[index];
  const Axes axes = axes_of(data, bit);
  const auto scratch = [&](Eigen::Index i) { return jacobians_.data() + 3 * i * nv; };
  mj_jac(&model, &data, scratch(0), scratch(1), axes.point.data(), socket.body);
  mj_jac(&model, &data, scratch(2), scratch(3), axes.point.data(), bit.body);
  DriveJacobian shift(scratch(0), 3, nv), turn(scratch(1), 3, nv);
  shift -= DriveJacobian(scratch(2), 3, nv);
  turn -= DriveJacobian(scratch(3), 3, nv);
  const double mass = bit.inertia[index], inertia = mass * socket.head_radius * socket.head_radius;
  int next = row;
  for (const DriveJacobian* moves : {&shift, &turn}) {
    for (const Vector3d* axis : {&axes.u, &axes.v, &axes.along}) {
      row_.noalias() = axis->transpose() * *moves;
      set_jacobian(model, data, next, {row_.data(), static_cast<std::size_t>(nv)});
      set_inertia(model, data, next++, moves == &shift ? mass : inertia);
    }
  }
}

void DriveLaw::set_turn(const mjModel& model, mjData& data, Bit& bit, int row) {
  const auto nv = static_cast<Eigen::Index>(model.nv);
  const ScrewSocket& socket = sockets_[static_cast<std::size_t>(bit.socket)];
  const Vector3d axis = body_pose(data, bit.body).linear().col(2);
  double* const of_screw = jacobians_.data();
  double* const of_bit = of_screw + 3 * nv;
  mj_jac(&model, &data, nullptr, of_screw, data.xpos + 3 * socket.body, socket.body);
  mj_jac(&model, &data, nullptr, of_bit, data.xpos + 3 * bit.body, bit.body);
  row_.noalias() = axis.transpose() * DriveJacobian(of_screw, 3, nv);
  row_.noalias() -= axis.transpose() * DriveJacobian(of_bit, 3, nv);
  set_jacobian(model, data, row, {row_.data(), static_cast<std::size_t>(nv)});
  bit.twist += model.opt.timestep * rate_of_row(model, data, row);
  const double stretch = stretch_of(bit.twist);
  if (stretch == 0.0) {
    if (bit.touched != bit.socket) silence_rows(model, data, row, 1);
    return;
  }
  const double stiffness = key_stiffness(2.0 * socket.radius, bit.reach);
  set_spring(model, data, row, {stiffness, kKeyDampingTime * stiffness, socket.inertia}, stretch);
}

void DriveLaw::sense(mjData& data) const {
  for (const Bit& bit : bits_) {
    const int row = partner(bit) >= 0 ? row_of_equality(data, bit.equality) : -1;
    if (row < 0) continue;
    const Axes axes = axes_of(data, bit);
    const auto in_world = [&](const double* force) -> Vector3d {
      return force[0] * axes.u + force[1] * axes.v + force[2] * axes.along;
    };
    const RowWrench wrench{in_world(data.efc_force + row), in_world(data.efc_force + row + 3), axes.point};
    take_weld(data, row, sockets_[static_cast<std::size_t>(partner(bit))].body, bit.body, wrench);
  }
}

void DriveLaw::resume(mjModel& model, mjData& data) const {
  for (const Bit& bit : bits_) apply(model, data, bit);
}

void DriveLaw::stream(StateStream& state) {
  for (Bit& bit : bits_) {
    state(bit.socket);
    state(bit.twist);
    state(bit.touched);
    state(bit.since);
  }
}

}  // namespace takt::sim
