#include "core/collision/motion_samples.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace takt::collision {
namespace {

constexpr double kSampleStep = 4e-3;  // s: fine enough that few pairs need more
constexpr int kMostSamples = 4000;
constexpr double kLongStep = 4.0 * kSampleStep;  // s: of a motion of more than a minute

}  // namespace

MotionSamples::MotionSamples(const Scene& scene, const State& state, const Trajectory& motion)
    : scene_(scene), motion_(motion), state_(state) {
  scene.place(state, poses_);
  const double steps = std::ceil(motion.duration / kSampleStep);
  count_ = std::clamp(static_cast<int>(steps), 1, kMostSamples);
  row_of_.resize(scene.bodies().size(), -1);
  const std::vector<bool> moved = scene.moved_by(state, motion.joints);
  for (const int body : scene.parents_first(state)) {
    if (!moved[static_cast<std::size_t>(body)]) continue;
    row_of_[static_cast<std::size_t>(body)] = static_cast<int>(order_.size());
    order_.push_back(body);
  }
  q_.assign(static_cast<std::size_t>(count_ + 1), state.q);
  for (int k = 0; k <= count_; ++k) motion.at(time(k), joints(k));
  find_curvature();
  sample();
}

void MotionSamples::put_all(double time, std::vector<double>& q) {
  motion_.at(time, q);
  scene_.place_some({.q = q, .fixings = state_.fixings}, order_, poses_);
}

/// Where the point is moves, and what it is seen from moves it as a point of its own would be that is there.
double MotionSamples::travel_seen_from(int other, int body, int k) const {
  const Body &seen = scene_.body(body), &from = scene_.body(other);
  const Eigen::Isometry3d X_WB = pose(body, k), X_WO = pose(other, k);
  const double furthest = (X_WB * seen.box.center() - X_WO * from.box.center()).norm() + seen.radius;
  return between(body, k, X_WB, pose(body, k + 1), step()) +
         between(other, k, X_WO, pose(other, k + 1), step(), std::max(0.0, furthest - from.radius));
}

double MotionSamples::between(int body, int k, const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, double apart,
                              double beyond) const {
  const int row = row_of_[static_cast<std::size_t>(body)];
  if (row < 0) return 0.0;
  const Body& one = scene_.body(body);
  const Eigen::Vector3d middle = one.box.center();
  const double shift = (to * middle - from * middle).norm();
  // By how much a turn moves a point at distance 1: 2 sin(angle / 2), from the nine differences.
  const double turn = (to.linear() - from.linear()).norm() / std::numbers::sqrt2;
  // The chord, and twice by how much the path of any point can leave it: away from one end and from the other.
  const std::size_t of_step = bend_.size() > order_.size() ? order_.size() * static_cast<std::size_t>(k) : 0;
  const Bend& bend = bend_[of_step + static_cast<std::size_t>(row)];
  return shift + (one.radius + beyond) * turn + (bend.inside + beyond * bend.beyond) * apart * apart / 4.0;
}

std::vector<double> MotionSamples::q_at(double time) const {
  std::vector<double> q = state_.q;
  motion_.at(time, q);
  return q;
}

void MotionSamples::find_curvature() {
  const std::vector<double> levers = find_levers();
  std::vector<double> acceleration = motion_.acceleration;
  if (!motion_.acceleration_between || step() <= kLongStep)
    return add_curvature(levers, acceleration, fastest_joints(1, count_, acceleration));
  for (int k = 1; k <= count_; ++k) {
    motion_.acceleration_between(time(k - 1), time(k), acceleration);
    add_curvature(levers, acceleration, fastest_joints(k, k, acceleration));
  }
}

std::vector<double> MotionSamples::find_levers() const {
  std::vector<double> levers;
  levers.reserve(order_.size() * motion_.joints.size());
  for (const int body : order_)
    for (const int joint : motion_.joints) levers.push_back(lever_of(body, joint));
  return levers;
}

void MotionSamples::add_curvature(const std::vector<double>& levers, const std::vector<double>& acceleration,
                                  const std::vector<double>& fastest) {
  auto lever = levers.begin();
  for (std::size_t row = 0; row < order_.size(); ++row) {
    double speed = 0.0, turn = 0.0, push = 0.0, turn_push = 0.0;
    for (std::size_t j = 0; j < motion_.joints.size(); ++j, ++lever) {
      if (*lever < 0.0) continue;
      const Body& mover = scene_.body(body_of(motion_.joints[j]));
      const double arm = mover.prismatic ? 1.0 : *lever;
      push += arm * acceleration[j];
      speed += arm * fastest[j];
      if (mover.prismatic) continue;
      turn += fastest[j];
      turn_push += acceleration[j];
    }
    bend_.push_back({push + 2.0 * turn * speed, turn_push + 2.0 * turn * turn});
  }
}

std::vector<double> MotionSamples::fastest_joints(int first_step, int last_step,
                                                  const std::vector<double>& acceleration) const {
  std::vector<double> fastest(motion_.joints.size(), 0.0);
  if (motion_.duration <= 0.0) return fastest;
  for (int k = first_step; k <= last_step; ++k) {
    for (std::size_t j = 0; j < motion_.joints.size(); ++j) {
      const auto joint = static_cast<std::size_t>(motion_.joints[j]);
      fastest[j] = std::max(fastest[j], std::abs(joints(k)[joint] - joints(k - 1)[joint]) / step());
    }
  }
  for (std::size_t j = 0; j < fastest.size(); ++j) fastest[j] += acceleration[j] * step();
  return fastest;
}

int MotionSamples::body_of(int joint) const {
  const auto& bodies = scene_.bodies();
  return static_cast<int>(std::ranges::find(bodies, joint, &Body::joint) - bodies.begin());
}

int MotionSamples::parent_of(int body) const {
  return scene_.body(body).root ? state_.fixings[static_cast<std::size_t>(body)].parent : scene_.body(body).parent;
}

double MotionSamples::lever_of(int body, int joint) const {
  const Body& outer = scene_.body(body);
  double length = outer.radius + outer.box.center().norm();
  for (int at = body; at >= 0; at = parent_of(at)) {
    const Body& one = scene_.body(at);
    if (one.joint == joint) return length;
    const Eigen::Isometry3d& X = one.root ? state_.fixings[static_cast<std::size_t>(at)].X_P : one.X_PJ;
    length += X.translation().norm();
    if (one.prismatic && one.joint >= 0) length += range_of(one.joint);
  }
  return -1.0;
}

double MotionSamples::range_of(int joint) const {
  const auto number = static_cast<std::size_t>(joint);
  double most = std::abs(state_.q[number]);
  if (std::ranges::find(motion_.joints, joint) == motion_.joints.end()) return most;
  for (const std::vector<double>& q : q_) most = std::max(most, std::abs(q[number]));
  return most;
}

void MotionSamples::sample() {
  sampled_.resize(order_.size() * static_cast<std::size_t>(count_ + 1));
  travel_.assign(sampled_.size(), 0.0);
  State state = state_;
  for (int k = 0; k <= count_; ++k) {
    state.q = joints(k);
    scene_.place_some(state, order_, poses_);
    for (std::size_t row = 0; row < order_.size(); ++row) {
      const std::size_t now = index(static_cast<int>(row), k);
      sampled_[now] = poses_[static_cast<std::size_t>(order_[row])];
      if (k == 0) continue;
      travel_[now] = travel_[now - 1] + between(order_[row], k - 1, sampled_[now - 1], sampled_[now], step());
    }
  }
}

}  // namespace takt::collision
