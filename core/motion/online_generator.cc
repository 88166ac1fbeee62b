#include "core/motion/online_generator.h"

#include <algorithm>
#include <cmath>

#include <ruckig/ruckig.hpp>

namespace takt::motion {
namespace {

using kinematics::kMaxJoints;

bool within(const JointVector& v, double least, double most) {
  return v.size() > 0 && v.allFinite() && v.minCoeff() >= least && v.maxCoeff() <= most;
}

ruckig::Synchronization synchronization_of(OnlineGenerator::Synchronization how) {
  if (how == OnlineGenerator::Synchronization::kNone) return ruckig::Synchronization::None;
  return how == OnlineGenerator::Synchronization::kPhase ? ruckig::Synchronization::Phase
                                                         : ruckig::Synchronization::Time;
}

}  // namespace

/// One interface for both sizes: a single axis takes a fraction of the time of an array with eleven axes left out.
struct OnlineGenerator::Impl {
  explicit Impl(int axes) : axes_(axes) { state.q = state.dq = state.ddq = JointVector::Zero(axes); }
  virtual ~Impl() = default;
  virtual Status follow(ruckig::ControlInterface interface, const JointVector& target,
                        const JointVector& target_velocity, const Limits& limits, double period) = 0;
  /// The next cycle computes anew.
  virtual void forget() = 0;

  const int axes_;
  State state;
  double time_left = 0.0;
};

namespace {

/// Profiles of at most `capacity` axes, in memory of fixed size.
template <std::size_t capacity>
class Solver final : public OnlineGenerator::Impl {
 public:
  using Status = OnlineGenerator::Status;

  Solver(int axes, ruckig::Synchronization synchronization) : Impl(axes) {
    input_.synchronization = synchronization;
    for (std::size_t i = 0; i < capacity; ++i) {
      input_.enabled[i] = static_cast<int>(i) < axes;
      input_.max_velocity[i] = input_.max_acceleration[i] = input_.max_jerk[i] = 1.0;
      for (auto* values : {&input_.current_position, &input_.current_velocity, &input_.current_acceleration,
                           &input_.target_position, &input_.target_velocity, &input_.target_acceleration})
        (*values)[i] = 0.0;
    }
  }

  void forget() override { planned_ = false; }

  Status follow(ruckig::ControlInterface interface, const JointVector& target, const JointVector& target_velocity,
                const OnlineGenerator::Limits& limits, double period) override {
    if (take(interface, target, target_velocity, limits) || !planned_) {
      planned_ = plan();
      if (!planned_) return Status::kNoSolution;
    }
    time_ += period;
    sample();
    time_left = std::max(0.0, trajectory_.get_duration() - time_);
    if (time_left > 0.0) return Status::kMoving;
    arrive(interface);
    return Status::kArrived;
  }

 private:
  using Axes = std::array<double, capacity>;

  /// @return whether anything differs from the last cycle.
  bool take(ruckig::ControlInterface interface, const JointVector& target, const JointVector& target_velocity,
            const OnlineGenerator::Limits& limits) {
    bool changed = input_.control_interface != interface;
    input_.control_interface = interface;
    if (interface == ruckig::ControlInterface::Position) {
      changed |= copy(target, input_.target_position);
      changed |= copy(limits.velocity, input_.max_velocity);
    }
    changed |= copy(target_velocity, input_.target_velocity);
    changed |= copy(limits.acceleration, input_.max_acceleration);
    changed |= copy(limits.jerk, input_.max_jerk);
    return changed;
  }

  bool plan() {
    copy(state.q, input_.current_position);
    copy(state.dq, input_.current_velocity);
    copy(state.ddq, input_.current_acceleration);
    time_ = 0.0;
    return solver_.calculate(input_, trajectory_) == ruckig::Result::Working;
  }

  void sample() {
    Axes q, dq, ddq;
    trajectory_.at_time(time_, q, dq, ddq);
    for (int i = 0; i < axes_; ++i) {
      const auto k = static_cast<std::size_t>(i);
      state.q[i] = q[k];
      state.dq[i] = dq[k];
      state.ddq[i] = ddq[k];
    }
  }

  /// The end of a profile is right to rounding only; a target at rest is reached, and then kept, bit for bit.
  void arrive(ruckig::ControlInterface interface) {
    for (int i = 0; i < axes_; ++i) {
      const auto k = static_cast<std::size_t>(i);
      state.dq[i] = input_.target_velocity[k];
      state.ddq[i] = 0.0;
      if (interface == ruckig::ControlInterface::Position && input_.target_velocity[k] == 0.0)
        state.q[i] = input_.target_position[k];
    }
  }

  static bool copy(const JointVector& from, Axes& to) {
    bool changed = false;
    for (Eigen::Index i = 0; i < from.size(); ++i) {
      double& place = to[static_cast<std::size_t>(i)];
      changed |= place != from[i];
      place = from[i];
    }
    return changed;
  }

  ruckig::Ruckig<capacity> solver_;
  ruckig::InputParameter<capacity> input_;
  ruckig::Trajectory<capacity> trajectory_;
  bool planned_ = false;
  double time_ = 0.0;  ///< since the newest plan, s
};

}  // namespace

OnlineGenerator::OnlineGenerator(int axes, Synchronization synchronization) {
  const ruckig::Synchronization how = synchronization_of(synchronization);
  if (axes == 1) {
    impl_ = std::make_unique<Solver<1>>(axes, how);
  } else {
    impl_ = std::make_unique<Solver<kMaxJoints>>(axes, how);
  }
}
OnlineGenerator::~OnlineGenerator() = default;
OnlineGenerator::OnlineGenerator(OnlineGenerator&&) noexcept = default;
OnlineGenerator& OnlineGenerator::operator=(OnlineGenerator&&) noexcept = default;

void OnlineGenerator::start(const State& state) {
  impl_->state = state;
  impl_->time_left = 0.0;
  impl_->forget();
}

OnlineGenerator::Status OnlineGenerator::follow_position(const JointVector& target, const JointVector& target_velocity,
                                                         const Limits& limits, double period) {
  const int n = impl_->axes_;
  const bool sizes = target.size() == n && target_velocity.size() == n && limits.velocity.size() == n &&
                     limits.acceleration.size() == n && limits.jerk.size() == n;
  const bool fine = sizes && within(target, -kMost, kMost) && within(limits.velocity, kLeast, kMost) &&
                    within(limits.acceleration, kLeast, kMost) && within(limits.jerk, kLeast, kMost) &&
                    (target_velocity.array().abs() <= limits.velocity.array()).all();
  if (!fine) return Status::kBadInput;
  return impl_->follow(ruckig::ControlInterface::Position, target, target_velocity, limits, period);
}

OnlineGenerator::Status OnlineGenerator::follow_velocity(const JointVector& target, const Limits& limits,
                                                         double period) {
  const int n = impl_->axes_;
  const bool sizes = target.size() == n && limits.acceleration.size() == n && limits.jerk.size() == n;
  const bool fine = sizes && within(target, -kMost, kMost) && within(limits.acceleration, kLeast, kMost) &&
                    within(limits.jerk, kLeast, kMost);
  if (!fine) return Status::kBadInput;
  return impl_->follow(ruckig::ControlInterface::Velocity, target, target, limits, period);
}

const OnlineGenerator::State& OnlineGenerator::state() const { return impl_->state; }
double OnlineGenerator::time_left() const { return impl_->time_left; }

}  // namespace takt::motion
