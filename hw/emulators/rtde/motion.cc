#include "hw/emulators/rtde/motion.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/motion/rotation_vector.h"

namespace takt::hw::rtde {

namespace {

constexpr double kLedSpeed = 0.25, kLedTurn = 1.0;  // m/s and rad/s, at which a hand may lead the tool

constexpr double kAtRest = 1e-6;                          // rad/s
constexpr double kServoAcceleration = 60.0;               // rad/s^2: what servoj() may ask of the joints
constexpr double kServoGain = 300.0;                      // to which the lag of servoj() refers
constexpr double kShortest = 1e-9;                        // m or rad: a move without length
constexpr double kJerkTime = 0.05;                        // s, in which a move reaches its acceleration
constexpr double kForceGain = 0.002, kTorqueGain = 0.02;  // m/s per N and rad/s per Nm of a compliant axis
constexpr double kForceTime = 0.05;                       // s, filter of the velocity of compliant axes
constexpr int kLimitSamples = 64;

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};

/// On which circle the three points lie: centre, unit normal in the sense of the way, angle to the last one.
struct Circle {
  Eigen::Vector3d centre, normal;
  double arc = 0.0;
};
std::optional<Circle> circle_through(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d u = b - a, v = c - a, n = u.cross(v);
  if (n.norm() < 1e-9) return std::nullopt;
  const double uu = u.squaredNorm(), vv = v.squaredNorm();
  Circle circle;
  circle.centre = a + (vv * n.cross(u) + uu * v.cross(n)) / (2.0 * n.squaredNorm());
  circle.normal = n.normalized();
  const Eigen::Vector3d x = (a - circle.centre).normalized(), y = circle.normal.cross(x), to = c - circle.centre;
  circle.arc = std::atan2(to.dot(y), to.dot(x));
  if (circle.arc <= 0.0) circle.arc += 2.0 * M_PI;
  return circle;
}

}  // namespace

ForceTask led_by_hand() {
  ForceTask task;
  task.in_tool_axes = true;
  task.compliant.fill(true);
  task.limits.head<3>().setConstant(kLedSpeed);
  task.limits.tail<3>().setConstant(kLedTurn);
  return task;
}

Motion::Motion(std::shared_ptr<const device::ArmDescription> arm, double period)
    : kinematics_(arm), limits_(arm->limits), period_(period) {
  rest_at(arm->home);
}

bool Motion::at_rest() const { return dq_.cwiseAbs().maxCoeff() < kAtRest; }

bool Motion::commands_rest() const { return (dq_ - force_dq_).cwiseAbs().maxCoeff() < kAtRest; }

void Motion::rest_at(const JointVector& q) {
  q_ = q;
  dq_ = force_dq_ = offset_ = JointVector::Zero(q.size());
  activity_ = Idle{};
  tracks_.clear();
  waiting_.reset();
  force_task_.reset();
  rate_ = 1.0;
}

// -- Moves
// -------------------------------------------------------------------------------------------------------------

std::optional<std::string> Motion::move(const MoveRequest& request) {
  const bool blends = !tracks_.empty() && std::holds_alternative<Idle>(activity_);
  if (!blends && !commands_rest()) {
    stop(std::max(request.acceleration, kDeceleration));
    waiting_ = request;
    return std::nullopt;
  }
  return begin(request);
}

std::optional<std::string> Motion::begin(const MoveRequest& request) {
  fold();
  Track track;
  if (auto problem = plan(request, track)) return problem;
  activity_ = Idle{};
  tracks_.push_back(std::move(track));
  return std::nullopt;
}

bool Motion::move_done() const {
  if (waiting_) return false;
  return tracks_.empty() || tracks_.back().time >= tracks_.back().blend_time;
}

std::optional<std::string> Motion::plan(const MoveRequest& request, Track& track) const {
  track.q = tracks_.empty() ? q_ : tracks_.back().q_goal;
  const Eigen::Isometry3d from = kinematics_.X_BT(track.q);
  const double angle = motion::log_rotation(from.linear().transpose() * request.X_BT_goal.linear()).norm();
  switch (request.kind) {
    case MoveRequest::Kind::kJoints:
      plan_joints(request, track);
      break;
    case MoveRequest::Kind::kLine: {
      track.geometry = motion::CartesianLine::between(from, request.X_BT_goal);
      plan_tool(request, track, (request.X_BT_goal.translation() - from.translation()).norm(), angle);
      break;
    }
    case MoveRequest::Kind::kArc: {
      const auto circle =
          circle_through(from.translation(), request.X_BT_via.translation(), request.X_BT_goal.translation());
      if (!circle) return "the three points of the arc lie on a line";
      const auto turn =
          motion::short_turn(Eigen::Quaterniond(from.linear()), Eigen::Quaterniond(request.X_BT_goal.linear()));
      track.geometry = motion::CartesianArc{.p_start = from.translation(),
                                            .R_start = Eigen::Quaterniond(from.linear()),
                                            .centre = circle->centre,
                                            .normal = circle->normal,
                                            .arc = circle->arc,
                                            .axis = turn.axis,
                                            .angle = turn.angle,
                                            .held_start = {},
                                            .held_goal = {}};
      plan_tool(request, track, circle->arc * (from.translation() - circle->centre).norm(), turn.angle);
      break;
    }
  }
  if (!stretch_to_limits(track)) return "the way is out of reach, or leads through a singular posture";
  return std::nullopt;
}

void Motion::plan_joints(const MoveRequest& request, Track& track) const {
  track.geometry = motion::JointLine{track.q, request.q_goal};
  const JointVector way = (request.q_goal - track.q).cwiseAbs();
  const double longest = way.maxCoeff();
  if (longest < kShortest) return;
  motion::RateLimits rates{request.velocity / longest, request.acceleration / longest, 1e9};
  for (int i = 0; i < way.size(); ++i) {
    if (way[i] < kShortest) continue;
    rates.velocity = std::min(rates.velocity, limits_.velocity[i] / way[i]);
    rates.acceleration = std::min(rates.acceleration, limits_.acceleration[i] / way[i]);
    rates.jerk = std::min(rates.jerk, limits_.jerk[i] / way[i]);
  }
  track.law = motion::TimeLaw::rest_to_rest(rates);
  if (request.time > track.law.duration()) track.law = track.law.stretched(request.time / track.law.duration());
  const double length =
      (kinematics_.X_BT(request.q_goal).translation() - kinematics_.X_BT(track.q).translation()).norm();
  track.blend_time = time_of_blend(track, length, request.blend_radius);
}

void Motion::plan_tool(const MoveRequest& request, Track& track, double length, double angle) const {
  const double longest = std::max(length, angle);
  if (longest < kShortest) return;
  const motion::CartesianLimits& most = kinematics_.arm().cartesian;
  motion::RateLimits rates{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), 1e9};
  // Speeds count for the way of the tool, or, where it only turns, for its angle.
  const double leading = length > kShortest ? length : angle;
  rates.velocity = std::min(request.velocity / leading, most.angular_velocity / std::max(angle, kShortest));
  rates.acceleration = std::min(request.acceleration / leading, most.angular_acceleration / std::max(angle, kShortest));
  rates.jerk = rates.acceleration / kJerkTime;
  track.law = motion::TimeLaw::rest_to_rest(rates);
  if (request.time > 0.0) track.law = track.law.stretched(request.time / track.law.duration());
  track.blend_time = time_of_blend(track, length, request.blend_radius);
}

/// When what is left of the way is the radius; at most half of the move is blended.
double Motion::time_of_blend(const Track& track, double length, double radius) const {
  double time = track.law.duration();
  if (radius <= 0.0 || length <= kShortest) return time;
  const double s = std::max(0.5, 1.0 - radius / length);
  while (time > 0.0 && track.law.at(time).s > s) time -= period_;
  return std::max(time, 0.0);
}

/// Walks through the move; where a joint would be too fast, all of it is slowed down. @return false: not reachable
bool Motion::stretch_to_limits(Track& track) const {
  const double duration = track.law.duration();
  track.q_goal = track.q;
  JointVector before = track.q, q = track.q;
  double factor = 1.0;
  for (int i = 1; i <= kLimitSamples; ++i) {
    if (!sample(track, duration * i / kLimitSamples, q)) return false;
    const JointVector share =
        (q - before).cwiseAbs().cwiseQuotient(limits_.velocity) * (kLimitSamples / std::max(duration, period_));
    factor = std::max(factor, share.maxCoeff());
    before = q;
  }
  track.q_goal = q;
  if (factor > 1.0) {
    track.law = track.law.stretched(factor);
    track.blend_time *= factor;
  }
  if (track.blend_time <= 0.0) track.blend_time = track.law.duration();
  return true;
}

/// @param[in,out] q  in: the seed, a place before it on the way
bool Motion::sample(const Track& track, double time, JointVector& q) const {
  const motion::LawPoint law = track.law.at(time);
  const motion::PathPoint at{law.s, law.ds, law.dds};
  return std::visit(Overloaded{[&](const motion::JointLine& line) {
                                 q = line.sample(at).q;
                                 return true;
                               },
                               [&](const auto& curve) { return kinematics_.solve(curve.sample(at).X_BM, q); }},
                    track.geometry);
}

bool Motion::advance(Track& track, double time) const {
  track.time = std::min(track.time + time, track.law.duration());
  return sample(track, track.time, track.q);
}

/// The newest move, and what is left of those that are blended out. @return false: it leads nowhere
bool Motion::step_tracks(double time, JointVector& q) {
  for (Track& track : tracks_)
    if (!advance(track, time)) return false;
  q = tracks_.back().q;
  for (std::size_t i = 0; i + 1 < tracks_.size(); ++i) q += tracks_[i].q - tracks_[i].q_goal;
  std::erase_if(tracks_, [this](const Track& track) { return &track != &tracks_.back() && track.over(); });
  return true;
}

// -- Other commands
// ----------------------------------------------------------------------------------------------------

void Motion::servo(const JointVector& goal, double lookahead, double gain) {
  const double lag = std::clamp(lookahead, 0.03, 0.2) * kServoGain / std::clamp(gain, 100.0, 2000.0);
  tracks_.clear();
  waiting_.reset();
  activity_ = Servo{goal, 1.0 - std::exp(-period_ / lag)};
}

void Motion::speed_joints(const JointVector& dq, double acceleration) {
  tracks_.clear();
  waiting_.reset();
  activity_ = Speed{dq, std::max(acceleration, 1e-3)};
}

void Motion::speed_tool(const Vector6& V_BT_B, double acceleration) {
  tracks_.clear();
  waiting_.reset();
  activity_ = ToolSpeed{V_BT_B, std::max(acceleration, 1e-3)};
}

void Motion::stop(double deceleration) {
  const double fastest = dq_.cwiseAbs().maxCoeff();
  begin_stop(fastest < kAtRest ? 1.0 : std::max(deceleration, 1e-3) * period_ / fastest);
}

void Motion::stop_tool(double deceleration) {
  const double speed = kinematics_.twist(q_, dq_).head<3>().norm();
  // A tool that only turns brakes as its joints do.
  if (speed < 1e-4) return stop(kDeceleration);
  begin_stop(std::max(deceleration, 1e-3) * period_ / speed);
}

void Motion::begin_stop(double share) {
  tracks_.clear();
  waiting_.reset();
  // No faster than the joints can.
  for (int i = 0; i < dq_.size(); ++i)
    if (std::abs(dq_[i]) > kAtRest) share = std::min(share, 4.0 * limits_.acceleration[i] * period_ / std::abs(dq_[i]));
  activity_ = Stop{share, dq_};
}

/// The velocity of a task that ends fades out.
void Motion::set_force_task(const std::optional<ForceTask>& task) { force_task_ = task; }

/// What compliance has added becomes part of the position.
void Motion::fold() {
  if (tracks_.empty()) offset_.setZero();
}

// -- The cycle
// ---------------------------------------------------------------------------------------------------------

std::optional<std::string> Motion::step(double speed, const Vector6& wrench_B) {
  if (waiting_ && commands_rest()) {
    const MoveRequest request = *std::exchange(waiting_, std::nullopt);
    if (auto problem = begin(request)) return problem;
  }
  const JointVector before = q_;
  // The time of moves changes its rate no faster than joints at full speed may brake.
  const double most = period_ * (limits_.acceleration.cwiseQuotient(limits_.velocity)).minCoeff();
  const double wanted = halted_ ? 0.0 : speed;
  rate_ = tracks_.empty() ? wanted : rate_ + std::clamp(wanted - rate_, -most, most);
  if (!tracks_.empty()) {
    JointVector q = q_ - offset_;
    if (!step_tracks(rate_ * period_, q)) {
      stop(kDeceleration);
      return "the arm cannot follow the path there";
    }
    q_ = q + offset_;
    if (tracks_.size() == 1 && tracks_.back().over()) tracks_.clear();
  } else {
    q_ += period_ * next_velocity(speed);
  }
  step_force(wrench_B);
  dq_ = (q_ - before) / period_;
  if (auto problem = check()) {
    q_ = before;
    stop(kDeceleration);
    dq_.setZero();
    return problem;
  }
  return std::nullopt;
}

JointVector Motion::next_velocity(double speed) {
  const JointVector base = dq_ - force_dq_;
  if (halted_ && !std::holds_alternative<Idle>(activity_) && !std::holds_alternative<Stop>(activity_))
    return towards(JointVector::Zero(base.size()), limits_.acceleration.minCoeff());
  return std::visit(
      Overloaded{[&](const Idle&) { return JointVector(JointVector::Zero(base.size())); },
                 [&](const Servo& servo) { return servo_velocity(servo); },
                 [&](const Speed& command) { return towards(limited(speed * command.dq), command.acceleration); },
                 [&](const ToolSpeed& command) {
                   const JointVector goal = limited(kinematics_.rates(q_, speed * command.V_BT_B));
                   const double tool = std::max(kinematics_.twist(q_, goal - base).head<3>().norm(), 1e-9);
                   const double share = std::min(1.0, command.acceleration * period_ / tool);
                   return JointVector(base + share * (goal - base));
                 },
                 [&](Stop& command) {
                   // A joint that stood when the stop began loses what else moves it.
                   JointVector lost = command.share * command.dq;
                   JointVector next = base;
                   for (int i = 0; i < next.size(); ++i) {
                     if (std::abs(command.dq[i]) < kAtRest)
                       lost[i] = std::copysign(period_ * limits_.acceleration[i], base[i]);
                     next[i] = std::abs(lost[i]) >= std::abs(base[i]) ? 0.0 : base[i] - lost[i];
                   }
                   return next;
                 }},
      activity_);
}

JointVector Motion::servo_velocity(const Servo& servo) const {
  const JointVector want = limited(servo.share / period_ * (servo.goal - q_));
  return towards(want, kServoAcceleration);
}

/// All joints change their velocity in proportion; the fastest change is the acceleration.
JointVector Motion::towards(const JointVector& dq, double acceleration) const {
  const JointVector base = dq_ - force_dq_, change = dq - base;
  const double most = change.cwiseAbs().maxCoeff();
  const double share = most <= acceleration * period_ ? 1.0 : acceleration * period_ / most;
  return base + share * change;
}

/// In proportion, so that no joint is faster than its limit.
JointVector Motion::limited(JointVector dq) const {
  const double share = dq.cwiseAbs().cwiseQuotient(limits_.velocity).maxCoeff();
  if (share > 1.0) dq /= share;
  return dq;
}

/// The velocity with which a compliant axis gives way.
JointVector Motion::force_velocity(const ForceTask& task, const Vector6& wrench_B) const {
  const Eigen::Matrix3d R = task.in_tool_axes ? kinematics_.X_BT(q_).linear().eval() : task.X_BTask.linear().eval();
  Vector6 V_Task, V_B;
  Vector6 felt;
  felt << R.transpose() * wrench_B.head<3>(), R.transpose() * wrench_B.tail<3>();
  for (int i = 0; i < 6; ++i) {
    const double gain = task.gain * (i < 3 ? kForceGain : kTorqueGain);
    // What the tool exerts is the opposite of what it feels.
    const double wanted = gain * (task.wrench[i] + felt[i]);
    V_Task[i] = task.compliant[static_cast<std::size_t>(i)] ? std::clamp(wanted, -task.limits[i], task.limits[i]) : 0.0;
  }
  V_B << R * V_Task.head<3>(), R * V_Task.tail<3>();
  return limited(kinematics_.rates(q_, V_B));
}

void Motion::step_force(const Vector6& wrench_B) {
  JointVector want = JointVector::Zero(q_.size());
  if (force_task_ && !halted_) want = force_velocity(*force_task_, wrench_B);
  force_dq_ += std::min(1.0, period_ / kForceTime) * (want - force_dq_);
  if (want.isZero() && force_dq_.cwiseAbs().maxCoeff() < kAtRest) force_dq_.setZero();
  q_ += period_ * force_dq_;
  offset_ += period_ * force_dq_;
}

std::optional<std::string> Motion::check() const {
  for (int i = 0; i < q_.size(); ++i)
    if (q_[i] < limits_.lower[i] || q_[i] > limits_.upper[i])
      return fmt::format("joint {} is at {:.4f} rad, outside of its range {:.4f} to {:.4f}", i, q_[i], limits_.lower[i],
                         limits_.upper[i]);
  if (!q_.allFinite()) return "a position that is not finite";
  return std::nullopt;
}

}  // namespace takt::hw::rtde
