#include "core/command/actions/overlay_action.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/command/actions/linked_primitive.h"
#include "core/command/actions/velocity_action.h"
#include "core/device/description.h"
#include "core/expression/device_sensors.h"
#include "core/expression/frame_stretches.h"
#include "core/kinematics/inverse.h"
#include "core/motion/motion_state.h"
#include "core/motion/path_clock.h"
#include "core/net/value_json.h"

namespace takt::command {
namespace {

using Json = nlohmann::ordered_json;

/// One thing at a time is laid over a motion.
void check_is_bare(const ActionModel& motion, Diagnostics& diagnostics) {
  if (motion.planned_path().laid_over)
    diagnostics.error(Code::kConflict, {}, fmt::format("something is laid over {} already", motion.name()),
                      "Lay one force offset or one weave over a motion");
}

class WeavingMotion final : public ActionModel {
 public:
  /// @param plan  nothing: it is made when it is known how the motion goes
  WeavingMotion(std::shared_ptr<const ActionModel> motion, Weaves weaves, std::optional<WeavePlan> plan)
      : motion_(std::move(motion)), weaves_(std::move(weaves)), plan_(std::move(plan)) {}

  [[nodiscard]] std::string_view name() const override { return motion_->name(); }
  [[nodiscard]] SetPointKind gives(const ActuatorModel& actuator) const override { return motion_->gives(actuator); }
  [[nodiscard]] std::optional<device::ControlMode> mode() const override { return motion_->mode(); }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override { return motion_->formulas(); }
  [[nodiscard]] std::vector<std::string> states() const override { return motion_->states(); }
  [[nodiscard]] int via_count() const override { return motion_->via_count(); }
  [[nodiscard]] std::string add_state(expression::FragmentWriter& fragment, const std::string& name,
                                      const Json& parameters) const override {
    return motion_->add_state(fragment, name, parameters);
  }
  [[nodiscard]] std::vector<device::Seam> begins() const override { return motion_->begins(); }
  [[nodiscard]] std::vector<device::Seam> ends() const override { return motion_->ends(); }
  [[nodiscard]] double stop_time(const ActuatorModel& actuator) const override {
    const PlannedPath path = motion_->planned_path();
    if (!plan_ || path.motion == nullptr) return motion_->stop_time(actuator);
    return motion::PathClock(plan_->clock, path.motion->duration(), false).stop_time_bound();
  }
  [[nodiscard]] PlannedPath planned_path() const override {
    PlannedPath path = motion_->planned_path();
    path.laid_over = true;
    return path;
  }
  [[nodiscard]] const PlannedMotion* planned_motion() const override { return motion_->planned_motion(); }
  [[nodiscard]] double duration() const override { return motion_->duration(); }
  [[nodiscard]] bool needs_plan() const override { return !plan_; }
  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> plan(const ActuatorModel& actuator,
                                                                const expression::Places& q) const override {
    auto motion = motion_;
    if (motion->needs_plan()) {
      auto planned = motion->plan(actuator, q);
      if (!planned) return planned;
      motion = std::move(*planned);
    }
    std::optional<WeavePlan> plan;
    const PlannedPath path = motion->planned_path();
    // check() reports what is wrong with the figures.
    if (path.motion != nullptr && !own_faults(*motion, actuator).has_errors()) {
      auto made = plan_weaves(*actuator.arm(), path, weaves_);
      if (!made) return std::unexpected(in_place(made.error(), path));
      plan = std::move(*made);
    }
    return std::make_shared<const WeavingMotion>(std::move(motion), weaves_, plan.value_or(WeavePlan{}));
  }

  [[nodiscard]] Diagnostics check(const ActuatorModel& actuator) const override {
    Diagnostics diagnostics = motion_->check(actuator);
    diagnostics.append(own_faults(*motion_, actuator));
    return diagnostics;
  }

  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment,
                                    const ActuatorModel& actuator) const override {
    Contribution contribution = motion_->add_to(fragment, actuator);
    fragment.set_parameter(contribution.path_clock, "bounds", motion::to_json(plan_->clock));
    for (std::size_t i = 0; i < plan_->windows.size(); ++i)
      add_weave(fragment, plan_->windows[i], i == 0 ? "" : fmt::format("_{}", i + 1), contribution);
    return contribution;
  }

 private:
  /// Where several lie over one motion the others add nothing meanwhile.
  static void add_weave(expression::FragmentWriter& fragment, const WeaveWindow& window, const std::string& number,
                        Contribution& contribution) {
    const std::string weave = "weave" + number, offset = "offset" + number;
    fragment.add(weave, "Weave",
                 {{"amplitude", window.weave.amplitude},
                  {"frequency", window.weave.frequency},
                  {"begin", window.begin},
                  {"duration", window.end - window.begin},
                  {"ramp", window.weave.ramp}});
    fragment.link_all(contribution.path_clock, weave, {"time", "rate", "rate_derivative"});
    fragment.add(offset, "OffsetFrame", {{"direction", net::value_to_json(net::Vector(window.weave.direction_M))}});
    for (const char* port : {"frame", "twist", "acceleration"}) {
      contribution.set_point.feed(fragment, port, offset + "." + port);
      contribution.set_point.ports[port] = offset + ".moved_" + port;
    }
    fragment.link(weave + ".value", offset + ".offset");
    fragment.link(weave + ".velocity", offset + ".offset_velocity");
    fragment.link(weave + ".acceleration", offset + ".offset_acceleration");
  }

  /// What is wrong whatever the motion is like.
  [[nodiscard]] Diagnostics own_faults(const ActionModel& motion, const ActuatorModel& actuator) const {
    Diagnostics diagnostics;
    const SetPointKind gives = motion.gives(actuator);
    const bool of_frame = gives == SetPointKind::kPose || gives == SetPointKind::kPath;
    if (!of_frame || motion.planned_path().motion == nullptr) {
      diagnostics.error(Code::kConflict, {},
                        fmt::format("C8: {} moves joints, so there is no Cartesian path to weave about", name()),
                        "Lay it over a Cartesian motion");
      return diagnostics;
    }
    check_is_bare(motion, diagnostics);
    const std::size_t motions = motion.planned_path().handed_over.size() + 1;
    if (weaves_.size() > 1 && weaves_.size() != motions) {
      diagnostics.error(Code::kWrongSize, {}, fmt::format("{} weaves for {} motions", weaves_.size(), motions),
                        "Give one for each, or one");
    }
    for (std::size_t i = 0; i < weaves_.size(); ++i) {
      if (!weaves_[i] || (i > 0 && weaves_[i] == weaves_[i - 1])) continue;
      Diagnostics own = check_figures(*weaves_[i]);
      if (!own.has_errors()) own = check_alone(*weaves_[i], actuator.arm()->device->description().cartesian);
      diagnostics.append(own, weaves_.size() == 1 ? "" : pointer_segment(i));
    }
    return diagnostics;
  }

  /// A motion that is alone has no number.
  static Diagnostics in_place(const Diagnostics& found, const PlannedPath& path) {
    if (!path.handed_over.empty()) return found;
    Diagnostics placed;
    for (Diagnostic diagnostic : found.list()) {
      diagnostic.pointer.erase(0, pointer_segment(0).size());
      placed.add(std::move(diagnostic));
    }
    return placed;
  }

  std::shared_ptr<const ActionModel> motion_;
  Weaves weaves_;
  std::optional<WeavePlan> plan_;
};

/// What an offset along a direction of the moving frame may add to what the joints do on a path. The path's law and its
/// clock keep the shares of the limits that the motion was planned with, whatever the clock does (docs/motion.md).
class OffsetBudget {
 public:
  /// @param begin  path time from which the offset is there, s
  OffsetBudget(const expression::MountedArm& arm, const ActionModel::PlannedPath& path,
               const ForceOffsetControlParameters& parameters, double begin)
      : arm_(expression::planning_model(arm, path.X_FM)),
        motion_(*path.motion),
        parameters_(parameters),
        begin_(begin),
        places_(kPlaces * static_cast<int>(path.handed_over.size() + 1)) {
    const auto pieces = motion::pieces_of(motion_.path);
    const double from = motion_.law.at(begin_).s;
    for (std::size_t i = 0; i < motion_.shares.size(); ++i)
      if (pieces[i].s_end > from) share_ = std::max(share_, motion_.shares[i].acceleration);
    if (motion_.shares.empty()) share_ = 1.0;
  }

  /// What the offset may have of the jerk: as much as was wished for, or what the motion leaves.
  [[nodiscard]] double jerk() const {
    double least = std::min(parameters_.jerk_max, (1.0 - share_) * arm_.cartesian.linear_jerk);
    const ForceControlParameters& force = parameters_.force;
    for_each_place([&](double, const motion::JointSample&, const JointOffset& offset) {
      for (Eigen::Index i = 0; i < offset.per_metre.size(); ++i) {
        const double s = std::abs(offset.per_metre[i]);
        const double path =
            3.0 * (std::abs(offset.rate[i]) * force.acceleration_max + std::abs(offset.bend[i]) * force.velocity_max);
        if (s > kLeastShare) least = std::min(least, ((1.0 - share_) * arm_.limits.jerk[i] / kMargin - path) / s);
      }
      return true;
    });
    return std::max(least, kLeastJerk * parameters_.jerk_max);
  }

  [[nodiscard]] Diagnostics check() {
    Diagnostics diagnostics;
    const ForceControlParameters& force = parameters_.force;
    const double may = jerk();
    check_use(diagnostics, "acceleration", -1, 0.0, force.acceleration_max,
              (1.0 - share_) * arm_.cartesian.linear_acceleration);
    check_use(diagnostics, "jerk", -1, 0.0, may, (1.0 - share_) * arm_.cartesian.linear_jerk);
    for_each_place([&](double at, const motion::JointSample& sample, const JointOffset& offset) {
      for (Eigen::Index i = 0; i < offset.per_metre.size(); ++i) {
        const double s = std::abs(offset.per_metre[i]), ds = std::abs(offset.rate[i]), dds = std::abs(offset.bend[i]);
        const double v = force.velocity_max, a = force.acceleration_max, j = may;
        const double x = std::max(parameters_.reach, parameters_.retreat);
        const int joint = static_cast<int>(i);
        const double share = at / std::max(motion_.duration(), kLeastStep_s);
        check_use(diagnostics, "velocity", joint, share, kMargin * (s * v + ds * x),
                  arm_.limits.velocity[i] - std::abs(sample.dq[i]));
        check_use(diagnostics, "acceleration", joint, share, kMargin * (s * a + 2.0 * ds * v + dds * x),
                  (1.0 - share_) * arm_.limits.acceleration[i]);
        check_use(diagnostics, "jerk", joint, share, kMargin * (s * j + 3.0 * ds * a + 3.0 * dds * v),
                  (1.0 - share_) * arm_.limits.jerk[i]);
      }
      return diagnostics.empty();
    });
    return diagnostics;
  }

 private:
  using JointVector = kinematics::JointVector;
  static constexpr double kLeastStep_s = 1e-3;
  static constexpr int kPlaces = 100;  ///< on each motion
  /// What differs between samples, and at the offset from on the path.
  static constexpr double kMargin = 1.1;
  static constexpr double kRounding = 1e-9;
  static constexpr double kLeastJerk = 0.25;   ///< of what was wished for
  static constexpr double kLeastShare = 1e-9;  ///< rad/m: a joint that does not take part

  /// How far the joints go for a metre along the direction; its first two derivatives by time, as the path moves.
  struct JointOffset {
    JointVector per_metre, rate, bend;
  };
  /// @param visit  at (s), sample, offset; false: it is enough
  template <typename Visit>
  void for_each_place(const Visit& visit) const {
    const double step = std::max((motion_.duration() - begin_) / places_, kLeastStep_s);
    for (double at = begin_; at <= motion_.duration(); at += step) {
      const auto sample = motion::joints_at(arm_, motion_, at);
      const auto offset = sample ? offset_at(*sample) : std::nullopt;
      if (!offset || !visit(at, *sample, *offset)) return;  // no plan lets the first happen
    }
  }
  /// The derivatives from a moment before and one after, so that they are right wherever the offset begins.
  [[nodiscard]] std::optional<JointOffset> offset_at(const motion::JointSample& path) const {
    constexpr double h = kLeastStep_s;
    const JointVector curve = 0.5 * h * h * path.ddq;
    const auto now = joints_per_metre(path.q);
    const auto before = joints_per_metre(path.q - h * path.dq + curve);
    const auto after = joints_per_metre(path.q + h * path.dq + curve);
    if (!now || !before || !after) return std::nullopt;
    return JointOffset{*now, (*after - *before) / (2.0 * h), (*after - 2.0 * *now + *before) / (h * h)};
  }

  /// How far the joints go for a metre along the direction.
  [[nodiscard]] std::optional<JointVector> joints_per_metre(const JointVector& q) const {
    if (arm_.inverse == nullptr) return std::nullopt;
    kinematics::Vector6 V = kinematics::Vector6::Zero();
    V.head<3>() = (arm_.chain.forward(q) * arm_.X_FM).linear() * parameters_.direction_M;
    const JointVector held = JointVector::Zero(static_cast<Eigen::Index>(arm_.inverse->held_joints().size()));
    JointVector rates = q;
    if (arm_.inverse->rates(q, V, held, rates) != kinematics::IkStatus::kOk) return std::nullopt;
    return rates;
  }

  /// @param joint  -1: the frame that moves
  static void check_use(Diagnostics& diagnostics, const char* what, int joint, double share, double value,
                        double room) {
    if (value <= room * (1.0 + kRounding)) return;
    const std::string whose = joint < 0 ? "the tool" : fmt::format("joint {}", joint + 1);
    diagnostics.error(
        Code::kLimitExceeded, {},
        fmt::format("the offset may need {:.3g} of the {} of {}, where the motion leaves {:.3g} (at {:.0f} % "
                    "of its time)",
                    value, what, whose, std::max(room, 0.0), 100.0 * share),
        "Make the motion slower, decrease its share of the acceleration, or narrow the bounds of the offset");
  }

  motion::ArmModel arm_;
  const motion::Motion& motion_;
  const ForceOffsetControlParameters& parameters_;
  double begin_;
  int places_;
  double share_ = 0.0;  ///< of the limits of acceleration and jerk that the motion may use
};

class ForceOffset final : public ActionModel {
 public:
  ForceOffset(std::shared_ptr<const ActionModel> motion, expression::ExpressionPtr pressing,
              const ForceOffsetControlParameters& parameters, std::size_t first)
      : motion_(std::move(motion)), pressing_(std::move(pressing)), parameters_(parameters), first_(first) {}

  [[nodiscard]] std::string_view name() const override { return motion_->name(); }
  [[nodiscard]] SetPointKind gives(const ActuatorModel& actuator) const override { return motion_->gives(actuator); }
  [[nodiscard]] std::optional<device::ControlMode> mode() const override { return motion_->mode(); }
  [[nodiscard]] int via_count() const override { return motion_->via_count(); }
  [[nodiscard]] std::vector<expression::ExpressionPtr> formulas() const override {
    std::vector<expression::ExpressionPtr> formulas = motion_->formulas();
    formulas.push_back(pressing_);
    return formulas;
  }
  [[nodiscard]] std::vector<std::string> states() const override {
    std::vector<std::string> states = motion_->states();
    states.insert(states.end(), {"in_contact", "at_force", "no_force", "lost_contact"});
    if (parameters_.off_max) states.emplace_back("off_force");
    return states;
  }
  [[nodiscard]] std::string add_state(expression::FragmentWriter& fragment, const std::string& name,
                                      const Json& parameters) const override {
    if (name == "in_contact") return "force_law.contact";
    if (name == "at_force") return "force_law.at_force";
    if (name == "lost_contact") return add_left(fragment, "lost", "force_law.contact", parameters_.lost_max);
    if (name == "off_force") return add_left(fragment, "off", "force_law.at_force", *parameters_.off_max);
    return name == "no_force" ? "no_force.value" : motion_->add_state(fragment, name, parameters);
  }
  [[nodiscard]] std::vector<device::Seam> begins() const override { return motion_->begins(); }
  [[nodiscard]] PlannedPath planned_path() const override {
    PlannedPath path = motion_->planned_path();
    path.laid_over = true;
    return path;
  }
  [[nodiscard]] const PlannedMotion* planned_motion() const override { return motion_->planned_motion(); }
  [[nodiscard]] double stop_time(const ActuatorModel& actuator) const override { return motion_->stop_time(actuator); }
  [[nodiscard]] double duration() const override { return motion_->duration(); }
  [[nodiscard]] bool needs_plan() const override { return motion_->needs_plan(); }
  [[nodiscard]] Result<std::shared_ptr<const ActionModel>> plan(const ActuatorModel& actuator,
                                                                const expression::Places& q) const override {
    auto planned = motion_->plan(actuator, q);
    if (!planned) return planned;
    return std::make_shared<const ForceOffset>(std::move(*planned), pressing_, parameters_, first_);
  }

  [[nodiscard]] Diagnostics check(const ActuatorModel& actuator) const override {
    Diagnostics diagnostics = motion_->check(actuator);
    const PlannedPath path = motion_->planned_path();
    if (path.motion == nullptr || !begin_of(path)) {
      diagnostics.error(Code::kConflict, {},
                        fmt::format("C8: {} moves joints, so there is no Cartesian path to shift", name()),
                        "Lay it over a Cartesian motion");
      return diagnostics;
    }
    if (!(parameters_.reach >= 0.0 && parameters_.retreat >= 0.0 && parameters_.reach + parameters_.retreat > 0.0)) {
      diagnostics.error(Code::kOutOfRange, {},
                        fmt::format("a force offset from {:g} to {:g} m", 0.0 - parameters_.retreat, parameters_.reach),
                        "Give a reach and a retreat from 0, not both 0");
    }
    check_is_bare(*motion_, diagnostics);
    if (!path.laid_over && actuator.arm() != nullptr)
      diagnostics.append(OffsetBudget(*actuator.arm(), path, parameters_, *begin_of(path)).check());
    return diagnostics;
  }

  [[nodiscard]] Contribution add_to(expression::FragmentWriter& fragment,
                                    const ActuatorModel& actuator) const override {
    Contribution contribution = motion_->add_to(fragment, actuator);
    // The offset counts on what the motion leaves of the limits, and stops by the table leave nothing.
    fragment.set_parameter(contribution.path_clock, "law", nullptr);
    add_force_law(fragment, actuator, pressing_, parameters_.force);
    fragment.add("pressed_direction", "RotateVector",
                 {{"vector", net::value_to_json(net::Vector(parameters_.direction_M))}});
    contribution.set_point.feed(fragment, "frame", "pressed_direction.frame");
    fragment.link("pressed_direction.value", "servo.direction");
    fragment.add("path_motion", "TwistComponents");
    contribution.set_point.feed(fragment, "twist", "path_motion.input");
    fragment.link("path_motion.linear", "force_law.path_velocity");
    add_begin(fragment, contribution.path_clock);
    add_stand(fragment, contribution.path_clock);
    const auto* arm = actuator.arm();
    const PlannedPath path = motion_->planned_path();
    add_offset(fragment, contribution,
               arm == nullptr ? parameters_.jerk_max : OffsetBudget(*arm, path, parameters_, begin()).jerk());
    contribution.done = expression::Signal::at(add_done(fragment, contribution.done.port));
    return contribution;
  }

 private:
  /// True once a state that has been there is not there any more for so long, before the end.
  static std::string add_left(expression::FragmentWriter& fragment, const std::string& name, const std::string& state,
                              double longest) {
    const std::string known = name + "_known", seen = name + "_seen", gone = name + "_gone", after = name + "_after",
                      away = name + "_away", stays = name + "_stays", over = name + "_over";
    add_linked(fragment, known, "DefaultToBoolean", {{"input", state}}, {{"fallback", false}});
    add_linked(fragment, seen, "SetResetLatch", {{"set", known + ".value"}}, {{"reset", false}});
    add_linked(fragment, gone, "Not", {{"input", known + ".value"}});
    add_linked(fragment, after, "And", {{"a", seen + ".value"}, {"b", gone + ".value"}});
    add_linked(fragment, stays, "Not", {{"input", "ending.value"}});
    add_linked(fragment, away, "And", {{"a", after + ".value"}, {"b", stays + ".value"}});
    add_linked(fragment, over, "OnDelay", {{"input", away + ".value"}}, {{"delay", longest}});
    return over + ".value";
  }
  /// Path time from which the motion is one of the frame to its end, with motion first_ or in it; nothing: it is not.
  [[nodiscard]] std::optional<double> begin_of(const PlannedPath& path) const {
    if (first_ > path.handed_over.size()) return std::nullopt;
    const double wanted = first_ == 0 ? 0.0 : path.handed_over[first_ - 1];
    const double after = first_ == path.handed_over.size() ? path.motion->duration() : path.handed_over[first_];
    const auto stretches = expression::stretches_of_frame(*path.motion);
    if (stretches.empty() || stretches.back().end < path.motion->duration()) return std::nullopt;
    const double begin = std::max(wanted, stretches.back().begin);
    const bool from_rest = first_ == 0 && begin > 0.0;  // a motion of joints of its own comes first
    return from_rest || begin > after ? std::nullopt : std::optional(begin);
  }
  [[nodiscard]] double begin() const { return begin_of(motion_->planned_path()).value_or(0.0); }

  /// Before it begins the force is not needed.
  void add_begin(expression::FragmentWriter& fragment, const std::string& clock) const {
    const std::string unknown = begin() > 0.0 ? "force_unknown" : "no_force";
    fragment.add(unknown, "IsNullReal");
    fragment.feed(pressing_, unknown + ".input");
    if (begin() == 0.0) return;
    add_linked(fragment, "force_begun", "AtLeast", {{"a", clock + ".time"}}, {{"b", begin()}});
    fragment.add("no_force", "And");
    fragment.link_delayed("force_begun.value", "no_force.a", false);  // it acts on the clock that it depends on
    fragment.link("force_unknown.value", "no_force.b");
  }

  /// While the force is not known the path clock stops.
  void add_stand(expression::FragmentWriter& fragment, const std::string& clock) const {
    const std::string rate = fragment.take_link(clock + ".target_rate");
    add_linked(fragment, "rate_with_force", "SelectReal", {{"condition", "no_force.value"}, {"if_false", rate}},
               {{"if_true", 0.0}});
    fragment.link("rate_with_force.value", clock + ".target_rate");
  }

  void add_offset(expression::FragmentWriter& fragment, Contribution& contribution, double jerk) const {
    add_linked(fragment, "ending", "Or", {{"a", contribution.path_clock + ".at_end"}});
    fragment.feed(fragment.cancel(), "ending.b");
    std::string rests = "ending.value";
    if (begin() > 0.0) {
      add_linked(fragment, "not_yet", "Not", {{"input", "force_begun.value"}});
      add_linked(fragment, "rests", "Or", {{"a", "not_yet.value"}, {"b", "ending.value"}});
      rests = "rests.value";
    }
    add_linked(fragment, "force_offset", "BoundedOffset", {{"velocity", "force_law.velocity"}, {"rest", rests}},
               {{"lower", -parameters_.retreat},
                {"upper", parameters_.reach},
                {"velocity_max", parameters_.force.velocity_max},
                {"acceleration_max", parameters_.force.acceleration_max},
                {"jerk_max", jerk}});
    fragment.link_delayed("force_offset.held_back", "force_law.held_back", false);
    fragment.link_delayed("force_offset.rate", "force_law.moves", 0.0);
    fragment.add("pressed", "OffsetFrame", {{"direction", net::value_to_json(net::Vector(parameters_.direction_M))}});
    for (const char* port : {"frame", "twist", "acceleration"}) {
      contribution.set_point.feed(fragment, port, std::string("pressed.") + port);
      contribution.set_point.ports[port] = std::string("pressed.moved_") + port;
    }
    fragment.link("force_offset.value", "pressed.offset");
    fragment.link("force_offset.rate", "pressed.offset_velocity");
    fragment.link("force_offset.acceleration", "pressed.offset_acceleration");
  }

  static std::string add_done(expression::FragmentWriter& fragment, const std::string& path_done) {
    add_linked(fragment, "all_done", "And", {{"a", path_done}, {"b", "force_offset.standing"}});
    return "all_done.value";
  }

  std::shared_ptr<const ActionModel> motion_;
  expression::ExpressionPtr pressing_;
  ForceOffsetControlParameters parameters_;
  std::size_t first_;
};

}  // namespace

Action force_offset(const Action& motion, const expression::RealSensor& pressing,
                    const ForceOffsetControlParameters& parameters, std::size_t first) {
  return Action(std::make_shared<const ForceOffset>(motion.shared_model(), pressing.node(), parameters, first));
}

expression::RealSensor pressing_along(const expression::Cell& cell, const std::string& sensor,
                                      const Eigen::Vector3d& direction_M, const Eigen::Isometry3d& X_FM,
                                      const expression::Biases& biases) {
  const expression::VectorSensor felt = expression::force(expression::contact_wrench(cell, sensor, biases));
  const auto mounted = cell.sensors.find(sensor);
  if (mounted == cell.sensors.end()) return expression::norm(felt);  // refused by every check: the sensor is not there
  const Eigen::Matrix3d R_SM = mounted->second.X_FS.linear().transpose() * X_FM.linear();
  return expression::dot(felt, Eigen::Vector3d(-(R_SM * direction_M.normalized())));
}

Action weave(const Action& motion, const WeaveParameters& parameters) { return weave_each(motion, {parameters}); }

Action weave_each(const Action& motion, const Weaves& weaves) {
  return Action(std::make_shared<const WeavingMotion>(motion.shared_model(), weaves, std::nullopt));
}

Action woven(const Action& motion, const WeavePlan& plan) {
  return Action(std::make_shared<const WeavingMotion>(motion.shared_model(), Weaves{}, plan));
}

}  // namespace takt::command
