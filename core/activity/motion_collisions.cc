#include "core/activity/motion_collisions.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/collision/body_pair.h"
#include "core/command/command_tree.h"

namespace takt::activity {
namespace {

using collision::CellShapes;
using collision::CellState;
using kinematics::JointVector;

/// What the interpolation of a Cartesian piece can add to the accelerations of its plan.
constexpr double kInterpolated = 1.05;

std::optional<ArmTrack> track_of(const expression::Cell& cell, const std::string& arm, const motion::Motion& motion,
                                 const motion::TimeLaw& law, const Eigen::Isometry3d& X_FM) {
  const auto mounted = cell.arms.find(arm);
  if (mounted == cell.arms.end()) return std::nullopt;
  auto joints = motion::JointTrack::follow(expression::planning_model(mounted->second, X_FM), motion, law);
  if (!joints) return std::nullopt;
  return ArmTrack{arm, std::move(*joints)};
}

std::string joints_text(const CellShapes& shapes, const std::string& arm, const std::vector<double>& q) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  std::vector<std::string> values;
  for (const int joint : shapes.arms.find(arm)->second.joints) {
    const auto number = static_cast<std::size_t>(joint);
    const auto moved = std::ranges::find(shapes.scene.bodies(), joint, &collision::Body::joint);
    values.push_back(moved->prismatic ? fmt::format("{:.3f} m", q[number])
                                      : fmt::format("{:.1f}", q[number] / kDegree));
  }
  return fmt::format("'{}' at [{}] deg", arm, fmt::join(values, ", "));
}

/// Whichever arms carry a body, that of its own first.
void add_arms_of(const CellShapes& shapes, const collision::State& state, const std::string& name,
                 std::vector<std::string>& arms) {
  for (int at = shapes.scene.find(name); at >= 0;) {
    const collision::Body& body = shapes.scene.body(at);
    if (shapes.arms.contains(body.owner) && std::ranges::find(arms, body.owner) == arms.end())
      arms.push_back(body.owner);
    at = body.root ? state.fixings[static_cast<std::size_t>(at)].parent : body.parent;
  }
}

/// Where arms are that stand, and bodies of those of which nobody knows it.
expression::Places places_of(const PlanningContext& planning, std::set<std::string>& unknown) {
  expression::Places places;
  for (const auto& [name, arm] : planning.cell.arms) {
    const auto own = planning.predecessors.find(name);
    if (own != planning.predecessors.end() && own->second.at_end.q) {
      places[name] = *own->second.at_end.q;
    } else if (arm.device->held()) {
      unknown.insert(name);
    } else {
      places[name] = arm.set_point().size() > 0 ? arm.set_point() : arm.start;
    }
  }
  return places;
}

/// Motions of one command, from where it begins. What else the command moves meanwhile is left out.
class ActivityCheck {
 public:
  ActivityCheck(const PlannedActivity& planned, const PlanningContext& planning, std::string name)
      : planned_(planned), cell_(planning.cell), name_(std::move(name)) {
    situation_ = believed_situation(cell_, places_of(planning, unknown_), expression::measured_widths(cell_));
    for (const auto& [actuator, before] : planning.predecessors) own_.insert(actuator);
  }

  void check(const command::PlannedMotion& planned, const command::ActuatorModel& actuator,
             Diagnostics& diagnostics) const {
    const CheckedMotion motion{.tracks = tracks_of(planned, actuator, cell_),
                               .parts = {{0.0, name_, {}}},
                               .touching = planned_.touching,
                               .ends_at_touch = true};
    if (motion.tracks.empty()) return;
    const CellState situation = without_others(motion);
    const double end = first_touch(cell_, situation, motion).time;
    const collision::ContactRules rules(*cell_.shapes, situation);
    collision::CheckOptions options{.margin = cell_.shapes->margin, .rule = {}, .bodies = {}};
    options.rule = [&](int a, int b) {
      const collision::Contact contact = rules.contact(a, b, motion.touching);
      return collision::rule_for(contact == collision::Contact::kMeant ? collision::Contact::kIgnored : contact,
                                 collision::kSetDownOverlap);
    };
    const auto hits = check_motion(cell_.shapes->scene, situation.state,
                                   trajectory_of(cell_, {{&motion, 0.0, end}}, 0.0, end), options);
    if (!hits.empty()) report(hits.front(), diagnostics);
  }

 private:
  [[nodiscard]] CellState without_others(const CheckedMotion& motion) const {
    std::set<std::string> others = own_;
    others.insert(unknown_.begin(), unknown_.end());
    for (const ArmTrack& track : motion.tracks) others.erase(track.arm);
    CellState situation = situation_;
    const collision::ContactRules rules(*cell_.shapes, situation);
    for (int body = 0; body < static_cast<int>(cell_.shapes->scene.bodies().size()); ++body)
      if (others.contains(rules.arm_of(body))) situation.unknown.insert(body);
    return situation;
  }
  /// The first says it: what follows of a collision is no news.
  void report(const collision::Hit& hit, Diagnostics& diagnostics) const {
    FoundCollision found{.step = name_,
                         .pointer = {},
                         .a = cell_.shapes->scene.body(hit.a).name,
                         .b = cell_.shapes->scene.body(hit.b).name,
                         .time = hit.time,
                         .distance = hit.distance,
                         .state = situation_.state};
    found.state.q = hit.q;
    diagnostics.add(diagnostic_of(found, *cell_.shapes, Severity::kError));
  }

  const PlannedActivity& planned_;
  const expression::Cell& cell_;
  std::string name_;
  std::set<std::string> own_, unknown_;  ///< arms
  CellState situation_;
};

}  // namespace

const CheckedMotion::Part& CheckedMotion::part_at(double time) const {
  const auto later = std::ranges::upper_bound(parts, time, {}, &Part::begin);
  return later == parts.begin() ? parts.front() : *(later - 1);
}

std::vector<ArmTrack> tracks_of(const command::PlannedMotion& motion, const command::ActuatorModel& actuator,
                                const expression::Cell& cell) {
  std::vector<std::string> devices = actuator.devices();
  std::erase_if(devices, [&cell](const std::string& name) { return !cell.arms.contains(name); });
  std::vector<ArmTrack> tracks;
  if (devices.size() < (motion.partner ? 2 : 1)) return tracks;
  if (auto first = track_of(cell, devices.front(), *motion.motion, motion.motion->law, motion.X_FM))
    tracks.push_back(std::move(*first));
  if (!motion.partner || tracks.empty()) return tracks;
  auto second = track_of(cell, devices.at(1), *motion.partner->motion, motion.motion->law, motion.partner->X_FM);
  if (!second) return {};
  tracks.push_back(std::move(*second));
  return tracks;
}

CellState situation_before(const PlanningContext& planning) {
  expression::Places places;
  for (const auto& [name, arm] : planning.cell.arms) {
    const auto own = planning.predecessors.find(name);
    const bool ends = own != planning.predecessors.end() && own->second.at_end.q;
    places[name] = ends ? *own->second.at_end.q : arm.set_point().size() > 0 ? arm.set_point() : arm.start;
  }
  return believed_situation(planning.cell, places, expression::measured_widths(planning.cell));
}

double width_around(const CellShapes& shapes, const CellState& situation, const std::string& gripper,
                    const std::string& object, double widest) {
  const auto fingers = shapes.grippers.find(gripper);
  const int part = shapes.scene.root_of(object);
  if (fingers == shapes.grippers.end() || part < 0) return 0.0;
  collision::State state = situation.state;
  collision::Poses poses;
  const auto touches_at = [&](double width) {
    for (const int joint : fingers->second) state.q[static_cast<std::size_t>(joint)] = 0.5 * width;
    shapes.scene.place(state, poses);
    return std::ranges::any_of(fingers->second, [&](int joint) {
      const auto& bodies = shapes.scene.bodies();
      const auto finger = static_cast<int>(std::ranges::find(bodies, joint, &collision::Body::joint) - bodies.begin());
      return collision::distance(shapes.scene, poses, finger, part) <= 0.0;
    });
  };
  if (!touches_at(0.0)) return 0.0;
  constexpr int kHalvings = 16;  // a micrometre of 80 mm
  double low = 0.0, high = widest;
  for (int i = 0; i < kHalvings; ++i) (touches_at(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
  return high;
}

collision::Trajectory trajectory_of(const expression::Cell& cell, std::vector<PlayedTrack> motions, double from,
                                    double to) {
  const CellShapes& shapes = *cell.shapes;
  collision::Trajectory trajectory{.duration = to - from, .at = {}};
  struct Moved {
    const motion::JointTrack* track;
    const std::vector<int>* joints;
    double begin, stops;
  };
  std::vector<Moved> moved;
  for (const PlayedTrack& played : motions) {
    for (const ArmTrack& track : played.motion->tracks) {
      const auto arm = shapes.arms.find(track.arm);
      if (arm == shapes.arms.end()) continue;
      const JointVector& most = cell.arms.find(track.arm)->second.device->description().limits.acceleration;
      for (std::size_t j = 0; j < arm->second.joints.size(); ++j) {
        trajectory.joints.push_back(arm->second.joints[j]);
        trajectory.acceleration.push_back(kInterpolated * most[static_cast<Eigen::Index>(j)]);
      }
      moved.push_back({&track.joints, &arm->second.joints, played.begin, played.stops});
    }
  }
  trajectory.acceleration_between = [all = moved, from, most = trajectory.acceleration](double begin, double end,
                                                                                        std::vector<double>& out) {
    std::size_t next = 0;
    for (const Moved& one : all) {
      const auto on_track = [&](double time) { return std::clamp(from + time - one.begin, 0.0, one.stops); };
      const JointVector largest = one.track->largest_acceleration(on_track(begin), on_track(end));
      for (std::size_t j = 0; j < one.joints->size(); ++j, ++next)
        out[next] = std::min(most[next], kInterpolated * largest[static_cast<Eigen::Index>(j)]);
    }
  };
  trajectory.at = [all = std::move(moved), from](double time, std::vector<double>& q) {
    for (const Moved& one : all) {
      const JointVector joints = one.track->at(std::clamp(from + time - one.begin, 0.0, one.stops));
      for (std::size_t j = 0; j < one.joints->size(); ++j)
        q[static_cast<std::size_t>((*one.joints)[j])] = joints[static_cast<Eigen::Index>(j)];
    }
  };
  return trajectory;
}

FirstTouch first_touch(const expression::Cell& cell, const CellState& begin, const CheckedMotion& motion) {
  FirstTouch touch{.time = motion.duration()};
  if (motion.touching.empty()) return touch;
  const CellShapes& shapes = *cell.shapes;
  const collision::ContactRules rules(shapes, begin);
  collision::CheckOptions options{.margin = shapes.margin, .rule = {}, .bodies = {}};
  options.rule = [&](int a, int b) -> collision::PairRule {
    if (rules.contact(a, b, motion.touching) != collision::Contact::kMeant)
      return {.kind = collision::PairRule::Kind::kIgnored};
    return {.may_part = true};
  };
  const auto trajectory = trajectory_of(cell, {{&motion, 0.0, motion.duration()}}, 0.0, motion.duration());
  for (collision::Hit& hit : check_motion(shapes.scene, begin.state, trajectory, options)) {
    if (hit.time < motion.touch_from) {
      touch.too_soon.push_back(std::move(hit));
    } else if (motion.ends_at_touch) {
      touch.time = hit.time;
      break;
    }
  }
  return touch;
}

Diagnostic diagnostic_of(const FoundCollision& found, const CellShapes& shapes, Severity severity,
                         const std::string& meanwhile) {
  std::vector<std::string> arms, places;
  for (const std::string& body : {found.a, found.b}) add_arms_of(shapes, found.state, body, arms);
  for (const std::string& arm : arms) places.push_back(joints_text(shapes, arm, found.state.q));
  const std::string what = found.distance <= 0.0 ? fmt::format("overlap by {:.2f} mm", -1e3 * found.distance)
                                                 : fmt::format("come within {:.2f} mm", 1e3 * found.distance);
  const std::string when =
      found.step.empty() ? "at the start" : fmt::format("{:.3f} s after '{}' begins", found.time, found.step);
  const std::string too = meanwhile.empty() ? "" : fmt::format(", while '{}' moves", meanwhile);
  return {
      .severity = severity,
      .code = Code::kCollision,
      .file = {},
      .pointer = found.pointer,
      .message = fmt::format("'{}' and '{}' {} {}{}{}{}", found.a, found.b, what, when, too, places.empty() ? "" : "; ",
                             fmt::join(places, ", ")),
      .hint = fmt::format("Choose a path that keeps {:g} mm between them, or add an entry to 'allow' in 'collisions'",
                          1e3 * shapes.margin)};
}

Diagnostics find_collisions(const PlannedActivity& planned, const PlanningContext& planning, const std::string& name) {
  Diagnostics diagnostics;
  const auto& shapes = planning.cell.shapes;
  if (!planning.checks_collisions || !planned.command || shapes == nullptr || !shapes->off.empty()) return diagnostics;
  const command::CommandTree tree(*planned.command);
  std::optional<ActivityCheck> check;  // most commands have no planned motion
  for (const command::CommandTree::Entry& entry : tree.entries()) {
    const command::PlannedMotion* motion = entry.node->is_runtime() ? entry.node->model().planned_motion() : nullptr;
    if (motion == nullptr) continue;
    if (!check) check.emplace(planned, planning, name);
    check->check(*motion, entry.node->actuator->model(), diagnostics);
  }
  return diagnostics;
}

}  // namespace takt::activity
