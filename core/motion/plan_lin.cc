#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/kinematics/inverse.h"
#include "core/kinematics/solutions.h"
#include "core/motion/clock_bounds.h"
#include "core/motion/line_walk.h"
#include "core/motion/plan_checks.h"
#include "core/motion/planner.h"

namespace takt::motion {
namespace {

using kinematics::Chain;
using kinematics::InverseKinematics;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What one quantity may do in the law: a joint, the way along the line, or the turn about its axis.
struct Channel {
  double velocity;
  double acceleration;
  double jerk;
};

/// A planned law seen as loads on the channels: joints first, then way and turn.
struct LawLoads {
  /// Absolute derivatives by path time at one instant, one entry per channel.
  using Loads = Eigen::Array<double, Eigen::Dynamic, 1, Eigen::ColMajor, kinematics::kMaxJoints + 2, 1>;
  struct Instant {
    Loads first, second, third;
  };
  TimeLaw law;
  std::vector<Instant> instants;
};

Motion standing(const CartesianLine& line, const JointVector& q) {
  return {.path = line, .law = {}, .clock = {}, .q_start = q, .q_goal = q};
}

/// Plans one line; the steps are called in order by plan_lin.
class LinePlanner {
 public:
  LinePlanner(const Chain& chain, const InverseKinematics& inverse, const JointLimits& limits,
              const CartesianLimits& cartesian, const MotionOptions& options)
      : chain_(chain), inverse_(inverse), limits_(limits), options_(options) {
    for (int i = 0; i < chain.joint_count(); ++i) {
      channels_.push_back(
          {kLawShareOfVelocity * limits.velocity[i] * options.velocity, limits.acceleration[i], limits.jerk[i]});
    }
    const double speed =
        std::min(cartesian.linear_velocity * options.velocity, options.linear_velocity.value_or(kInfinity));
    channels_.push_back({kLawShareOfVelocity * speed, cartesian.linear_acceleration, cartesian.linear_jerk});
    channels_.push_back(
        {cartesian.angular_velocity * options.velocity, cartesian.angular_acceleration, cartesian.angular_jerk});
  }

  Result<Motion> plan(const CartesianLine& line, const JointVector& q_start) {
    line_ = line;
    Motion motion = standing(line, q_start);
    // Coarse first; finer until the joint path is known well enough at the speed that it will be run with.
    constexpr int kCoarse = 32;
    constexpr int kFine = 1024;
    for (int steps = kCoarse;; steps *= 2) {
      walk_ = walk_line(inverse_, line_, options_.X_FM, q_start, steps);
      Findings findings = check_walk();
      if (findings.has_errors()) return std::unexpected(std::move(findings));
      const LawLoads best = fastest_law();
      if (!known_well_enough(best) && steps < kFine) continue;
      motion.q_goal = walk_.nodes.back().q;
      motion.law = best.law;
      motion.clock = clock_for(best);
      return motion;
    }
  }

 private:
  /// Ways of the channels over the whole line that are known beforehand: metres and radians.
  [[nodiscard]] double way() const { return line_.length; }
  [[nodiscard]] double turn() const { return line_.angle; }

  Findings check_walk() const {
    Findings findings;
    check_ranges(findings);
    if (walk_.end != WalkEnd::kGoal) explain_end(findings);
    return findings;
  }

  /// One finding per joint: where it first leaves its range.
  void check_ranges(Findings& findings) const {
    for (int i = 0; i < chain_.joint_count(); ++i) {
      for (std::size_t n = 0; n < walk_.nodes.size(); ++n) {
        const double q = walk_.nodes[n].q[i];
        if (q >= limits_.lower[i] - kRangeTolerance && q <= limits_.upper[i] + kRangeTolerance) continue;
        range_finding(chain_, limits_, i, q, "/goal", fmt::format(" at {:.0f} % of the line", 100 * walk_.s(n)),
                      findings);
        break;
      }
    }
  }

  void explain_end(Findings& findings) const {
    const std::string place = fmt::format("at {:.1f} % of the line", 100 * walk_.s_end);
    const double left = (1.0 - walk_.s_end) * way() * 1e3;
    kinematics::SolutionOptions search;
    search.reference = walk_.nodes.empty() ? JointVector() : walk_.nodes.front().q;
    const Eigen::Isometry3d X_BF = line_.sample({.s = 1.0}).X_BM * options_.X_FM.inverse();
    const auto solutions = inverse_solutions(chain_, X_BF, search);
    if (solutions.empty()) {
      findings.error("/goal",
                     fmt::format("the goal is out of reach: the arm follows {}, {:.1f} mm before the goal",
                                 fmt::format("to {:.1f} % of the line", 100 * walk_.s_end), left),
                     "a goal nearer to the base, or another orientation");
      return;
    }
    switch (walk_.end) {
      case WalkEnd::kSingular:
        findings.error(
            "/goal", fmt::format("the line comes too near to a singularity {} (measure {:.4f})", place, walk_.measure),
            fmt::format("a measure of at least {}; another line, or PTP", kSingularityLeast));
        break;
      case WalkEnd::kOtherBranch:
        findings.error("/goal",
                       fmt::format("the line would change to another branch of the inverse kinematics {}", place),
                       "another line, another start configuration, or PTP");
        break;
      default:
        findings.error("/goal", fmt::format("the arm cannot follow {} in the configuration of the start", place),
                       "the goal is reachable in another configuration: PTP");
    }
  }

  /// Derivatives of all channels by path time under `law`.
  LawLoads loads(TimeLaw law) const {
    LawLoads result{.law = std::move(law), .instants = {}};
    const int n = chain_.joint_count();
    for (const LawPoint& at : instants(result.law)) {
      const LineWalk::Derivatives d = walk_.derivatives(at.s);
      LawLoads::Instant load{LawLoads::Loads(n + 2), LawLoads::Loads(n + 2), LawLoads::Loads(n + 2)};
      load.first.head(n) = (d.first * at.ds).array().abs();
      load.second.head(n) = (d.second * (at.ds * at.ds) + d.first * at.dds).array().abs();
      load.third.head(n) =
          (d.third * (at.ds * at.ds * at.ds) + d.second * (3 * at.ds * at.dds) + d.first * at.ddds).array().abs();
      load.first.tail<2>() << way() * std::abs(at.ds), turn() * std::abs(at.ds);
      load.second.tail<2>() << way() * std::abs(at.dds), turn() * std::abs(at.dds);
      load.third.tail<2>() << way() * std::abs(at.ddds), turn() * std::abs(at.ddds);
      result.instants.push_back(std::move(load));
    }
    return result;
  }

  /// By how much a law must be stretched so that each channel just keeps what the law may use (below 1: shrunk).
  double stretch_needed(const LawLoads& plan) const {
    double k = 0.0;
    for (const LawLoads::Instant& load : plan.instants) {
      for (std::size_t c = 0; c < channels_.size(); ++c) {
        const auto i = static_cast<Eigen::Index>(c);
        k = std::max({k, load.first[i] / channels_[c].velocity,
                      std::sqrt(load.second[i] / (acceleration_share() * channels_[c].acceleration)),
                      std::cbrt(load.third[i] / (jerk_share() * channels_[c].jerk))});
      }
    }
    return k;
  }

  LawLoads stretched(LawLoads plan, double k) const {
    plan.law = plan.law.stretched(k);
    for (LawLoads::Instant& load : plan.instants) {
      load.first /= k;
      load.second /= k * k;
      load.third /= k * k * k;
    }
    return plan;
  }

  /// Limits of s when `tangential` of each acceleration limit goes into speeding up and the rest into the curvature of
  /// the joint path, both at their largest on the line.
  RateLimits rate_limits(double tangential) const {
    JointVector first = JointVector::Zero(chain_.joint_count());
    JointVector second = first;
    for (const LineWalk::Node& node : walk_.nodes) {
      first = first.cwiseMax(node.dq.cwiseAbs());
      second = second.cwiseMax(node.ddq.cwiseAbs());
    }
    RateLimits result{kInfinity, kInfinity, kInfinity};
    const auto tighten = [&](const Channel& channel, double f1, double f2) {
      const double a = acceleration_share() * channel.acceleration;
      result.velocity = std::min(result.velocity, channel.velocity / f1);
      result.acceleration = std::min(result.acceleration, tangential * a / f1);
      result.jerk = std::min(result.jerk, tangential * jerk_share() * channel.jerk / f1);
      if (tangential < 1.0) result.velocity = std::min(result.velocity, std::sqrt((1 - tangential) * a / f2));
    };
    const auto n = static_cast<std::size_t>(chain_.joint_count());
    for (std::size_t i = 0; i < n; ++i) {
      tighten(channels_[i], first[static_cast<Eigen::Index>(i)], second[static_cast<Eigen::Index>(i)]);
    }
    tighten(channels_[n], way(), 0.0);
    tighten(channels_[n + 1], turn(), 0.0);
    return result;
  }

  /// Rest-to-rest laws with the acceleration limits divided in several ways between speeding up and the curvature of
  /// the joint path, each stretched until it just fits; the shortest.
  LawLoads fastest_law() const {
    LawLoads best;
    for (const double tangential : {1.0, 0.75, 0.5}) {
      LawLoads plan = loads(TimeLaw::rest_to_rest(rate_limits(tangential)));
      plan = stretched(std::move(plan), stretch_needed(plan));
      if (best.instants.empty() || plan.law.duration() < best.law.duration()) best = std::move(plan);
    }
    return best;
  }

  /// True if the interpolation between the nodes cannot be off by more than a few per cent of a jerk limit.
  bool known_well_enough(const LawLoads& plan) const {
    constexpr double kShare = 0.02;
    double fastest = 0.0;
    for (const LawPoint& at : instants(plan.law)) fastest = std::max(fastest, at.ds);
    const JointVector off = walk_.roughness() * (fastest * fastest * fastest);
    return (off.array() <= kShare * limits_.jerk.array()).all();
  }

  ClockBounds clock_for(const LawLoads& plan) const {
    ClockSearch search;
    for (const LawLoads::Instant& load : plan.instants) {
      for (std::size_t c = 0; c < channels_.size(); ++c) {
        const auto i = static_cast<Eigen::Index>(c);
        search.add({.first_by_acceleration = load.first[i] / channels_[c].acceleration,
                    .second_by_acceleration = load.second[i] / channels_[c].acceleration,
                    .first_by_jerk = load.first[i] / channels_[c].jerk,
                    .second_by_jerk = load.second[i] / channels_[c].jerk,
                    .third_by_jerk = load.third[i] / channels_[c].jerk});
      }
    }
    return search.bounds();
  }

  [[nodiscard]] double acceleration_share() const { return kLawShareOfAcceleration * options_.acceleration; }
  [[nodiscard]] double jerk_share() const { return kLawShareOfJerk * options_.acceleration; }

  const Chain& chain_;
  const InverseKinematics& inverse_;
  const JointLimits& limits_;
  const MotionOptions& options_;
  std::vector<Channel> channels_;
  CartesianLine line_;
  LineWalk walk_;
};

void check_cartesian(const CartesianLimits& limits, Findings& findings) {
  const struct {
    const char* name;
    double value;
  } entries[] = {{"linear_velocity", limits.linear_velocity},
                 {"linear_acceleration", limits.linear_acceleration},
                 {"linear_jerk", limits.linear_jerk},
                 {"angular_velocity", limits.angular_velocity},
                 {"angular_acceleration", limits.angular_acceleration},
                 {"angular_jerk", limits.angular_jerk}};
  for (const auto& [name, value] : entries) {
    if (std::isfinite(value) && value > 0.0) continue;
    findings.error(fmt::format("/cartesian_limits/{}", name), fmt::format("limit {}", value), "finite and above 0");
  }
}

void check_held(const InverseKinematics& inverse, const JointLimits& limits, const JointVector& held,
                Findings& findings) {
  const auto& joints = inverse.held_joints();
  if (held.size() != static_cast<Eigen::Index>(joints.size())) {
    findings.error("/held_goal", fmt::format("{} values", held.size()),
                   fmt::format("one for each of the {} held joints", joints.size()));
    return;
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double q = held[static_cast<Eigen::Index>(i)];
    const int joint = joints[i];
    if (q >= limits.lower[joint] - kRangeTolerance && q <= limits.upper[joint] + kRangeTolerance) continue;
    range_finding(inverse.chain(), limits, joint, q, "/held_goal" + pointer_segment(i), "", findings);
  }
}

}  // namespace

Result<Motion> plan_lin(const Chain& chain, const InverseKinematics& inverse, const JointLimits& limits,
                        const CartesianLimits& cartesian_limits, const JointVector& q_start,
                        const Eigen::Isometry3d& X_BM_goal, const std::optional<JointVector>& held_goal,
                        const MotionOptions& options) {
  Findings findings;
  check_limits(chain, limits, findings);
  check_cartesian(cartesian_limits, findings);
  check_options(options, findings);
  check_pose(X_BM_goal, "/goal", findings);
  check_pose(options.X_FM, "/options/X_FM", findings);
  if (findings.has_errors()) return std::unexpected(std::move(findings));
  check_configuration(chain, limits, q_start, "/start", findings);
  if (held_goal) check_held(inverse, limits, *held_goal, findings);
  if (findings.has_errors()) return std::unexpected(std::move(findings));

  const JointVector held_start = inverse.held(q_start);
  const CartesianLine line = CartesianLine::between(chain.forward(q_start) * options.X_FM, X_BM_goal, held_start,
                                                    held_goal.value_or(held_start));
  const bool stands = line.length == 0.0 && line.angle == 0.0 && line.held_start.isApprox(line.held_goal, 1e-14);
  if (stands) return standing(line, q_start);
  return LinePlanner(chain, inverse, limits, cartesian_limits, options).plan(line, q_start);
}

}  // namespace takt::motion
