#include "core/operations/motion/move_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/expression/believed_shapes.h"
#include "core/kinematics/plane.h"
#include "core/kinematics/solutions.h"
#include "core/operations/motion/motion_plan.h"
#include "core/planning/path_search.h"
#include "core/planning/rounded_path.h"

namespace takt::operations {
namespace {

using collision::CellShapes;
using collision::CellState;
using collision::Contact;
using kinematics::JointVector;
using planning::Obstruction;

/// Of the solutions with a pose so many are looked at, and so many that are free are goals of the search.
constexpr int kSolutions = 64;
constexpr std::size_t kGoals = 8;
/// Postures that a search with the effort 1 may look at.
constexpr double kLooks = 100'000.0;
/// A PTP keeps little more than the margin: its path is what it is.
constexpr double kStraightClearance = 2e-4;  // m

bool is_checked(const expression::Cell& cell) { return cell.shapes != nullptr && cell.shapes->off.empty(); }

/// Where postures are looked for: the range of the joints, of joints without end as far as half a turn, or 1 m, beyond
/// what start and goals need.
struct Box {
  JointVector lower, upper;
};
Box box_around(const motion::ArmModel& arm, const JointVector& q, const std::vector<JointVector>& goals) {
  Box box{q, q};
  for (const JointVector& goal : goals) {
    box.lower = box.lower.cwiseMin(goal);
    box.upper = box.upper.cwiseMax(goal);
  }
  const JointVector least = box.lower, most = box.upper;
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const double beyond = arm.chain.is_prismatic(static_cast<int>(j)) ? 1.0 : std::numbers::pi;
    // A start may be outside of the range by rounding.
    box.lower[j] = std::min(least[j], std::max(arm.limits.lower[j], least[j] - beyond));
    box.upper[j] = std::max(most[j], std::min(arm.limits.upper[j], most[j] + beyond));
  }
  return box;
}

/// Machines that carry the arm and drive meanwhile stand where what is swept beside it is seen from.
CellState seen_situation(const MotionTask& request, const expression::Cell& cell, const Surroundings& surroundings) {
  CellState situation = surroundings.situation();
  const auto beside = surroundings.meanwhile.of(request.pointer);
  if (beside == nullptr) return situation;
  for (const auto& [carrier, q] : beside->carriers) expression::set_joints(*cell.shapes, carrier, q, situation.state);
  return situation;
}

/// An arm in its surroundings, and where it can be.
class ArmEnvironment {
 public:
  ArmEnvironment(const expression::Cell& cell, const MotionTask& request, const Surroundings& surroundings,
                 const Box& box, double clearance)
      : shapes_(*cell.shapes),
        situation_(seen_situation(request, cell, surroundings)),
        swept_(surroundings.meanwhile.beside(request.pointer)),
        rules_(shapes_, situation_),
        own_{request.arm},
        space_(shapes_.scene, situation_.state, shapes_.arms.find(request.arm)->second.joints,
               {.margin = shapes_.margin,
                .clearance = clearance,
                .lower = box.lower,
                .upper = box.upper,
                .rule = [this](int a, int b) { return rule(a, b); },
                .swept = swept_.get()}) {}
  ArmEnvironment(const ArmEnvironment&) = delete;
  ArmEnvironment& operator=(const ArmEnvironment&) = delete;

  [[nodiscard]] planning::FreeSpace& space() { return space_; }

  [[nodiscard]] std::string names(const Obstruction& found) const {
    if (found.a < 0) return "the range of a joint";
    return fmt::format("'{}' and '{}'{}", shapes_.scene.body(found.a).name, shapes_.scene.body(found.b).name,
                       meanwhile(found));
  }
  [[nodiscard]] std::string text(const Obstruction& found) const {
    return found.distance <= 0.0 ? fmt::format("{} overlap by {:.2f} mm", names(found), -1e3 * found.distance)
                                 : fmt::format("{} are {:.2f} mm apart", names(found), 1e3 * found.distance);
  }
  [[nodiscard]] double margin() const { return shapes_.margin; }

 private:
  /// Of what moves by itself: in which motion, and when it is in the way.
  [[nodiscard]] std::string meanwhile(const Obstruction& found) const {
    if (found.source < 0) return {};
    const std::string& step = swept_->sources[static_cast<std::size_t>(found.source)];
    if (std::isnan(found.from)) return fmt::format(" (which '{}' moves, it is not known when)", step);
    if (found.to - found.from < 0.005)
      return fmt::format(" (which '{}' moves, {:.2f} s after this begins)", step, found.from);
    return fmt::format(" (which '{}' moves, {:.2f} to {:.2f} s after this begins)", step, found.from, found.to);
  }
  /// Tools and what they hold may be in contact where a motion begins, as after a touch; links may not.
  [[nodiscard]] collision::PairRule rule(int a, int b) const {
    collision::PairRule rule = collision::rule_for(rules_.contact(a, b, {}), collision::kSetDownOverlap);
    rule.may_part = rules_.contact(a, b, own_) != Contact::kForbidden;
    return rule;
  }

  const CellShapes& shapes_;
  CellState situation_;
  std::shared_ptr<const collision::SweptSpace> swept_;
  collision::ContactRules rules_;
  collision::Touching own_;
  planning::FreeSpace space_;
};

/// All joint configurations of a goal, the nearest first.
Result<std::vector<JointVector>> configurations(const MotionTask& request, const expression::Cell& cell,
                                                const JointVector& q) {
  const expression::MountedArm& mounted = cell.arms.find(request.arm)->second;
  const kinematics::Chain& chain = *mounted.device->description().chain;
  const auto resolved = resolve(request.goal, cell, request.arm, q);
  if (!resolved) return std::unexpected(resolved.error());
  const auto* X_BT = std::get_if<Eigen::Isometry3d>(&*resolved);
  if (X_BT != nullptr && (chain.joint_count() >= 6 || kinematics::moves_in_plane(chain))) {
    kinematics::SolutionOptions options;
    options.reference = q;
    options.most = kSolutions;
    auto solutions = kinematics::inverse_solutions(chain, *X_BT * mounted.X_FT.inverse(), options);
    if (!solutions.empty()) return solutions;
  }
  Diagnostics ignored;  // a path of several points tells no more than a PTP in a sequence
  auto only = goal_joints(request.goal, cell, request.arm, q, ignored);
  if (!only) return std::unexpected(std::move(only.error()));
  return std::vector{std::move(*only)};
}

std::unexpected<Diagnostics> at_goal(const Diagnostics& diagnostics) {
  Diagnostics placed;
  placed.append(diagnostics, "/to");
  return std::unexpected(std::move(placed));
}

std::unexpected<Diagnostics> start_collides(const ArmEnvironment& around, const Obstruction& found) {
  return failure(Code::kCollision, "", fmt::format("it begins in a collision: {}", around.text(found)),
                 fmt::format("Choose a start that keeps {:g} mm", 1e3 * around.margin()));
}

std::unexpected<Diagnostics> goal_collides(const ArmEnvironment& around, const Obstruction& found,
                                           std::size_t solutions) {
  const std::string which =
      solutions > 1 ? fmt::format("all {} joint configurations of the goal collide; in the nearest", solutions)
                    : std::string("the goal is in a collision:");
  return failure(Code::kCollision, "/to", fmt::format("{} {}", which, around.text(found)),
                 fmt::format("Choose a goal that keeps {:g} mm, or add an entry to 'allow' in 'collisions'",
                             1e3 * around.margin()));
}

/// Those that are free; what is in the way of the first if none is.
struct FreeGoals {
  std::vector<JointVector> goals;
  std::optional<Obstruction> first;
};
FreeGoals free_goals(ArmEnvironment& around, const std::vector<JointVector>& all) {
  FreeGoals found;
  for (const JointVector& goal : all) {
    if (found.goals.size() == kGoals) break;
    const auto obstruction = around.space().admit_goal(goal);
    if (!obstruction) found.goals.push_back(goal);
    if (obstruction && !found.first) found.first = obstruction;
  }
  return found;
}

std::unexpected<Diagnostics> no_path(const ArmEnvironment& around, const Obstruction& most) {
  return failure(
      Code::kPlanningFailed, "/to",
      fmt::format("no path was found on which nothing collides; most often in the way: {}", around.names(most)),
      "Increase 'effort', choose another 'seed', decrease 'clearance_m', or move over via points");
}

}  // namespace

Surroundings surroundings_at(const expression::Cell& cell, expression::Places places,
                             std::optional<expression::FingerWidths> widths) {
  return {.situation = [&cell, places = std::move(places), widths = std::move(widths)] {
    expression::Places all = places;
    for (const auto& [name, arm] : cell.arms)
      all.try_emplace(name, arm.set_point().size() > 0 ? arm.set_point() : arm.start);
    return expression::believed_situation(cell, all, widths ? *widths : expression::measured_widths(cell));
  }};
}

Result<motion::Leg> move_leg(const MotionTask& request, const expression::Cell& cell, const JointVector& q,
                             const Surroundings& surroundings) {
  const motion::ArmModel arm = expression::planning_model(cell.arms.find(request.arm)->second);
  const auto all = configurations(request, cell, q);
  if (!all) return at_goal(all.error());
  if (!is_checked(cell)) return motion::ptp_leg(arm, q, all->front());
  const Box box = box_around(arm, q, *all);
  ArmEnvironment around(cell, request, surroundings, box, request.avoidance.clearance);
  if (const auto found = around.space().admit_start(q)) return start_collides(around, *found);
  const FreeGoals goals = free_goals(around, *all);
  if (goals.goals.empty()) return goal_collides(around, *goals.first, all->size());
  const planning::Query query{.start = q,
                              .goals = goals.goals,
                              .lower = box.lower,
                              .upper = box.upper,
                              .speed = arm.limits.velocity,
                              .seed = static_cast<std::uint64_t>(request.avoidance.seed),
                              .looks = std::llround(kLooks * request.avoidance.effort)};
  const auto path = planning::find_path(around.space(), query);
  if (!path) return no_path(around, around.space().most_frequent_obstruction());
  return planning::rounded_path(around.space(), arm, path->points);
}

Result<JointVector> free_solution(const MotionTask& request, const expression::Cell& cell, const JointVector& q,
                                  const Surroundings& surroundings) {
  const motion::ArmModel arm = expression::planning_model(cell.arms.find(request.arm)->second);
  const auto all = configurations(request, cell, q);
  if (!all) return at_goal(all.error());
  if (!is_checked(cell)) return all->front();
  ArmEnvironment around(cell, request, surroundings, box_around(arm, q, *all), kStraightClearance);
  if (const auto found = around.space().admit_start(q)) return start_collides(around, *found);
  std::optional<Obstruction> first;
  for (const JointVector& goal : *all) {
    auto obstruction = around.space().admit_goal(goal);
    if (!obstruction && around.space().is_free_line(q, goal)) return goal;
    if (!first) first = obstruction ? *obstruction : around.space().last_obstruction();
  }
  return failure(Code::kCollision, "/to",
                 fmt::format("on the way to each of {} joint configurations something collides; to the nearest {}",
                             all->size(), around.text(*first)),
                 "Use 'move', which goes around obstacles");
}

}  // namespace takt::operations
