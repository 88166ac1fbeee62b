#include "core/motion/plan_checks.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/kinematics/inverse.h"
#include "core/kinematics/joint_range.h"
#include "core/kinematics/plane.h"

namespace takt::motion {
namespace {

void check_positive(const kinematics::Chain& chain, const JointVector& values, const std::string& name,
                    Diagnostics& diagnostics) {
  if (values.size() != chain.joint_count()) {
    diagnostics.error(Code::kWrongSize, "/limits/" + name, fmt::format("{} entries", values.size()),
                      fmt::format("Give one for each of the {} joints", chain.joint_count()));
    return;
  }
  for (int i = 0; i < chain.joint_count(); ++i) {
    if (std::isfinite(values[i]) && values[i] > 0.0) continue;
    diagnostics.error(
        Code::kOutOfRange, "/limits/" + name + pointer_segment(static_cast<std::size_t>(i)),
        fmt::format("joint '{}': {} limit {}", chain.joint_names()[static_cast<std::size_t>(i)], name, values[i]),
        "Give a finite number above 0");
  }
}

void check_range(const kinematics::Chain& chain, const JointLimits& limits, Diagnostics& diagnostics) {
  if (limits.lower.size() != chain.joint_count() || limits.upper.size() != chain.joint_count()) {
    diagnostics.error(Code::kWrongSize, "/limits",
                      fmt::format("{} lower and {} upper ends", limits.lower.size(), limits.upper.size()),
                      fmt::format("Give one for each of the {} joints", chain.joint_count()));
    return;
  }
  for (int i = 0; i < chain.joint_count(); ++i) {
    if (limits.lower[i] <= limits.upper[i]) continue;
    diagnostics.error(Code::kOutOfRange, "/limits/lower" + pointer_segment(static_cast<std::size_t>(i)),
                      fmt::format("joint '{}': range from {} to {}", chain.joint_names()[static_cast<std::size_t>(i)],
                                  limits.lower[i], limits.upper[i]),
                      "Give the lower end first");
  }
}

}  // namespace

void check_directions(const kinematics::InverseKinematics& inverse, const JointVector& q, const Eigen::Isometry3d& X_BF,
                      const std::string& pointer, Diagnostics& diagnostics) {
  if (!kinematics::moves_in_plane(inverse.chain())) return;  // elsewhere what is near q does not hold far from it
  constexpr double kNothing = 1e-9;                          // m and rad: rounding
  constexpr const char* kAxes[] = {"x", "y", "z"};
  const kinematics::Vector6 beyond = inverse.beyond_joints(q, X_BF);
  std::string missing;
  for (int i = 0; i < 6; ++i) {
    if (std::abs(beyond[i]) <= kNothing) continue;
    const bool turn = i >= 3;
    missing += fmt::format("{}{:.4g} {} {} {}", missing.empty() ? "" : ", ",
                           turn ? beyond[i] * 180.0 / std::numbers::pi : beyond[i], turn ? "deg about" : "m along",
                           kAxes[i % 3], "of its base");
  }
  if (missing.empty()) return;
  diagnostics.error(
      Code::kUnsupported, pointer,
      fmt::format("the goal is where the {} joints cannot go: {}", inverse.chain().joint_count(), missing),
      "Choose a goal in the plane, or the space, in which they move");
}

std::vector<LawPoint> instants(const TimeLaw& law, int parts) {
  std::vector<LawPoint> points;
  points.reserve(law.segments().size() * static_cast<std::size_t>(parts + 1));
  LawPoint begin{.s = 0.0, .ds = law.begin().ds, .dds = law.begin().dds, .ddds = 0.0};
  for (const auto& [duration, jerk] : law.segments()) {
    begin.ddds = jerk;
    for (int i = 0; i <= parts; ++i) points.push_back(advanced(begin, duration * i / parts));
    begin = points.back();
  }
  return points;
}

FastestOf::FastestOf(const TimeLaw& law) {
  constexpr std::size_t kMany = 64;  // such a law is made of the cells of its path
  points_ = instants(law, law.segments().size() > kMany ? 2 : kPartsPerSegment);
}

double FastestOf::between(double s_begin, double s_end) const {
  constexpr double kHair = 1.005;
  auto at = std::ranges::upper_bound(points_, s_begin, {}, &LawPoint::s);
  if (at != points_.begin()) --at;
  double fastest = 0.0;
  for (; at != points_.end(); ++at) {
    fastest = std::max(fastest, at->ds);
    if (at->s >= s_end) break;
  }
  return kHair * fastest;
}

void check_limits(const kinematics::Chain& chain, const JointLimits& limits, Diagnostics& diagnostics) {
  check_range(chain, limits, diagnostics);
  check_positive(chain, limits.velocity, "velocity", diagnostics);
  check_positive(chain, limits.acceleration, "acceleration", diagnostics);
  check_positive(chain, limits.jerk, "jerk", diagnostics);
}

void check_options(const MotionOptions& options, Diagnostics& diagnostics) {
  const struct {
    const char* name;
    double value;
  } shares[] = {{"velocity", options.velocity}, {"acceleration", options.acceleration}};
  for (const auto& [name, value] : shares) {
    if (value > 0.0 && value <= 1.0) continue;
    diagnostics.error(Code::kOutOfRange, fmt::format("/options/{}", name), fmt::format("share {}", value),
                      "Choose a share above 0, at most 1");
  }
  const double speed = options.linear_velocity.value_or(1.0);
  if (!(speed > 0.0 && std::isfinite(speed))) {
    diagnostics.error(Code::kOutOfRange, "/options/linear_velocity", fmt::format("speed {} m/s", speed),
                      "Give a finite number above 0");
  }
}

void check_pose(const Eigen::Isometry3d& X, const std::string& pointer, Diagnostics& diagnostics) {
  constexpr double kRotationTolerance = 1e-6;
  const Eigen::Matrix3d R = X.linear();
  const bool rotation = R.allFinite() &&
                        (R.transpose() * R - Eigen::Matrix3d::Identity()).norm() < kRotationTolerance &&
                        R.determinant() > 0.0;
  if (X.translation().allFinite() && rotation) return;
  diagnostics.error(Code::kOutOfRange, pointer, "the pose is not a rotation and translation of finite numbers");
}

namespace {

/// A joint position as files have it: m, or degrees.
double in_file_units(const kinematics::Chain& chain, int joint, double value) {
  return chain.is_prismatic(joint) ? value : value * 180.0 / std::numbers::pi;
}

}  // namespace

void range_diagnostic(const kinematics::Chain& chain, const JointLimits& limits, int joint, double value,
                      const std::string& pointer, const std::string& where, Diagnostics& diagnostics) {
  const char* unit = chain.is_prismatic(joint) ? "m" : "deg";
  diagnostics.error(
      Code::kOutOfRange, pointer,
      fmt::format("joint '{}': {:.6g} {}{} is outside its range", chain.joint_names()[static_cast<std::size_t>(joint)],
                  in_file_units(chain, joint, value), unit, where),
      fmt::format("Choose a value from {:.6g} to {:.6g} {}", in_file_units(chain, joint, limits.lower[joint]),
                  in_file_units(chain, joint, limits.upper[joint]), unit));
}

void check_configuration(const kinematics::Chain& chain, const JointLimits& limits, const JointVector& q,
                         const std::string& pointer, Diagnostics& diagnostics) {
  if (q.size() != chain.joint_count()) {
    diagnostics.error(Code::kWrongSize, pointer, fmt::format("{} joint values", q.size()),
                      fmt::format("Give one for each of the {} joints", chain.joint_count()));
    return;
  }
  for (int i = 0; i < chain.joint_count(); ++i) {
    const std::string place = pointer + pointer_segment(static_cast<std::size_t>(i));
    if (!std::isfinite(q[i])) {
      diagnostics.error(Code::kOutOfRange, place,
                        fmt::format("joint '{}': {}", chain.joint_names()[static_cast<std::size_t>(i)], q[i]),
                        "Give a finite number");
    } else if (!kinematics::is_in_range(q[i], limits.lower[i], limits.upper[i])) {
      range_diagnostic(chain, limits, i, q[i], place, "", diagnostics);
    }
  }
}

}  // namespace takt::motion
