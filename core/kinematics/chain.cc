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

Eigen::Isometry3d Chain::forward(const JointVector& q) const {
  Eigen::Matrix3d R = segments_[0].R;
  Eigen::Vector3d p = segments_[0].p;
  for (int i = 0; i < count_; ++i) {
    const Segment& s = segment(i);
    if (i > 0) {
      p += R * s.p;
      R = (R * s.R).eval();
    }
    if (s.prismatic) {
      p += R.col(2) * q[i];
    } else {
      turn_about_z(R, q[i]);
    }
  }
  Eigen::Isometry3d X_BF;
  X_BF.linear().noalias() = R * X_LF_.linear();
  X_BF.translation() = p + R * X_LF_.translation();
  X_BF.makeAffine();
  return X_BF;
}

void Chain::place(const JointVector& q, Placement& placement) const {
  Eigen::Matrix3d R = segments_[0].R;
  Eigen::Vector3d p = segments_[0].p;
  for (int i = 0; i < count_; ++i) {
    const Segment& s = segment(i);
    if (i > 0) {
      p += R * s.p;
      R = (R * s.R).eval();
    }
    const auto k = static_cast<std::size_t>(i);
    placement.z[k] = R.col(2);
    if (s.prismatic) {
      p += R.col(2) * q[i];
    } else {
      turn_about_z(R, q[i]);
    }
    placement.p[k] = p;
  }
  placement.X_BF.linear().noalias() = R * X_LF_.linear();
  placement.X_BF.translation() = p + R * X_LF_.translation();
  placement.X_BF.makeAffine();
}

Vector6 Chain::column(const Placement& placement, int i) const {
  const auto k = static_cast<std::size_t>(i);
  const Eigen::Vector3d& z = placement.z[k];
  Vector6 column;
  if (segment(i).prismatic) {
    column << z, Eigen::Vector3d::Zero();
  } else {
    column << cross(z, placement.X_BF.translation() - placement.p[k]), z;
  }
  return column;
}

void Chain::jacobian(const JointVector& q, Eigen::Isometry3d& X_BF, Jacobian& J) const {
  Placement placement;
  place(q, placement);
  X_BF = placement.X_BF;
  J.resize(6, count_);
  for (int i = 0; i < count_; ++i) J.col(i) = column(placement, i);
}

Vector6 Chain::jacobian_dot_times_dq(const JointVector& q, const JointVector& dq) const {
  Placement placement;
  place(q, placement);
  return bias(placement, dq);
}

Vector6 Chain::bias(const Placement& placement, const JointVector& dq) const {
  // The acceleration of F for ddq = 0, from the base outwards, all in B.
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
  Eigen::Vector3d alpha = Eigen::Vector3d::Zero();
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  Eigen::Vector3d p = placement.p[0];
  const auto carry = [&](const Eigen::Vector3d& to) {
    const Eigen::Vector3d r = to - p;
    a += cross(alpha, r) + cross(w, cross(w, r));
    p = to;
  };
  for (int i = 0; i < count_; ++i) {
    const auto k = static_cast<std::size_t>(i);
    carry(placement.p[k]);
    const Eigen::Vector3d own = placement.z[k] * dq[i];
    if (segment(i).prismatic) {
      a += 2.0 * cross(w, own);
    } else {
      alpha += cross(w, own);
      w += own;
    }
  }
  carry(placement.X_BF.translation());
  Vector6 product;
  product << a, alpha;
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

JointVector Chain::inverse_dynamics(const JointVector& q, const JointVector& dq, const JointVector& ddq,
                                    const Eigen::Vector3d& gravity_B, const Payload& payload) const {
  Rotations R;
  Vectors p, force, moment;
  relative(q, R, p);

  // Outwards: velocity and acceleration of each frame in its own axes. The base accelerates against gravity, which
  // loads every body with its weight.
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
  Eigen::Vector3d alpha = Eigen::Vector3d::Zero();
  Eigen::Vector3d a = -gravity_B;
  for (int i = 0; i < count_; ++i) {
    const auto k = static_cast<std::size_t>(i);
    a = (R[k].transpose() * (a + cross(alpha, p[k]) + cross(w, cross(w, p[k])))).eval();
    w = (R[k].transpose() * w).eval();
    alpha = (R[k].transpose() * alpha).eval();
    if (segments_[k].prismatic) {
      a -= 2.0 * dq[i] * z_cross(w);  // 2 w x (z dq) = -2 dq (z x w)
      a.z() += ddq[i];
    } else {
      alpha -= dq[i] * z_cross(w);
      alpha.z() += ddq[i];
      w.z() += dq[i];
    }
    SpatialInertia body = segments_[k].body;
    if (i + 1 == count_ && payload.mass > 0.0) body += payload_body(payload);
    force[k] = body.mass * a + cross(alpha, body.h) + cross(w, cross(w, body.h));
    moment[k] = body.I * alpha + cross(w, body.I * w) + cross(body.h, a);
  }

  // Inwards: what each joint must carry; its own share is the component along the axis.
  JointVector tau(count_);
  for (int i = count_ - 1; i >= 0; --i) {
    const auto k = static_cast<std::size_t>(i);
    tau[i] = segments_[k].prismatic ? force[k].z() : moment[k].z();
    if (i == 0) break;
    const Eigen::Vector3d f = R[k] * force[k];
    force[k - 1] += f;
    moment[k - 1] += R[k] * moment[k] + cross(p[k], f);
  }
  return tau;
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
