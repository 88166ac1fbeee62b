#include "sim/drive_law.h"

#include <algorithm>

#include <mujoco/mujoco.h>
#include <Eigen/Geometry>

#include "sim/spring_row.h"

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
constexpr double kEngaged = 0.8;   // of the depth: a bit that is higher does not turn the screw: there are the chamfers

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
      for (const world::Bore& bore : object.shapes[i].bores) {
        const int body = mj_name2id(&model, mjOBJ_BODY, object.name.c_str());
        sockets.push_back({.body = body,
                           .mass = model.body_mass[body],
                           .inertia = Eigen::Map<const Vector3d>(model.body_inertia + 3 * body).minCoeff(),
                           .X_OS = object.shapes[i].X_OG * bore.X_SB * Eigen::Translation3d(0, 0, -bore.depth),
                           .radius = bore.radius,
                           .depth = bore.depth});
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
    : sockets_(sockets_of(model, description)), jacobians_(6 * static_cast<std::size_t>(model.nv)) {
  for (const RobotDescription& robot : description.robots) {
    for (const std::string& link : robot.bits) {
      const std::string name = robot.name + "/" + link;
      const int body = mj_name2id(&model, mjOBJ_BODY, name.c_str());
      const int equality = mj_name2id(&model, mjOBJ_EQUALITY, (name + "/drive").c_str());
      if (body >= 0 && equality >= 0)
        bits_.push_back({.body = body, .equality = equality, .reach = reach_of(model, body)});
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

/// What MuJoCo has to know: which bodies the constraint is between.
void DriveLaw::apply(mjModel& model, mjData& data, const Bit& bit) const {
  data.eq_active[bit.equality] = bit.socket >= 0 ? 1 : 0;
  if (bit.socket < 0) return;
  model.eq_obj1id[bit.equality] = sockets_[static_cast<std::size_t>(bit.socket)].body;
  model.eq_obj2id[bit.equality] = bit.body;
}

bool DriveLaw::watch(mjModel& model, mjData& data) {
  bool changed = false;
  for (Bit& bit : bits_) {
    const std::int64_t socket = socket_around(data, bit);
    if (socket == bit.socket) continue;
    bit.socket = socket;
    bit.twist = 0.0;  // in the middle of its play
    apply(model, data, bit);
    changed = true;
  }
  return changed;
}

void DriveLaw::prepare(const mjModel& model, mjData& data) {
  for (Bit& bit : bits_) {
    const int row = bit.socket >= 0 ? row_of_equality(data, bit.equality) : -1;
    if (row < 0) continue;
    silence_rows(model, data, row, 5);
    set_turn(model, data, bit, row + 5);
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
  Eigen::Map<Eigen::RowVectorXd> turn(data.efc_J + static_cast<Eigen::Index>(row) * nv, nv);
  turn.noalias() = axis.transpose() * DriveJacobian(of_screw, 3, nv);
  turn.noalias() -= axis.transpose() * DriveJacobian(of_bit, 3, nv);
  bit.twist += model.opt.timestep * rate_of_row(model, data, row);
  const double stretch = stretch_of(bit.twist);
  if (stretch == 0.0) return silence_rows(model, data, row, 1);
  const double stiffness = key_stiffness(2.0 * socket.radius, bit.reach);
  set_spring(model, data, row, {stiffness, kKeyDampingTime * stiffness, socket.inertia}, stretch);
}

void DriveLaw::sense(mjData& data) const {
  for (const Bit& bit : bits_) {
    const int row = bit.socket >= 0 ? row_of_equality(data, bit.equality) : -1;
    if (row < 0) continue;
    const Pose X_WB = body_pose(data, bit.body);
    const Vector3d torque = data.efc_force[row + 5] * X_WB.linear().col(2);
    take_weld(data, row, sockets_[static_cast<std::size_t>(bit.socket)].body, bit.body,
              {Vector3d::Zero(), torque, X_WB.translation()});
  }
}

void DriveLaw::resume(mjModel& model, mjData& data) const {
  for (const Bit& bit : bits_) apply(model, data, bit);
}

void DriveLaw::stream(StateStream& state) {
  for (Bit& bit : bits_) {
    state(bit.socket);
    state(bit.twist);
  }
}

}  // namespace takt::sim
