#include "core/command/overlay_action.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/device_sensors.h"
#include "core/command/velocity_action.h"
#include "core/device/description.h"
#include "core/kinematics/inverse.h"
#include "core/motion/motion_state.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;

/// What plans leave of the acceleration and of the jerk (docs/motion.md).
constexpr double kAccelerationLeft = 0.2, kJerkLeft = 0.3;

/// One thing at a time is laid over a motion.
void check_is_bare(const ActionModel& motion, Findings& findings) {
  if (motion.planned_path().laid_over)
    findings.error({}, fmt::format("something is laid over {} already", motion.name()), "a force offset or a weave");
}

/// The largest velocity, acceleration and jerk of a weave at full speed: m/s, m/s^2, m/s^3.
using Peaks = std::array<double, 3>;

Peaks larger_of(const Peaks& a, const Peaks& b) {
  return {std::max(a[0], b[0]), std::max(a[1], b[1]), std::max(a[2], b[2])};
}

/// A weave while it is at its full amplitude.
Peaks peaks_between_ramps(const WeaveWish& wish) {
  const double omega = 2.0 * std::numbers::pi * wish.frequency;
  return {wish.amplitude * omega, wish.amplitude * omega * omega, wish.amplitude * omega * omega * omega};
}

/// The smooth step 10 u^3 - 15 u^4 + 6 u^5 of the primitive Weave, with its derivatives with respect to u in [0, 1].
std::array<double, 4> smooth_step(double u) {
  return {u * u * u * (10.0 + u * (-15.0 + 6.0 * u)), 30.0 * u * u * (1.0 - u) * (1.0 - u),
          60.0 * u * (1.0 - u) * (1.0 - 2.0 * u), 60.0 * (1.0 - 6.0 * u + 6.0 * u * u)};
}

/// A weave in its ramps: A sin(w t) s(u), u = t / T at its start and (D - t) / T at its end, looked at densely. Where
/// the ramp has many periods every phase comes by, and the envelope of each derivative is its peak.
/// @param duration  D of the path, s
Peaks peaks_in_ramps(const WeaveWish& wish, double duration) {
  constexpr int kPlaces = 400;           // of a period, or of a shorter ramp
  constexpr double kManyPeriods = 20.0;  // the envelope is less than 0.1 % above the peak then
  const double omega = 2.0 * std::numbers::pi * wish.frequency, ramp = std::min(wish.ramp, 0.5 * duration);
  const bool by_envelope = ramp * wish.frequency > kManyPeriods;
  const int places = by_envelope ? kPlaces : static_cast<int>(kPlaces * std::max(1.0, ramp * wish.frequency));
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
      peaks[k] = std::max(peaks[k], wish.amplitude * most);
    }
  }
  return peaks;
}

class Woven final : public ActionModel {
 public:
  Woven(std::shared_ptr<const ActionModel> motion, const WeaveWish& wish) : motion_(std::move(motion)), wish_(wish) {}

  [[nodiscard]] std::string_view name() const override { return motion_->name(); }
  [[nodiscard]] SetPointKind gives(const ActuatorModel& actuator) const override { return motion_->gives(actuator); }
  [[nodiscard]] std::optional<device::ControlMode> mode() const override { return motion_->mode(); }
  [[nodiscard]] std::vector<ExpressionPtr> formulas() const override { return motion_->formulas(); }
  [[nodiscard]] std::vector<std::string> states() const override { return motion_->states(); }
  [[nodiscard]] int via_count() const override { return motion_->via_count(); }
  [[nodiscard]] std::string add_state(FragmentWriter& fragment, const std::string& name,
                                      const Json& parameters) const override {
    return motion_->add_state(fragment, name, parameters);
  }
  [[nodiscard]] std::vector<device::Seam> begins() const override { return motion_->begins(); }
  [[nodiscard]] std::vector<device::Seam> ends() const override { return motion_->ends(); }
  [[nodiscard]] double stop_time(const ActuatorModel& actuator) const override { return motion_->stop_time(actuator); }
  [[nodiscard]] PlannedPath planned_path() const override {
    PlannedPath path = motion_->planned_path();
    path.laid_over = true;
    return path;
  }
  [[nodiscard]] double duration() const override { return motion_->duration(); }
  [[nodiscard]] bool needs_plan() const override { return motion_->needs_plan(); }
  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> plan(const ActuatorModel& actuator,
                                                                const Places& q) const override {
    auto planned = motion_->plan(actuator, q);
    if (!planned) return planned;
    return std::make_shared<const Woven>(std::move(*planned), wish_);
  }

  [[nodiscard]] Findings check(const ActuatorModel& actuator) const override {
    Findings findings = motion_->check(actuator);
    if (motion_->gives(actuator) != SetPointKind::kPose) {
      findings.error({}, fmt::format("C8: {} moves joints, so there is nothing to weave beside", name()),
                     "a motion of a frame");
      return findings;
    }
    check_is_bare(*motion_, findings);
    if (!check_figures(findings)) return findings;
    const auto& limits = actuator.arm()->device->description().cartesian;
    const Peaks most{limits.linear_velocity, kAccelerationLeft * limits.linear_acceleration,
                     kJerkLeft * limits.linear_jerk};
    const Peaks steady = peaks_between_ramps(wish_);
    for (std::size_t k = 0; k < kWhat.size(); ++k) {
      if (steady[k] <= most[k]) continue;
      findings.error({}, fmt::format("a weave with {} of {:.3g} {}", kWhat[k].first, steady[k], kWhat[k].second),
                     fmt::format("at most {:.3g} {}: a smaller amplitude or frequency", most[k], kWhat[k].second));
    }
    const auto motion = motion_->planned_path().motion;
    if (motion != nullptr && !findings.has_errors()) check_ramp(motion->duration(), most, findings);
    return findings;
  }

  [[nodiscard]] Contribution add_to(FragmentWriter& fragment, const ActuatorModel& actuator) const override {
    Contribution contribution = motion_->add_to(fragment, actuator);
    fragment.add("weave", "Weave",
                 {{"amplitude", wish_.amplitude},
                  {"frequency", wish_.frequency},
                  {"duration", contribution.duration},
                  {"ramp", wish_.ramp}});
    fragment.link_all(contribution.path_clock, "weave", {"time", "rate", "rate_derivative"});
    fragment.add("offset", "OffsetFrame", {{"direction", net::value_to_json(net::Vector(wish_.direction_M))}});
    for (const char* port : {"frame", "twist", "acceleration"}) {
      contribution.set_point.feed(fragment, port, std::string("offset.") + port);
      contribution.set_point.ports[port] = std::string("offset.moved_") + port;
    }
    fragment.link("weave.value", "offset.offset");
    fragment.link("weave.velocity", "offset.offset_velocity");
    fragment.link("weave.acceleration", "offset.offset_acceleration");
    return contribution;
  }

 private:
  bool check_figures(Findings& findings) const {
    const bool before = findings.has_errors();
    const auto check = [&](const char* name, double value, const char* unit) {
      if (value > 0.0 && std::isfinite(value)) return;
      findings.error(pointer_segment(name), fmt::format("{:g} {}", value, unit), "above 0 and finite");
    };
    check("amplitude", wish_.amplitude, "m");
    check("frequency", wish_.frequency, "Hz");
    check("ramp", wish_.ramp, "s");
    const double length = wish_.direction_M.norm();
    if (!(std::abs(length - 1.0) < 1e-6))
      findings.error("/direction", fmt::format("a direction of length {:g}", length), "length 1");
    return before || !findings.has_errors();
  }

  /// What is needed to grow from nothing, and to fade, shows once it is known how long the motion takes.
  void check_ramp(double duration, const Peaks& most, Findings& findings) const {
    const Peaks ramps = peaks_in_ramps(wish_, duration);
    std::string way_out;
    for (std::size_t k = 0; k < kWhat.size(); ++k) {
      if (ramps[k] <= most[k]) continue;
      if (way_out.empty()) way_out = longer_ramp(duration, most);
      const auto& [what, unit] = kWhat[k];
      findings.error("/ramp",
                     fmt::format("a weave that grows or fades in {:.3g} s, with {} of {:.3g} {} (at most {:.3g} {})",
                                 std::min(wish_.ramp, 0.5 * duration), what, ramps[k], unit, most[k], unit),
                     way_out);
    }
  }

  /// The shortest ramp that is possible, s, as people read it.
  [[nodiscard]] std::string longer_ramp(double duration, const Peaks& most) const {
    constexpr double kStep = 1.02;
    WeaveWish longer = wish_;
    const auto fits = [&] { return larger_of(peaks_in_ramps(longer, duration), most) == most; };
    while (longer.ramp < 0.5 * duration) {
      longer.ramp = std::min(kStep * longer.ramp, 0.5 * duration);
      if (fits()) return fmt::format("a ramp of {:.3f} s or more", std::ceil(1e3 * longer.ramp) / 1e3);
    }
    return "a longer motion, or a smaller amplitude or frequency";
  }

  static constexpr std::array<std::pair<const char*, const char*>, 3> kWhat = {
      {{"a velocity", "m/s"}, {"an acceleration", "m/s^2"}, {"a jerk", "m/s^3"}}};

  std::shared_ptr<const ActionModel> motion_;
  WeaveWish wish_;
};

/// What an offset along a direction of the moving frame may add to what the joints do on a path. The path's law and its
/// clock keep the shares of the limits that the motion was planned with, whatever the clock does (docs/motion.md).
class OffsetRoom {
 public:
  OffsetRoom(const MountedArm& arm, const ActionModel::PlannedPath& path, const ForceOffsetWish& wish)
      : arm_(planning_model(arm, path.X_FM)), motion_(*path.motion), wish_(wish) {
    for (const motion::PieceShares& shares : motion_.shares) share_ = std::max(share_, shares.acceleration);
    if (motion_.shares.empty()) share_ = 1.0;
  }

  [[nodiscard]] Findings check() {
    Findings findings;
    const ForceWish& force = wish_.force;
    check_use(findings, "acceleration", -1, 0.0, force.acceleration_max,
              (1.0 - share_) * arm_.cartesian.linear_acceleration);
    check_use(findings, "jerk", -1, 0.0, wish_.jerk_max, (1.0 - share_) * arm_.cartesian.linear_jerk);
    constexpr int kPlaces = 100;
    const double step = std::max(motion_.duration() / kPlaces, kLeastStep_s);
    std::optional<JointVector> before, before_rate;
    for (double at = 0.0; at <= motion_.duration() && findings.empty(); at += step) {
      const auto sample = motion::joints_at(arm_, motion_, at);
      const auto per_metre = sample ? joints_per_metre(sample->q) : std::nullopt;
      if (!per_metre) break;  // no plan lets that happen
      const JointVector rate =
          before ? JointVector((*per_metre - *before) / step) : JointVector::Zero(per_metre->size());
      const JointVector bend = before_rate ? JointVector((rate - *before_rate) / step) : JointVector::Zero(rate.size());
      for (Eigen::Index i = 0; i < rate.size(); ++i) {
        const double s = std::abs((*per_metre)[i]), ds = std::abs(rate[i]), dds = std::abs(bend[i]);
        const double v = force.velocity_max, a = force.acceleration_max, j = wish_.jerk_max;
        const double x = std::max(wish_.reach, wish_.retreat);
        const int joint = static_cast<int>(i);
        const double share = at / std::max(motion_.duration(), kLeastStep_s);
        check_use(findings, "velocity", joint, share, kMargin * (s * v + ds * x),
                  arm_.limits.velocity[i] - std::abs(sample->dq[i]));
        check_use(findings, "acceleration", joint, share, kMargin * (s * a + 2.0 * ds * v + dds * x),
                  (1.0 - share_) * arm_.limits.acceleration[i]);
        check_use(findings, "jerk", joint, share, kMargin * (s * j + 3.0 * ds * a + 3.0 * dds * v),
                  (1.0 - share_) * arm_.limits.jerk[i]);
      }
      before = per_metre;
      before_rate = rate;
    }
    return findings;
  }

 private:
  using JointVector = kinematics::JointVector;
  static constexpr double kLeastStep_s = 1e-3;
  /// What differs between places, and at the offset from on the path.
  static constexpr double kMargin = 1.1;
  static constexpr double kRounding = 1e-9;

  /// How far the joints go for a metre along the direction.
  [[nodiscard]] std::optional<JointVector> joints_per_metre(const JointVector& q) const {
    if (arm_.inverse == nullptr) return std::nullopt;
    kinematics::Vector6 V = kinematics::Vector6::Zero();
    V.head<3>() = (arm_.chain.forward(q) * arm_.X_FM).linear() * wish_.direction_M;
    const JointVector held = JointVector::Zero(static_cast<Eigen::Index>(arm_.inverse->held_joints().size()));
    JointVector rates = q;
    if (arm_.inverse->rates(q, V, held, rates) != kinematics::IkStatus::kOk) return std::nullopt;
    return rates;
  }

  /// @param joint  -1: the frame that moves
  static void check_use(Findings& findings, const char* what, int joint, double share, double value, double room) {
    if (value <= room * (1.0 + kRounding)) return;
    const std::string whose = joint < 0 ? "the tool" : fmt::format("joint {}", joint + 1);
    findings.error(
        {},
        fmt::format("the offset may need {:.3g} of the {} of {}, where the motion leaves {:.3g} (at {:.0f} % "
                    "of its time)",
                    value, what, whose, std::max(room, 0.0), 100.0 * share),
        "a slower motion, a smaller share of its acceleration, or smaller bounds of the offset");
  }

  motion::ArmModel arm_;
  const motion::Motion& motion_;
  const ForceOffsetWish& wish_;
  double share_ = 0.0;  ///< of the limits of acceleration and jerk that the motion may use
};

class ForceOffset final : public ActionModel {
 public:
  ForceOffset(std::shared_ptr<const ActionModel> motion, ExpressionPtr pressing, const ForceOffsetWish& wish)
      : motion_(std::move(motion)), pressing_(std::move(pressing)), wish_(wish) {}

  [[nodiscard]] std::string_view name() const override { return motion_->name(); }
  [[nodiscard]] SetPointKind gives(const ActuatorModel& actuator) const override { return motion_->gives(actuator); }
  [[nodiscard]] std::optional<device::ControlMode> mode() const override { return motion_->mode(); }
  [[nodiscard]] int via_count() const override { return motion_->via_count(); }
  [[nodiscard]] std::vector<ExpressionPtr> formulas() const override {
    std::vector<ExpressionPtr> formulas = motion_->formulas();
    formulas.push_back(pressing_);
    return formulas;
  }
  [[nodiscard]] std::vector<std::string> states() const override {
    std::vector<std::string> states = motion_->states();
    states.insert(states.end(), {"in_contact", "no_force"});
    return states;
  }
  [[nodiscard]] std::string add_state(FragmentWriter& fragment, const std::string& name,
                                      const Json& parameters) const override {
    if (name == "in_contact") return "force_law.contact";
    return name == "no_force" ? "no_force.value" : motion_->add_state(fragment, name, parameters);
  }
  [[nodiscard]] std::vector<device::Seam> begins() const override { return motion_->begins(); }
  [[nodiscard]] PlannedPath planned_path() const override {
    PlannedPath path = motion_->planned_path();
    path.laid_over = true;
    return path;
  }
  [[nodiscard]] double stop_time(const ActuatorModel& actuator) const override { return motion_->stop_time(actuator); }
  [[nodiscard]] double duration() const override { return motion_->duration(); }
  [[nodiscard]] bool needs_plan() const override { return motion_->needs_plan(); }
  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> plan(const ActuatorModel& actuator,
                                                                const Places& q) const override {
    auto planned = motion_->plan(actuator, q);
    if (!planned) return planned;
    return std::make_shared<const ForceOffset>(std::move(*planned), pressing_, wish_);
  }

  [[nodiscard]] Findings check(const ActuatorModel& actuator) const override {
    Findings findings = motion_->check(actuator);
    if (motion_->gives(actuator) != SetPointKind::kPose) {
      findings.error({}, fmt::format("C8: {} moves joints, so there is nothing to shift", name()),
                     "a motion of a frame");
      return findings;
    }
    if (!(wish_.reach >= 0.0 && wish_.retreat >= 0.0 && wish_.reach + wish_.retreat > 0.0)) {
      findings.error({}, fmt::format("a force offset from {:g} to {:g} m", 0.0 - wish_.retreat, wish_.reach),
                     "a reach and a retreat from 0, not both 0");
    }
    check_is_bare(*motion_, findings);
    const PlannedPath path = motion_->planned_path();
    if (path.motion != nullptr && !path.laid_over && actuator.arm() != nullptr)
      findings.append(OffsetRoom(*actuator.arm(), path, wish_).check());
    return findings;
  }

  [[nodiscard]] Contribution add_to(FragmentWriter& fragment, const ActuatorModel& actuator) const override {
    Contribution contribution = motion_->add_to(fragment, actuator);
    add_force_law(fragment, pressing_, wish_.force);
    add_stand(fragment, contribution.path_clock);
    add_offset(fragment, contribution);
    contribution.done = Signal::at(add_done(fragment, contribution.done.port));
    return contribution;
  }

 private:
  /// While the force is not known the path stands.
  void add_stand(FragmentWriter& fragment, const std::string& clock) const {
    fragment.add("no_force", "IsNullReal");
    fragment.feed(pressing_, "no_force.input");
    const std::string rate = fragment.take_link(clock + ".target_rate");
    fragment.add("rate_with_force", "SelectReal", {{"if_true", 0.0}});
    fragment.link("no_force.value", "rate_with_force.condition");
    fragment.link(rate, "rate_with_force.if_false");
    fragment.link("rate_with_force.value", clock + ".target_rate");
  }

  void add_offset(FragmentWriter& fragment, Contribution& contribution) const {
    fragment.add("ending", "Or");
    fragment.link(contribution.path_clock + ".at_end", "ending.a");
    fragment.feed(fragment.cancel(), "ending.b");
    fragment.add("force_offset", "BoundedOffset",
                 {{"lower", -wish_.retreat},
                  {"upper", wish_.reach},
                  {"velocity_max", wish_.force.velocity_max},
                  {"acceleration_max", wish_.force.acceleration_max},
                  {"jerk_max", wish_.jerk_max}});
    fragment.link("force_law.velocity", "force_offset.velocity");
    fragment.link("ending.value", "force_offset.rest");
    fragment.add("pressed", "OffsetFrame", {{"direction", net::value_to_json(net::Vector(wish_.direction_M))}});
    for (const char* port : {"frame", "twist", "acceleration"}) {
      contribution.set_point.feed(fragment, port, std::string("pressed.") + port);
      contribution.set_point.ports[port] = std::string("pressed.moved_") + port;
    }
    fragment.link("force_offset.value", "pressed.offset");
    fragment.link("force_offset.rate", "pressed.offset_velocity");
    fragment.link("force_offset.acceleration", "pressed.offset_acceleration");
  }

  static std::string add_done(FragmentWriter& fragment, const std::string& path_done) {
    fragment.add("all_done", "And");
    fragment.link(path_done, "all_done.a");
    fragment.link("force_offset.standing", "all_done.b");
    return "all_done.value";
  }

  std::shared_ptr<const ActionModel> motion_;
  ExpressionPtr pressing_;
  ForceOffsetWish wish_;
};

}  // namespace

Action force_offset(const Action& motion, const RealSensor& pressing, const ForceOffsetWish& wish) {
  return Action(std::make_shared<const ForceOffset>(motion.shared_model(), pressing.node(), wish));
}

RealSensor pressing_along(const Cell& cell, const std::string& sensor, const Eigen::Vector3d& direction_M,
                          const Eigen::Isometry3d& X_FM, const Biases& biases) {
  const VectorSensor felt = force(contact_wrench(cell, sensor, biases));
  const auto mounted = cell.sensors.find(sensor);
  if (mounted == cell.sensors.end()) return norm(felt);  // refused by every check: the sensor is not there
  const Eigen::Matrix3d R_SM = mounted->second.X_FS.linear().transpose() * X_FM.linear();
  return dot(felt, Eigen::Vector3d(-(R_SM * direction_M.normalized())));
}

Action weave(const Action& motion, const WeaveWish& wish) {
  return Action(std::make_shared<const Woven>(motion.shared_model(), wish));
}

}  // namespace takt::command
