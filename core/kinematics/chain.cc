#include "core/kinematics/chain.h"

#include <cmath>

namespace takt::kinematics {
namespace {

/// R * Rz(q): a turn about local z mixes the first two columns.
inline void turn_about_z(Eigen::Matrix3d& R, double q) {
  const double s = std::sin(q);
  const double c = std::cos(q);
  const Eigen::Vector3d x = R.col(0);
  R.col(0) = c * x + s * R.col(1);
  R.col(1) = c * R.col(1) - s * x;
}

/// a x b without Eigen's temporaries.
inline Eigen::Vector3d cross(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}

/// z x v for local z.
inline Eigen::Vector3d z_cross(const Eigen::Vector3d& v) { return {-v.y(), v.x(), 0.0}; }

/// I of a body moved from the origin to a point r away: r is the old origin in the new frame, h its first moment.
inline Eigen::Matrix3d shifted(const SpatialInertia& body, const Eigen::Vector3d& r) {
  const double diagonal = 2.0 * r.dot(body.h) + body.mass * r.squaredNorm();
  const Eigen::Vector3d k = body.h + 0.5 * body.mass * r;
  return body.I + Eigen::Matrix3d(diagonal * Eigen::Matrix3d::Identity()) -
         Eigen::Matrix3d(r * k.transpose() + k * r.transpose());
}

}  // namespace

SpatialInertia SpatialInertia::at(double mass, const Eigen::Isometry3d& X, const Eigen::Matrix3d& I_C) {
  const SpatialInertia centred{mass, Eigen::Vector3d::Zero(), X.linear() * I_C * X.linear().transpose()};
  return {mass, mass * X.translation(), shifted(centred, X.translation())};
}

SpatialInertia& SpatialInertia::operator+=(const SpatialInertia& other) {
  mass += other.mass;
  h += other.h;
  I += other.I;
  return *this;
}

template <class Visit>
Eigen::Isometry3d Chain::walk(const JointVector& q, Visit visit) const {
  // All sines first: a call in the loop below would push the frame out of the registers.
  std::array<double, kMaxJoints> sine, cosine;
  for (int i = 0; i < count_; ++i) {
    sine[static_cast<std::size_t>(i)] = std::sin(q[i]);
    cosine[static_cast<std::size_t>(i)] = std::cos(q[i]);
  }
  Columns c{Eigen::Vector4d::UnitX(), Eigen::Vector4d::UnitY(), Eigen::Vector4d::UnitZ(), Eigen::Vector4d::UnitW()};
  const auto shift = [&c](const Eigen::Vector3d& p) { c.p += c.x * p.x() + c.y * p.y() + c.z * p.z(); };
  const auto turn = [&c](const Eigen::Matrix3d& R) {
    const Eigen::Vector4d x = c.x * R(0, 0) + c.y * R(1, 0) + c.z * R(2, 0);
    const Eigen::Vector4d y = c.x * R(0, 1) + c.y * R(1, 1) + c.z * R(2, 1);
    c.z = c.x * R(0, 2) + c.y * R(1, 2) + c.z * R(2, 2);
    c.x = x;
    c.y = y;
  };
  for (int i = 0; i < count_; ++i) {
    const auto k = static_cast<std::size_t>(i);
    shift(segments_[k].p);
    turn(segments_[k].R);
    visit(i, c);
    if (segments_[k].prismatic) {
      c.p += c.z * q[i];
    } else {
      const Eigen::Vector4d x = c.x * cosine[k] + c.y * sine[k];
      c.y = c.y * cosine[k] - c.x * sine[k];
      c.x = x;
    }
  }
  shift(X_LF_.translation());
  turn(X_LF_.linear());
  Eigen::Isometry3d X_BF;
  X_BF.matrix() << c.x, c.y, c.z, c.p;
  return X_BF;
}

Eigen::Isometry3d Chain::forward(const JointVector& q) const {
  return walk(q, [](int, const Columns&) {});
}

void Chain::fill(const JointVector& q, Eigen::Isometry3d& X_BF, Jacobian& J) const {
  // Axis and origin of each joint first, in the places where the column will stand.
  X_BF = walk(q, [&J](int i, const Columns& c) { J.col(i) << c.p.head<3>(), c.z.head<3>(); });
  const Eigen::Vector3d p_F = X_BF.translation();
  for (int i = 0; i < count_; ++i) {
    const Eigen::Vector3d z = J.col(i).tail<3>();
    if (segment(i).prismatic) {
      J.col(i) << z, Eigen::Vector3d::Zero();
    } else {
      J.col(i).head<3>() = cross(z, p_F - J.col(i).head<3>());
    }
  }
}

void Chain::jacobian(const JointVector& q, Eigen::Isometry3d& X_BF, Jacobian& J) const {
  J.resize(6, count_);
  fill(q, X_BF, J);
}

Vector6 Chain::jacobian_dot_times_dq(const JointVector& q, const JointVector& dq) const {
  Eigen::Isometry3d X_BF;
  Jacobian J(6, count_);
  fill(q, X_BF, J);
  return bias(J, dq);
}

Vector6 Chain::bias(const Jacobian& J, const JointVector& dq) const {
  // Spatial vectors about the point where F is now. Each joint's screw, a column of J, moves with the joints before
  // it; what comes out is the acceleration field, of which F, itself in motion, sees w x v more.
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  Eigen::Vector3d alpha = Eigen::Vector3d::Zero();
  for (int i = 0; i < count_; ++i) {
    const Eigen::Vector3d v_own = J.col(i).head<3>() * dq[i];
    const Eigen::Vector3d w_own = J.col(i).tail<3>() * dq[i];
    a += cross(w, v_own) + cross(v, w_own);
    alpha += cross(w, w_own);
    v += v_own;
    w += w_own;
  }
  Vector6 product;
  product << a + cross(w, v), alpha;
  return product;
}

void Chain::relative(const JointVector& q, Rotations& R, Vectors& p) const {
  for (int i = 0; i < count_; ++i) {
    const auto k = static_cast<std::size_t>(i);
    R[k] = segments_[k].R;
    p[k] = segments_[k].p;
    if (segments_[k].prismatic) {
      p[k] += R[k].col(2) * q[i];
    } else {
      turn_about_z(R[k], q[i]);
    }
  }
}

SpatialInertia Chain::payload_body(const Payload& payload) const {
  Eigen::Isometry3d X_LC = X_LF_;
  X_LC.translation() += X_LF_.linear() * payload.p_FC;
  return SpatialInertia::at(payload.mass, X_LC, payload.I_C);
}

Chain::KinematicState Chain::stance(const JointVector& q, const Payload& payload) const {
  KinematicState at;
  relative(q, at.R, at.p);
  at.last_body = segment(count_ - 1).body;
  if (payload.mass > 0.0) at.last_body += payload_body(payload);
  return at;
}

template <Chain::Moving kMoving>
JointVector Chain::newton_euler(const KinematicState& at, const JointVector& dq, const JointVector& ddq,
                                const Eigen::Vector3d& gravity_B) const {
  constexpr bool kTurns = kMoving == Moving::kAll;
  constexpr bool kAccelerates = kMoving != Moving::kNothing;
  Vectors force, moment;

  // Outwards: velocity and acceleration of each frame in its own axes. The base accelerates against gravity, which
  // loads every body with its weight.
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
  Eigen::Vector3d alpha = Eigen::Vector3d::Zero();
  Eigen::Vector3d a = -gravity_B;
  for (int i = 0; i < count_; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Eigen::Matrix3d& R = at.R[k];
    if constexpr (kAccelerates) a += cross(alpha, at.p[k]);
    if constexpr (kTurns) a += cross(w, cross(w, at.p[k]));
    a = (R.transpose() * a).eval();
    if constexpr (kTurns) w = (R.transpose() * w).eval();
    if constexpr (kAccelerates) alpha = (R.transpose() * alpha).eval();
    if (segments_[k].prismatic) {
      if constexpr (kTurns) a -= 2.0 * dq[i] * z_cross(w);  // 2 w x (z dq) = -2 dq (z x w)
      if constexpr (kAccelerates) a.z() += ddq[i];
    } else {
      if constexpr (kTurns) alpha -= dq[i] * z_cross(w);
      if constexpr (kAccelerates) alpha.z() += ddq[i];
      if constexpr (kTurns) w.z() += dq[i];
    }
    const SpatialInertia& body = i + 1 == count_ ? at.last_body : segments_[k].body;
    force[k] = body.mass * a;
    if constexpr (kAccelerates) force[k] += cross(alpha, body.h);
    if constexpr (kTurns) force[k] += cross(w, cross(w, body.h));
    const Eigen::Vector3d by_weight = cross(body.h, a);
    if constexpr (kTurns) {
      moment[k] = body.I * alpha + cross(w, body.I * w) + by_weight;
    } else if constexpr (kAccelerates) {
      moment[k] = body.I * alpha + by_weight;
    } else {
      moment[k] = by_weight;
    }
  }

  // Inwards: what each joint must carry; its own share is the component along the axis.
  JointVector tau(count_);
  for (int i = count_ - 1; i >= 0; --i) {
    const auto k = static_cast<std::size_t>(i);
    tau[i] = segments_[k].prismatic ? force[k].z() : moment[k].z();
    if (i == 0) break;
    const Eigen::Vector3d f = at.R[k] * force[k];
    force[k - 1] += f;
    moment[k - 1] += at.R[k] * moment[k] + cross(at.p[k], f);
  }
  return tau;
}

JointVector Chain::inverse_dynamics(const JointVector& q, const JointVector& dq, const JointVector& ddq,
                                    const Eigen::Vector3d& gravity_B, const Payload& payload) const {
  return newton_euler<Moving::kAll>(stance(q, payload), dq, ddq, gravity_B);
}

Chain::PathDynamics Chain::path_dynamics(const JointVector& q, const JointVector& first, const JointVector& second,
                                         const Eigen::Vector3d& gravity_B, const Payload& payload) const {
  const KinematicState at = stance(q, payload);
  const Eigen::Vector3d weightless = Eigen::Vector3d::Zero();
  return {.inertial = newton_euler<Moving::kFromRest>(at, {}, first, weightless),
          .centrifugal = newton_euler<Moving::kAll>(at, first, second, weightless),
          .gravity = newton_euler<Moving::kNothing>(at, {}, {}, gravity_B)};
}

JointMatrix Chain::mass_matrix(const JointVector& q, const Payload& payload) const {
  Rotations R;
  Vectors p;
  relative(q, R, p);
  JointMatrix M(count_, count_);
  SpatialInertia composite;  // all bodies from joint i outwards, in its frame
  if (payload.mass > 0.0) composite = payload_body(payload);
  for (int i = count_ - 1; i >= 0; --i) {
    const auto k = static_cast<std::size_t>(i);
    composite += segments_[k].body;
    // The wrench that gives joint i unit acceleration, carried inwards past the other joints.
    const bool slides = segments_[k].prismatic;
    Eigen::Vector3d f = slides ? Eigen::Vector3d(0.0, 0.0, composite.mass) : z_cross(composite.h);
    Eigen::Vector3d n = slides ? Eigen::Vector3d(-z_cross(composite.h)) : Eigen::Vector3d(composite.I.col(2));
    M(i, i) = slides ? f.z() : n.z();
    for (int j = i; j > 0; --j) {
      const auto m = static_cast<std::size_t>(j);
      f = (R[m] * f).eval();
      n = (R[m] * n + cross(p[m], f)).eval();
      M(i, j - 1) = M(j - 1, i) = segments_[m - 1].prismatic ? f.z() : n.z();
    }
    if (i == 0) break;
    SpatialInertia turned{composite.mass, R[k] * composite.h, R[k] * composite.I * R[k].transpose()};
    turned.I = shifted(turned, p[k]);
    turned.h += composite.mass * p[k];
    composite = turned;
  }
  return M;
}

}  // namespace takt::kinematics
