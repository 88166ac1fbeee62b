#include "core/command/actions/weave_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/device/description.h"
#include "core/expression/frame_stretches.h"
#include "core/kinematics/inverse.h"
#include "core/motion/clock_bounds.h"
#include "core/motion/motion_state.h"
#include "core/motion/path_clock.h"

namespace takt::command {
namespace {

using kinematics::JointVector;

/// What plans leave of the acceleration and of the jerk (docs/motion.md).
constexpr double kAccelerationLeft = 0.2, kJerkLeft = 0.3;

/// The largest velocity, acceleration and jerk of a weave at full speed: m/s, m/s^2, m/s^3.
using Peaks = std::array<double, 3>;
constexpr std::array<std::pair<const char*, const char*>, 3> kWhat = {
    {{"a velocity", "m/s"}, {"an acceleration", "m/s^2"}, {"a jerk", "m/s^3"}}};

Peaks most_of(const motion::CartesianLimits& limits) {
  return {limits.linear_velocity, kAccelerationLeft * limits.linear_acceleration, kJerkLeft * limits.linear_jerk};
}

Peaks larger_of(const Peaks& a, const Peaks& b) {
  return {std::max(a[0], b[0]), std::max(a[1], b[1]), std::max(a[2], b[2])};
}

/// A weave while it is at its full amplitude.
Peaks peaks_between_ramps(const WeaveParameters& weave) {
  const double omega = 2.0 * std::numbers::pi * weave.frequency;
  return {weave.amplitude * omega, weave.amplitude * omega * omega, weave.amplitude * omega * omega * omega};
}

/// The smooth step 10 u^3 - 15 u^4 + 6 u^5 of the primitive Weave, with its derivatives with respect to u in [0, 1].
std::array<double, 4> smooth_step(double u) {
  return {u * u * u * (10.0 + u * (-15.0 + 6.0 * u)), 30.0 * u * u * (1.0 - u) * (1.0 - u),
          60.0 * u * (1.0 - u) * (1.0 - 2.0 * u), 60.0 * (1.0 - 6.0 * u + 6.0 * u * u)};
}

/// A weave in its ramps: A sin(w t) s(u), u = t / T at its start and (D - t) / T at its end, sampled densely. Where
/// the ramp has many periods every phase comes by, and the envelope of each derivative is its peak.
/// @param duration  D of the path, s
Peaks peaks_in_ramps(const WeaveParameters& weave, double duration) {
  constexpr int kPlaces = 400;           // of a period, or of a shorter ramp
  constexpr double kManyPeriods = 20.0;  // the envelope is less than 0.1 % above the peak then
  const double omega = 2.0 * std::numbers::pi * weave.frequency, ramp = std::min(weave.ramp, 0.5 * duration);
  const bool by_envelope = ramp * weave.frequency > kManyPeriods;
  const int places = by_envelope ? kPlaces : static_cast<int>(kPlaces * std::max(1.0, ramp * weave.frequency));
  Peaks peaks{};
  for (int i = 0; i <= places; ++i) {
    const double u = static_cast<double>(i) / places;
    auto s = smooth_step(u);
    for (int order = 1; order < 4; ++order) s[static_cast<std::size_t>(order)] /= std::pow(ramp, order);
    // Derivatives of the product: what goes with the sine, and what with the cosine.
    const std::array<std::pair<double, double>, 3> parts = {
        {{s[1], omega * s[0]},
         {s[2] - omega * omega * s[0], 2.0 * omega * s[1]},
         {s[3] - 3.0 * omega * omega * s[1], 3.0 * omega * s[2] - omega * omega * omega * s[0]}}};
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const auto [of_sine, of_cosine] = parts[k];
      const auto at = [&](double phase) { return std::abs(of_sine * std::sin(phase) + of_cosine * std::cos(phase)); };
      // To the end the same runs backwards in time, from the phase that the sine has there.
      const double most = by_envelope ? std::hypot(of_sine, of_cosine)
                                      : std::max(at(omega * u * ramp), at(omega * (u * ramp - duration)));
      peaks[k] = std::max(peaks[k], weave.amplitude * most);
    }
  }
  return peaks;
}

/// The shortest ramp that is possible, s, as people read it.
std::string longer_ramp(const WeaveParameters& weave, double duration, const Peaks& most) {
  constexpr double kStep = 1.02;
  WeaveParameters longer = weave;
  longer.ramp = std::max(weave.ramp, 1e-3);
  const auto fits = [&] { return larger_of(peaks_in_ramps(longer, duration), most) == most; };
  while (longer.ramp < 0.5 * duration) {
    longer.ramp = std::min(kStep * longer.ramp, 0.5 * duration);
    if (fits()) return fmt::format("a ramp of {:.3f} s or more", std::ceil(1e3 * longer.ramp) / 1e3);
  }
  return "a longer motion, or a smaller amplitude or frequency";
}

/// What is needed to grow from nothing, and to fade, shows once it is known how long the motion takes.
Diagnostics check_ramps(const WeaveParameters& weave, double duration, const Peaks& most) {
  Diagnostics diagnostics;
  const Peaks ramps = peaks_in_ramps(weave, duration);
  std::string way_out;
  for (std::size_t k = 0; k < kWhat.size(); ++k) {
    if (ramps[k] <= most[k]) continue;
    if (way_out.empty()) way_out = longer_ramp(weave, duration, most);
    const auto& [what, unit] = kWhat[k];
    diagnostics.error(Code::kLimitExceeded, "/ramp",
                      fmt::format("a weave that grows or fades in {:.3g} s, with {} of {:.3g} {} (at most {:.3g} {})",
                                  std::min(weave.ramp, 0.5 * duration), what, ramps[k], unit, most[k], unit),
                      way_out);
  }
  return diagnostics;
}

// -- Where weaves lie on the path clock ----------------------------------------------------------------------------

class Placing {
 public:
  Placing(const ActionModel::PlannedPath& path, const Weaves& weaves)
      : duration_(path.motion->duration()),
        handed_over_(path.handed_over),
        stretches_(expression::stretches_of_frame(*path.motion)),
        weaves_(weaves) {
    if (weaves_.size() == 1) weaves_.resize(handed_over_.size() + 1, weaves_.front());
    weaves_.resize(handed_over_.size() + 1);
  }

  Result<std::vector<WeaveWindow>> windows() const {
    Diagnostics diagnostics;
    std::vector<WeaveWindow> windows;
    for (std::size_t first = 0, next = 0; first < weaves_.size(); first = next) {
      for (next = first + 1; next < weaves_.size() && weaves_[next] == weaves_[first];) ++next;
      if (!weaves_[first]) continue;
      for (std::size_t i = first; i < next; ++i) check_moves_frame(i, diagnostics);
      const expression::Interval whole{.begin = interval(first).begin, .end = interval(next - 1).end};
      for (const expression::Interval& stretch : stretches_) {
        const expression::Interval own = expression::common(whole, stretch);
        if (expression::is_some(own))
          windows.push_back({.weave = *weaves_[first], .begin = own.begin, .end = own.end, .motion = first});
      }
    }
    if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
    return windows;
  }

 private:
  /// When motion i is the one that is being done.
  [[nodiscard]] expression::Interval interval(std::size_t i) const {
    return {.begin = i == 0 ? 0.0 : handed_over_[i - 1], .end = i == handed_over_.size() ? duration_ : handed_over_[i]};
  }
  void check_moves_frame(std::size_t i, Diagnostics& diagnostics) const {
    const expression::Interval own = interval(i);
    const auto moves = [&](const expression::Interval& stretch) {
      return expression::is_some(expression::common(own, stretch));
    };
    if (!expression::is_some(own) || std::ranges::any_of(stretches_, moves)) return;
    diagnostics.error(Code::kConflict, pointer_segment(i),
                      "C8: a motion of joints, so there is no Cartesian path to weave about",
                      "Lay it over a Cartesian motion");
  }

  double duration_;
  const std::vector<double>& handed_over_;
  std::vector<expression::Interval> stretches_;
  Weaves weaves_;
};

// -- What path and weave need together -----------------------------------------------------------------------------

/// Values one step apart, the newest first, and the absolute differences of their last four, each over its step: means
/// of the derivatives, which never show more than there is.
template <class Value>
class Differences {
 public:
  explicit Differences(const Value& begin) : last_{begin, begin, begin, begin} {}
  void add(const Value& value) {
    for (std::size_t back = 3; back > 0; --back) last_[back] = last_[back - 1];
    last_[0] = value;
    count_ = std::min(count_ + 1, 3);
  }
  /// @param order  1 to 3. Zero where there are not yet values enough
  [[nodiscard]] Value by_time(int order, double step) const {
    if (order > count_) return Value(0.0 * last_[0]);
    if (order == 1) return Value((last_[0] - last_[1]) / step);
    if (order == 2) return Value((last_[0] - 2.0 * last_[1] + last_[2]) / (step * step));
    return Value((last_[0] - 3.0 * last_[1] + 3.0 * last_[2] - last_[3]) / (step * step * step));
  }
  [[nodiscard]] const Value& newest() const { return last_[0]; }
  /// Where the last two point to.
  [[nodiscard]] Value next() const { return Value(2.0 * last_[0] - last_[1]); }

 private:
  std::array<Value, 4> last_;
  int count_ = 0;
};

/// The set points of a motion under its weaves, as they are at full rate.
class WovenPath {
 public:
  WovenPath(const expression::MountedArm& arm, const ActionModel::PlannedPath& path)
      : arm_(expression::planning_model(arm, path.X_FM)), X_MF_(path.X_FM.inverse()), motion_(*path.motion) {}

  /// Checks a weave all along. Diagnostics without a location.
  Diagnostics look(const WeaveWindow& window) {
    worst_ = {};
    const auto begin = motion::joints_at(arm_, motion_, window.begin);
    if (!begin || arm_.inverse == nullptr) return {};  // no plan lets that happen
    constexpr double kCycle = 1e-3, kPlacesPerPeriod = 100.0;
    const double length = window.end - window.begin;
    const double wanted = std::min(kCycle, 1.0 / (kPlacesPerPeriod * window.weave.frequency));
    const int places = static_cast<int>(std::ceil(length / wanted));
    step_ = length / places;
    Diagnostics diagnostics;
    Differences<JointVector> joints(begin->q);
    Differences<Eigen::Vector3d> tool(frame_at(window, window.begin).X_BM.translation());
    for (int i = 1; i <= places && !diagnostics.has_errors(); ++i) {
      const double at = window.begin + length * i / places;
      const Place place = frame_at(window, at);
      JointVector q = joints.next();
      if (arm_.inverse->solve(place.X_BM * X_MF_, place.held, q) != kinematics::IkStatus::kOk) {
        diagnostics.error(Code::kUnreachable, {},
                          fmt::format("the weave leads where the arm does not reach, at {:.3f} s", at),
                          "Decrease the amplitude, or choose another path");
        break;
      }
      joints.add(q);
      tool.add(place.X_BM.translation());
      check_range(q, at, diagnostics);
      note(joints, tool, at);
    }
    return diagnostics.has_errors() ? diagnostics : too_much(window.weave);
  }

  /// Of all that was checked and of the plan itself.
  [[nodiscard]] motion::ClockBounds clock() const { return motion::common(search_.bounds(), motion_.clock); }

 private:
  struct Place {
    Eigen::Isometry3d X_BM;
    JointVector held;
  };
  /// What is used most of a limit of each order: by a joint, from 0, or by the tool, -1.
  struct Worst {
    double share = 0.0, value = 0.0, limit = 0.0, at = 0.0;
    int whose = -1;
  };

  [[nodiscard]] static double offset_at(const WeaveWindow& window, double at) {
    const double t = at - window.begin, left = window.end - at;
    const double ramp = std::min(window.weave.ramp, 0.5 * (window.end - window.begin));
    const double rise = smooth_step(std::clamp(t / ramp, 0.0, 1.0))[0];
    const double fall = smooth_step(std::clamp(left / ramp, 0.0, 1.0))[0];
    return window.weave.amplitude * std::sin(2.0 * std::numbers::pi * window.weave.frequency * t) * rise * fall;
  }
  [[nodiscard]] Place frame_at(const WeaveWindow& window, double at) const {
    const motion::LawPoint law = motion_.law.at(at);
    // The ends belong to the frame, though a piece of joints may begin there.
    constexpr double kHair = 1e-9;
    const double s = std::clamp(law.s, motion_.law.at(window.begin).s + kHair, motion_.law.at(window.end).s - kHair);
    const motion::PathSample on_path = motion::sample(motion_.path, {.s = s, .ds = 0.0, .dds = 0.0});
    Place place{on_path.frame.X_BM, on_path.held.q};
    place.X_BM.translation() += place.X_BM.linear() * window.weave.direction_M * offset_at(window, at);
    return place;
  }

  void check_range(const JointVector& q, double at, Diagnostics& diagnostics) const {
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      if (q[i] >= arm_.limits.lower[i] && q[i] <= arm_.limits.upper[i]) continue;
      diagnostics.error(Code::kUnreachable, {},
                        fmt::format("with the weave joint {} leaves its range, {:.4g} to {:.4g}, at {:.3f} s", i + 1,
                                    arm_.limits.lower[i], arm_.limits.upper[i], at),
                        "Decrease the amplitude, or choose another path");
    }
  }

  void note(const Differences<JointVector>& joints, const Differences<Eigen::Vector3d>& tool, double at) {
    std::array<JointVector, 3> of_joints;
    std::array<double, 3> of_tool{};
    for (int order = 1; order <= 3; ++order) {
      const auto k = static_cast<std::size_t>(order - 1);
      of_joints[k] = joints.by_time(order, step_);
      of_tool[k] = tool.by_time(order, step_).norm();
    }
    const auto& limits = arm_.limits;
    for (Eigen::Index i = 0; i < of_joints[0].size(); ++i) {
      note_one(static_cast<int>(i), {std::abs(of_joints[0][i]), std::abs(of_joints[1][i]), std::abs(of_joints[2][i])},
               {limits.velocity[i], limits.acceleration[i], limits.jerk[i]}, at);
    }
    const auto& cartesian = arm_.cartesian;
    note_one(-1, of_tool, {cartesian.linear_velocity, cartesian.linear_acceleration, cartesian.linear_jerk}, at);
  }

  void note_one(int whose, const std::array<double, 3>& values, const std::array<double, 3>& limits, double at) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double share = values[k] / (kMost[k] * limits[k]);
      if (share > worst_[k].share)
        worst_[k] = {.share = share, .value = values[k], .limit = kMost[k] * limits[k], .at = at, .whose = whose};
    }
    search_.add({.first_by_acceleration = values[0] / limits[1],
                 .second_by_acceleration = values[1] / limits[1],
                 .first_by_jerk = values[0] / limits[2],
                 .second_by_jerk = values[1] / limits[2],
                 .third_by_jerk = values[2] / limits[2]});
  }

  [[nodiscard]] Diagnostics too_much(const WeaveParameters& weave) const {
    static constexpr std::array<const char*, 3> kOrders = {"velocity", "acceleration", "jerk"};
    static constexpr std::array<const char*, 3> kWaysOut = {
        "a slower motion, a smaller amplitude or frequency",
        "a smaller share of the acceleration for the motion, a smaller amplitude or frequency",
        "a smaller share of the acceleration for the motion, a longer ramp, a smaller amplitude or frequency"};
    Diagnostics diagnostics;
    for (std::size_t k = 0; k < worst_.size(); ++k) {
      const Worst& worst = worst_[k];
      if (worst.share <= 1.0) continue;
      const std::string whose = worst.whose < 0 ? "the tool" : fmt::format("joint {}", worst.whose + 1);
      std::string way_out = kWaysOut[k];
      const double left = std::pow(worst.limit, 2) - std::pow(peaks_between_ramps(weave)[0], 2);
      if (k == 0 && worst.whose < 0 && left > 0.0)
        way_out = fmt::format("a motion of at most {:.3g} m/s on its path, or a smaller amplitude or frequency",
                              std::floor(1e3 * std::sqrt(left)) / 1e3);
      diagnostics.error(Code::kLimitExceeded, {},
                        fmt::format("path and weave together need {:.3g} of the {} of {} (at most {:.3g}), at {:.3f} s",
                                    worst.value, kOrders[k], whose, worst.limit, worst.at),
                        way_out);
    }
    return diagnostics;
  }

  /// Of each limit; the clock has the rest, as where a motion is entered at speed (docs/motion.md).
  static constexpr std::array<double, 3> kMost = {0.999, 0.95, 0.9};

  motion::ArmModel arm_;
  Eigen::Isometry3d X_MF_;
  const motion::Motion& motion_;
  motion::ClockSearch search_;
  std::array<Worst, 3> worst_;
  double step_ = 1e-3;  ///< s
};

}  // namespace

Diagnostics check_figures(const WeaveParameters& weave) {
  Diagnostics diagnostics;
  const auto check = [&](const char* name, double value, const char* unit) {
    if (value > 0.0 && std::isfinite(value)) return;
    diagnostics.error(Code::kOutOfRange, pointer_segment(name), fmt::format("{:g} {}", value, unit),
                      "Give a number above 0, and finite");
  };
  check("amplitude", weave.amplitude, "m");
  check("frequency", weave.frequency, "Hz");
  check("ramp", weave.ramp, "s");
  const double length = weave.direction_M.norm();
  if (!(std::abs(length - 1.0) < 1e-6))
    diagnostics.error(Code::kOutOfRange, "/direction", fmt::format("a direction of length {:g}", length),
                      "Give a vector of length 1");
  return diagnostics;
}

Diagnostics check_alone(const WeaveParameters& weave, const motion::CartesianLimits& limits) {
  Diagnostics diagnostics;
  const Peaks most = most_of(limits), steady = peaks_between_ramps(weave);
  for (std::size_t k = 0; k < kWhat.size(); ++k) {
    if (steady[k] <= most[k]) continue;
    diagnostics.error(
        Code::kOutOfRange, {}, fmt::format("a weave with {} of {:.3g} {}", kWhat[k].first, steady[k], kWhat[k].second),
        fmt::format("Decrease the amplitude or the frequency: at most {:.3g} {}", most[k], kWhat[k].second));
  }
  return diagnostics;
}

Result<WeavePlan> plan_weaves(const expression::MountedArm& arm, const ActionModel::PlannedPath& path,
                              const Weaves& weaves) {
  auto windows = Placing(path, weaves).windows();
  if (!windows) return std::unexpected(std::move(windows.error()));
  const motion::CartesianLimits& limits = arm.device->description().cartesian;
  Diagnostics diagnostics;
  WovenPath woven(arm, path);
  for (const WeaveWindow& window : *windows) {
    Diagnostics own = check_alone(window.weave, limits);
    if (!own.has_errors()) own.append(check_ramps(window.weave, window.end - window.begin, most_of(limits)));
    if (!own.has_errors()) own.append(woven.look(window));
    diagnostics.append(own, pointer_segment(window.motion));
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return WeavePlan{.windows = std::move(*windows), .clock = woven.clock()};
}

}  // namespace takt::command
