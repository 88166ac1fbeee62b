#include "core/operations/motion/clear_blends.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/activity/motion_collisions.h"

namespace takt::operations {
namespace {

using kinematics::JointVector;
using motion::LegMaker;
using motion::SequencePlan;

/// A blend that collides is halved; below this share of what was asked for the arm stops at the corner.
constexpr double kLeastShare = 0.125;

/// Shares of the blends that were asked for, by motion.
using BlendShares = std::vector<double>;

bool ends_a_move(const std::vector<MotionTask>& requests, std::size_t corner) {
  if (corner + 1 >= requests.size() || !requests[corner].blend.wanted()) return false;
  return requests[corner].kind == PathKind::kMove || requests[corner + 1].kind == PathKind::kMove;
}

/// The corners that may be made sharper.
std::vector<std::size_t> corners_of_moves(const std::vector<MotionTask>& requests) {
  std::vector<std::size_t> corners;
  for (std::size_t i = 0; i < requests.size(); ++i)
    if (ends_a_move(requests, i)) corners.push_back(i);
  return corners;
}

/// The legs with these shares of their blends; the geometry is made once.
std::vector<LegMaker> with_shares(const std::vector<LegMaker>& makers, const BlendShares& shares) {
  std::vector<LegMaker> scaled;
  for (std::size_t i = 0; i < makers.size(); ++i) {
    scaled.push_back([make = makers[i], share = shares[i]](const JointVector& q) {
      auto leg = make(q);
      if (!leg || share == 1.0) return leg;
      leg->blend.value *= share;
      if (share == 0.0) leg->blend = {};
      return leg;
    });
  }
  return scaled;
}

/// Means to touch something: its tool may.
bool may_touch(const MotionTask& request) { return request.until || request.force_offset || request.compliance; }

/// What others move meanwhile is left out: where that is then shows in the rehearsal.
collision::CellState situation_for(const std::vector<MotionTask>& requests, const Surroundings& surroundings) {
  collision::CellState situation = surroundings.situation();
  for (const MotionTask& request : requests) {
    const auto swept = surroundings.meanwhile.beside(request.pointer);
    if (swept == nullptr) continue;
    for (const auto& [body, poses] : swept->bodies) situation.unknown.insert(body);
  }
  return situation;
}

/// Without what carries on with other machines now.
collision::CellState without_moving(collision::CellState situation, const expression::Cell& cell,
                                    const std::string& own) {
  const collision::ContactRules rules(*cell.shapes, situation);
  for (int body = 0; body < static_cast<int>(cell.shapes->scene.bodies().size()); ++body) {
    const auto arm = cell.arms.find(rules.arm_of(body));
    if (arm != cell.arms.end() && arm->first != own && arm->second.device->held()) situation.unknown.insert(body);
  }
  return situation;
}

/// A planned sequence in its surroundings.
class SequenceCheck {
 public:
  SequenceCheck(const std::vector<MotionTask>& requests, const expression::Cell& cell, const motion::ArmModel& arm,
                const Surroundings& surroundings)
      : cell_(cell),
        arm_(arm),
        name_(requests.front().arm),
        situation_(situation_for(requests, surroundings)),
        rules_(*cell.shapes, situation_) {
    if (std::ranges::any_of(requests, may_touch)) touching_.insert(name_);
  }

  /// When it first comes too near to something, s; nothing: it does not.
  [[nodiscard]] std::optional<double> first_hit(const motion::Motion& planned) const {
    auto joints = motion::JointTrack::follow(arm_, planned);
    if (!joints) return std::nullopt;
    const activity::CheckedMotion checked{.tracks = {{name_, std::move(*joints)}}};
    const double duration = checked.duration();
    const auto trajectory = activity::trajectory_of(cell_, {{&checked, 0.0, duration}}, 0.0, duration);
    collision::CheckOptions options{.margin = cell_.shapes->margin, .rule = {}, .bodies = {}};
    options.rule = [this](int a, int b) {
      const collision::Contact contact = rules_.contact(a, b, touching_);
      return collision::rule_for(contact == collision::Contact::kMeant ? collision::Contact::kIgnored : contact,
                                 collision::kSetDownOverlap);
    };
    const auto hits = check_motion(cell_.shapes->scene, situation_.state, trajectory, options);
    return hits.empty() ? std::nullopt : std::optional(hits.front().time);
  }

 private:
  const expression::Cell& cell_;
  const motion::ArmModel& arm_;
  std::string name_;
  collision::CellState situation_;
  collision::ContactRules rules_;
  collision::Touching touching_;
};

/// Of the corners that are still blended the one that a time is next to; nothing: none is.
std::optional<std::size_t> nearest_corner(const std::vector<std::size_t>& corners, const BlendShares& shares,
                                          const SequencePlan& plan, double time) {
  std::optional<std::size_t> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t corner : corners) {
    const double away = std::abs(plan.handed_over[corner] - time);
    if (shares[corner] == 0.0 || away >= least) continue;
    least = away;
    nearest = corner;
  }
  return nearest;
}

void note_shares(const std::vector<MotionTask>& requests, const BlendShares& shares, SequencePlan& plan) {
  for (std::size_t i = 0; i < shares.size(); ++i) {
    if (shares[i] == 1.0) continue;
    const std::string what =
        shares[i] > 0.0 ? fmt::format("{:g} % of the blend of '{}' are made", 100.0 * shares[i], requests[i].name)
                        : fmt::format("the arm stops at the end of '{}'", requests[i].name);
    plan.notes.note(pointer_segment(i) + "/blend", what + ": more would cut the corner into something",
                    "a smaller blend");
  }
}

}  // namespace

Result<SequencePlan> plan_clear_sequence(const std::vector<MotionTask>& requests, const expression::Cell& cell,
                                         const motion::ArmModel& arm, const JointVector& q,
                                         const std::vector<LegMaker>& makers, const Surroundings& surroundings) {
  auto first = motion::plan_sequence(arm, q, makers);
  const auto corners = corners_of_moves(requests);
  const bool looked_at = cell.shapes != nullptr && cell.shapes->off.empty() && !corners.empty();
  if (!first || !looked_at) return first;
  const SequenceCheck check(requests, cell, arm, surroundings);
  BlendShares shares(requests.size(), 1.0);
  auto plan = first;
  for (;;) {
    const auto hit = check.first_hit(plan->motion);
    if (!hit) break;
    const auto corner = nearest_corner(corners, shares, *plan, *hit);
    if (!corner) return first;  // it is not the blends: the rehearsal says what collides
    shares[*corner] = shares[*corner] > kLeastShare ? 0.5 * shares[*corner] : 0.0;
    plan = motion::plan_sequence(arm, q, with_shares(makers, shares));
    if (!plan) return first;
  }
  note_shares(requests, shares, *plan);
  return plan;
}

bool is_clear_blend(const std::vector<MotionTask>& requests, const expression::Cell& cell, const motion::ArmModel& arm,
                    const Surroundings& surroundings, const SequencePlan& from_rest, const SequencePlan& from_blend) {
  if (cell.shapes == nullptr || !cell.shapes->off.empty()) return true;
  Surroundings around = surroundings;
  around.situation = [&] { return without_moving(surroundings.situation(), cell, requests.front().arm); };
  const SequenceCheck check(requests, cell, arm, around);
  return !check.first_hit(from_blend.motion) || check.first_hit(from_rest.motion);
}

}  // namespace takt::operations
