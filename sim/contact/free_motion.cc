#include "sim/contact/free_motion.h"

#include <algorithm>
#include <cmath>

#include <mujoco/mujoco.h>

namespace takt::sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMatrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double kLargestTurn = 0.02;  // rad in one step of the midpoint rule
constexpr int kMostTurns = 1000;       // 20 rad in a step of the physics: nothing that is meant turns faster
constexpr int kNewtonSteps = 8;
/// rad/s: below it the energy that an explicit step adds is less than 1e-12 of that of the turn in a step.
constexpr double kSlow = 1e-3;

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d S;
  S << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return S;
}

/// The angular velocity in the middle of a step: I (m - w) = -h/2 m x I m.
Vector3d middle_of_turn(const Matrix3d& I, const Vector3d& w, double duration) {
  const double half = 0.5 * duration, enough = 1e-14 * w.norm();
  Vector3d m = w;
  for (int i = 0; i < kNewtonSteps; ++i) {
    const Vector3d momentum = I * m;
    const Vector3d residual = momentum - I * w + half * m.cross(momentum);
    const Matrix3d slope = I + half * (cross_matrix(m) * I - cross_matrix(momentum));
    const Vector3d change = slope.partialPivLu().solve(residual);
    m -= change;
    if (change.norm() <= enough) break;
  }
  return m;
}

/// Inertia about the origin of its frame, from that about a point beside it.
Matrix3d about(const Matrix3d& I, double mass, const Vector3d& p) {
  const Matrix3d S = cross_matrix(p);
  return I - mass * S * S;
}

}  // namespace

Eigen::Quaterniond turn_freely(const Matrix3d& I, Vector3d& w, double duration) {
  const double turns = std::clamp(std::ceil(w.norm() * std::abs(duration) / kLargestTurn), 1.0, double{kMostTurns});
  const double step = duration / turns;
  Eigen::Quaterniond turned = Eigen::Quaterniond::Identity();
  for (int i = 0; i < static_cast<int>(turns); ++i) {
    const Vector3d m = middle_of_turn(I, w, step);
    w = 2.0 * m - w;
    // Cayley's rotation: the one with which the momentum in the world stays as it is.
    const Vector3d half = 0.5 * step * m;
    turned = turned * Eigen::Quaterniond(1.0, half.x(), half.y(), half.z());
    turned.normalize();
  }
  return turned;
}

FreeMotion::FreeMotion(const mjModel& model) {
  if (model.opt.integrator == mjINT_RK4) return;
  for (int joint = 0; joint < static_cast<int>(model.njnt); ++joint) {
    const int root = model.jnt_bodyid[joint], tree = model.body_treeid[root];
    if (model.jnt_type[joint] != mjJNT_FREE || model.tree_dofnum[tree] != 6) continue;
    Flyer flyer{.tree = tree, .position = model.jnt_qposadr[joint], .velocity = model.jnt_dofadr[joint]};
    // All bodies of the tree are fixed to the root: their poses in it come from those of their parents.
    std::vector<Eigen::Isometry3d> poses(static_cast<std::size_t>(model.nbody), Eigen::Isometry3d::Identity());
    const auto pose_of = [](const double* p, const double* q) {
      Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
      X.translation() = Eigen::Map<const Vector3d>(p);
      X.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
      return X;
    };
    Matrix3d I_B = Matrix3d::Zero();
    for (int body = root; body < model.tree_bodyadr[tree] + model.tree_bodynum[tree]; ++body) {
      const auto number = static_cast<std::size_t>(body);
      if (body != root) {
        poses[number] = poses[static_cast<std::size_t>(model.body_parentid[body])] *
                        pose_of(model.body_pos + 3 * body, model.body_quat + 4 * body);
      }
      const Eigen::Isometry3d X = poses[number] * pose_of(model.body_ipos + 3 * body, model.body_iquat + 4 * body);
      const Vector3d principal = Eigen::Map<const Vector3d>(model.body_inertia + 3 * body);
      const Matrix3d I = X.linear() * principal.asDiagonal() * X.linear().transpose();
      I_B += about(I, model.body_mass[body], X.translation());
      flyer.mass += model.body_mass[body];
      flyer.p_BC += model.body_mass[body] * X.translation();
    }
    if (!(flyer.mass > 0.0)) continue;
    flyer.p_BC /= flyer.mass;
    flyer.I_C = about(I_B, -flyer.mass, flyer.p_BC);
    flyers_.push_back(flyer);
  }
}

void FreeMotion::prepare(const mjModel& model, mjData& data) {
  const double h = model.opt.timestep;
  for (Flyer& flyer : flyers_) {
    const double* q = data.qpos + flyer.position;
    const double* v = data.qvel + flyer.velocity;
    const Vector3d w = Eigen::Map<const Vector3d>(v + 3);
    flyer.flies = data.tree_awake[flyer.tree] != 0 && w.squaredNorm() > kSlow * kSlow;
    if (!flyer.flies) continue;
    flyer.q_WB = Eigen::Quaterniond(q[3], q[4], q[5], q[6]).normalized();
    const Matrix3d R = flyer.q_WB.toRotationMatrix();
    const Vector3d& r = flyer.p_BC;
    const Vector3d v_B = Eigen::Map<const Vector3d>(v);
    flyer.p_WC = Eigen::Map<const Vector3d>(q) + R * r;
    flyer.v_WC = v_B + R * w.cross(r);
    flyer.w_free = w;
    flyer.turn = turn_freely(flyer.I_C, flyer.w_free, h);
    flyer.v_free = flyer.v_WC - R * (flyer.turn * flyer.w_free.cross(r));

    // What MuJoCo takes off for it, and what leads there.
    const Vector3d a = (flyer.v_free - v_B) / h, alpha = (flyer.w_free - w) / h;
    const Matrix3d I_B = about(flyer.I_C, flyer.mass, r);
    const Vector3d force = flyer.mass * (a + R * (alpha.cross(r) + w.cross(w.cross(r))));
    const Vector3d torque = I_B * alpha + w.cross(I_B * w) + flyer.mass * r.cross(R.transpose() * a);
    Eigen::Map<Vector3d>(data.qfrc_bias + flyer.velocity) -= force;
    Eigen::Map<Vector3d>(data.qfrc_bias + flyer.velocity + 3) -= torque;
  }
}

void FreeMotion::finish(const mjModel& model, mjData& data) const {
  const double h = model.opt.timestep;
  for (const Flyer& flyer : flyers_) {
    if (!flyer.flies) continue;
    double* q = data.qpos + flyer.position;
    Eigen::Map<Vector3d> v(data.qvel + flyer.velocity), w(data.qvel + flyer.velocity + 3);
    const Vector3d dw = w - flyer.w_free, dv = v - flyer.v_free;
    const Vector3d& r = flyer.p_BC;
    const Vector3d v_C = flyer.v_WC + dv + flyer.q_WB * dw.cross(r);
    const Vector3d half = 0.5 * h * dw;
    Eigen::Quaterniond q_WB = flyer.q_WB * flyer.turn * Eigen::Quaterniond(1.0, half.x(), half.y(), half.z());
    q_WB.normalize();
    v = v_C - q_WB * Vector3d(w).cross(r);
    Eigen::Map<Vector3d>(q, 3) = flyer.p_WC + h * v_C - q_WB * r;
    q[3] = q_WB.w();
    q[4] = q_WB.x();
    q[5] = q_WB.y();
    q[6] = q_WB.z();
  }
}

}  // namespace takt::sim
