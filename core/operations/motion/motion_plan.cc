#include "core/operations/motion/motion_plan.h"

#include <algorithm>
#include <charconv>
#include <memory>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/object_reader.h"
#include "core/expression/moving_frames.h"
#include "core/kinematics/nearest_place.h"
#include "core/kinematics/plane.h"
#include "core/kinematics/solutions.h"
#include "core/motion/blend_limits.h"
#include "core/motion/plan_checks.h"
#include "core/motion/planner.h"
#include "core/motion/reach_text.h"
#include "core/operations/motion/clear_blends.h"

namespace takt::operations {
namespace {

using Json = nlohmann::ordered_json;
using kinematics::JointVector;

// -- Planning ------------------------------------------------------------------------------------------------------

/// An arm with fewer than six joints goes to the place and turns the tool as near as it can; `notes` tells by how much
/// it fails.
std::optional<JointVector> nearest_place(const expression::MountedArm& arm, const Eigen::Isometry3d& X_BT,
                                         const JointVector& q, Diagnostics& notes) {
  const kinematics::Chain& chain = *arm.device->description().chain;
  auto place = kinematics::nearest_place(chain, X_BT, arm.X_FT, q);
  if (!place) return std::nullopt;
  constexpr double kDegree = std::numbers::pi / 180.0;
  if (place->turn > 0.1 * kDegree) {
    notes.note("", fmt::format("an arm of {} joints cannot turn its tool like this: at the goal it is {:.1f} deg off",
                               chain.joint_count(), place->turn / kDegree));
  }
  return std::move(place->q);
}

Result<JointVector> nearest_configuration(const expression::MountedArm& mounted, const Eigen::Isometry3d& X_BT,
                                          const JointVector& q, Diagnostics& notes) {
  const device::ArmDescription& arm = mounted.device->description();
  const Eigen::Isometry3d X_BF = X_BT * mounted.X_FT.inverse();
  // A base that should tilt is told so; an arm of few joints turns its tool as far as it can.
  if (arm.chain->joint_count() < 6 && !kinematics::moves_in_plane(*arm.chain)) {
    if (auto near = nearest_place(mounted, X_BT, q, notes)) return *near;
  }
  kinematics::SolutionOptions options;
  options.reference = q;
  options.turns = false;  // of each branch the nearest turn: there may be more turns than are looked at
  options.most = 1;
  const auto solutions = kinematics::inverse_solutions(*arm.chain, X_BF, options);
  if (!solutions.empty()) return solutions.front();
  Diagnostics short_of;
  if (arm.inverse) motion::check_directions(*arm.inverse, q, X_BF, "", short_of);
  if (short_of.has_errors()) return std::unexpected(std::move(short_of));
  const Eigen::Vector3d p = X_BF.translation();
  return failure(
      Code::kUnreachable, "",
      fmt::format("the goal is out of reach: flange at ({:.3f}, {:.3f}, {:.3f}) m, {:.3f} m from the arm's base", p.x(),
                  p.y(), p.z(), p.norm()),
      motion::reach_text(*arm.chain, X_BF, q));
}

/// The planner speaks of "/goal/2" and "/start/2"; the file has the goal at "/to".
Diagnostics as_seen_in_file(const Diagnostics& diagnostics) {
  constexpr std::pair<std::string_view, std::string_view> kPlaces[] = {
      {"/goal", "/to"},         {"/points", "/through"},        {"/centre", "/about/position_m"},
      {"/axis", "/about/axis"}, {"/angle", "/about/angle_deg"}, {"/ramp", "/weave/ramp_s"}};
  Diagnostics renamed;
  for (Diagnostic diagnostic : diagnostics.list()) {
    for (const auto& [theirs, ours] : kPlaces) {
      if (!diagnostic.pointer.starts_with(theirs)) continue;
      const bool one_of_many = theirs == "/points";
      diagnostic.pointer = std::string(ours) + (one_of_many ? diagnostic.pointer.substr(theirs.size()) : "");
      break;
    }
    if (diagnostic.pointer.starts_with("/start") || diagnostic.pointer.starts_with("/options"))
      diagnostic.pointer.clear();
    renamed.add(std::move(diagnostic));
  }
  return renamed;
}

std::unexpected<Diagnostics> at_place(const Diagnostics& diagnostics, std::string_view place) {
  Diagnostics placed;
  placed.append(diagnostics, place);
  return std::unexpected(std::move(placed));
}

/// A goal as a pose X_BT, whatever it is given as.
Result<Eigen::Isometry3d> goal_pose(const Goal& goal, const expression::Cell& cell, const std::string& name,
                                    const JointVector& q) {
  const auto resolved = resolve(goal, cell, name, q);
  if (!resolved) return std::unexpected(resolved.error());
  const auto* joints = std::get_if<JointVector>(&*resolved);
  return joints ? tool_pose(cell.arms.find(name)->second, *joints) : std::get<Eigen::Isometry3d>(*resolved);
}

Result<JointVector> joints_of(const MotionTask& request, const expression::Cell& cell, const JointVector& q,
                              const Surroundings& surroundings, Diagnostics& notes) {
  if (request.free_solution) return free_solution(request, cell, q, surroundings);
  Diagnostics own;
  auto joints = goal_joints(request.goal, cell, request.arm, q, own);
  notes.append(own, "/to");
  return joints ? joints : Result<JointVector>(at_place(joints.error(), "/to"));
}

Result<motion::Leg> arc_leg(const MotionTask& request, const expression::Cell& cell, const JointVector& q) {
  const motion::ArmModel arm = expression::planning_model(cell.arms.find(request.arm)->second);
  if (request.about) {
    const auto X_BI = cell.frames.pose(request.about->in, request.arm);
    if (!X_BI) return at_place(X_BI.error(), "/about/in");
    return motion::circ_leg(arm, q,
                            motion::ArcAbout{.centre = *X_BI * request.about->centre,
                                             .axis = X_BI->linear() * request.about->axis,
                                             .angle = request.about->angle,
                                             .orientation = request.orientation});
  }
  const auto X_goal = goal_pose(request.goal, cell, request.arm, q);
  if (!X_goal) return at_place(X_goal.error(), "/to");
  const auto X_via = goal_pose(*request.via, cell, request.arm, q);
  if (!X_via) return at_place(X_via.error(), "/via");
  return motion::circ_leg(
      arm, q,
      motion::ArcThrough{.p_via = X_via->translation(), .X_BM_goal = *X_goal, .orientation = request.orientation});
}

Result<motion::Leg> through_leg(const MotionTask& request, const expression::Cell& cell, const JointVector& q) {
  const motion::ArmModel arm = expression::planning_model(cell.arms.find(request.arm)->second);
  std::vector<JointVector> joints;
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i < request.through.size(); ++i) {
    const auto point = resolve(request.through[i], cell, request.arm, q);
    if (!point) return at_place(point.error(), "/through" + pointer_segment(i));
    if (const auto* at = std::get_if<JointVector>(&*point)) joints.push_back(*at);
    if (const auto* X_BT = std::get_if<Eigen::Isometry3d>(&*point)) poses.push_back(*X_BT);
  }
  return joints.empty() ? motion::spline_leg(arm, q, poses) : motion::spline_leg(arm, q, joints);
}

Result<motion::Leg> geometry_of(const MotionTask& request, const expression::Cell& cell, const JointVector& q,
                                const Surroundings& surroundings) {
  const motion::ArmModel arm = expression::planning_model(cell.arms.find(request.arm)->second);
  switch (request.kind) {
    case PathKind::kPtp: {
      Diagnostics ignored;  // of a sequence only the way is told
      const auto q_goal = joints_of(request, cell, q, surroundings, ignored);
      if (!q_goal) return std::unexpected(q_goal.error());
      return motion::ptp_leg(arm, q, *q_goal);
    }
    case PathKind::kLin: {
      const auto X_goal = goal_pose(request.goal, cell, request.arm, q);
      if (!X_goal) return at_place(X_goal.error(), "/to");
      return motion::lin_leg(arm, q, *X_goal);
    }
    case PathKind::kCirc:
      return arc_leg(request, cell, q);
    case PathKind::kMove:
      return move_leg(request, cell, q, surroundings);
    default:
      return through_leg(request, cell, q);
  }
}

Result<motion::Leg> leg_of(const MotionTask& request, const expression::Cell& cell, const JointVector& q,
                           const Surroundings& surroundings) {
  auto leg = geometry_of(request, cell, q, surroundings);
  if (!leg) return leg;
  leg->velocity = request.velocity;
  leg->acceleration = request.acceleration;
  leg->linear_velocity = request.linear_velocity;
  leg->blend = request.blend.inside();
  return leg;
}

/// Makes the geometry once for each start: a path around obstacles takes long.
motion::LegMaker remembering(motion::LegMaker make) {
  struct Made {
    JointVector q;
    Result<motion::Leg> leg;
  };
  return [make = std::move(make), last = std::make_shared<std::optional<Made>>()](const JointVector& q) {
    if (!*last || (*last)->q != q) *last = Made{q, make(q)};
    return (*last)->leg;
  };
}

/// PTP and LIN alone have planners of their own: the shortest way from a goal to a motion.
Result<motion::Motion> plan_single(const MotionTask& request, const expression::Cell& cell, const JointVector& q,
                                   const Surroundings& surroundings, Diagnostics& notes) {
  const motion::ArmModel arm = expression::planning_model(cell.arms.find(request.arm)->second);
  const motion::MotionOptions options{.velocity = request.velocity,
                                      .acceleration = request.acceleration,
                                      .linear_velocity = request.linear_velocity,
                                      .X_FM = arm.X_FM,
                                      .load = arm.load};
  if (request.kind == PathKind::kPtp) {
    const auto q_goal = joints_of(request, cell, q, surroundings, notes);
    if (!q_goal) return std::unexpected(q_goal.error());
    return motion::plan_ptp(arm.chain, arm.limits, q, *q_goal, options);
  }
  const auto X_goal = goal_pose(request.goal, cell, request.arm, q);
  if (!X_goal) return at_place(X_goal.error(), "/to");
  if (!arm.inverse)
    return failure(Code::kConflict, "", "an arm of fewer than three joints follows no line", "Use a PTP");
  return motion::plan_lin(arm.chain, *arm.inverse, arm.limits, arm.cartesian, q, *X_goal, {}, options);
}

/// The number of the motion that a pointer "/1/blend" of the planner means; one without a number is of the first.
std::size_t index_in(std::string_view pointer, std::size_t count) {
  std::size_t index = 0;
  if (pointer.starts_with('/')) std::from_chars(pointer.data() + 1, pointer.data() + pointer.size(), index);
  return std::min(index, count - 1);
}

}  // namespace

std::string moved_by(const MotionTask& request) {
  return request.follower.empty() ? request.arm : request.arm + "/" + request.follower;  // no name has a '/'
}

bool depends_on_moving_frame(const MotionTask& request, const expression::Cell& cell) {
  const auto hangs = [&](const Goal& goal) { return depends_on_moving_frame(goal, cell, request.arm); };
  return hangs(request.goal) || (request.via && hangs(*request.via)) || std::ranges::any_of(request.through, hangs) ||
         (request.about && expression::moves(cell.frames, request.about->in, request.arm));
}

Result<JointVector> goal_joints(const Goal& goal, const expression::Cell& cell, const std::string& name,
                                const JointVector& q, Diagnostics& notes) {
  const expression::MountedArm& arm = cell.arms.find(name)->second;
  const auto resolved = resolve(goal, cell, name, q);
  if (!resolved) return std::unexpected(resolved.error());
  if (const auto* joints = std::get_if<JointVector>(&*resolved)) return *joints;
  return nearest_configuration(arm, std::get<Eigen::Isometry3d>(*resolved), q, notes);
}

Diagnostics of_motions(const Diagnostics& diagnostics, const std::vector<MotionTask>& requests, bool named) {
  Diagnostics result;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    Diagnostics own;
    const std::string prefix = pointer_segment(i);
    for (Diagnostic diagnostic : diagnostics.list()) {
      const bool mine = diagnostic.pointer == prefix || diagnostic.pointer.starts_with(prefix + "/");
      if (!mine && (i != 0 || diagnostic.pointer.starts_with("/start") == false)) continue;
      if (mine) diagnostic.pointer.erase(0, prefix.size());
      if (i > 0 && !named)
        diagnostic.message = fmt::format("in '{}', which is blended into: {}", requests[i].name, diagnostic.message);
      own.add(std::move(diagnostic));
    }
    result.append(as_seen_in_file(own));
  }
  return result;
}

Diagnostics notes_of_motions(const Diagnostics& notes, const std::vector<MotionTask>& requests) {
  Diagnostics result;
  for (Diagnostic diagnostic : notes.list()) {
    const MotionTask& request = requests[index_in(diagnostic.pointer, requests.size())];
    diagnostic.pointer =
        request.pointer +
        (request.blend.along_path.kind == motion::Blend::Kind::kDistance ? "/blend_m" : "/blend_fraction");
    result.add(std::move(diagnostic));
  }
  return result;
}

std::optional<std::size_t> first_offset(const std::vector<MotionTask>& requests) {
  const auto first = std::ranges::find_if(requests, [](const auto& one) { return one.force_offset.has_value(); });
  if (first == requests.end()) return std::nullopt;
  return static_cast<std::size_t>(first - requests.begin());
}

Diagnostics check_offsets(const std::vector<MotionTask>& requests) {
  Diagnostics diagnostics;
  const auto first = first_offset(requests);
  if (!first) return diagnostics;
  const auto same = "the same 'force_offset' at both, or no blend between them";
  for (std::size_t i = *first + 1; i < requests.size(); ++i) {
    const MotionTask &before = requests[i - 1], &now = requests[i];
    if (now.force_offset == before.force_offset) continue;
    diagnostics.error(Code::kConflict, pointer_segment(i) + "/force_offset",
                      fmt::format("the force offset of '{}' ({}) does not go on in '{}' ({}), into which it is blended",
                                  before.name, before.pointer, now.name, now.pointer),
                      same);
    break;
  }
  for (std::size_t i = 0; i < requests.size(); ++i) {
    if (!requests[i].weave) continue;
    diagnostics.error(
        Code::kConflict, pointer_segment(i) + "/weave",
        fmt::format("a weave of '{}' ({}) and a force offset of '{}' ({}), which are blended into each other",
                    requests[i].name, requests[i].pointer, requests[*first].name, requests[*first].pointer),
        "Remove one of them, or the blend between them");
    break;
  }
  return diagnostics;
}

command::Weaves weaves_of(const std::vector<MotionTask>& requests) {
  command::Weaves weaves;
  for (const MotionTask& request : requests) weaves.push_back(request.weave);
  return weaves;
}

Result<motion::SequencePlan> plan_motions(const std::vector<MotionTask>& requests, const expression::Cell& cell,
                                          const JointVector& q, const Surroundings& surroundings) {
  const MotionTask& first = requests.front();
  const Surroundings around = surroundings ? surroundings : surroundings_at(cell, {});
  const bool single = requests.size() == 1 && (first.kind == PathKind::kPtp || first.kind == PathKind::kLin);
  if (single) {
    Diagnostics notes, placed;
    auto motion = plan_single(first, cell, q, around, notes);
    if (!motion) return std::unexpected(as_seen_in_file(motion.error()));
    placed.append(notes, first.pointer);
    return motion::SequencePlan{.motion = std::move(*motion), .notes = std::move(placed), .handed_over = {}};
  }
  const motion::ArmModel arm = expression::planning_model(cell.arms.find(first.arm)->second);
  auto plan = plan_clear_sequence(requests, cell, arm, q, leg_makers(requests, cell, around), around);
  if (!plan) return std::unexpected(of_motions(plan.error(), requests));
  plan->notes = notes_of_motions(plan->notes, requests);
  return plan;
}

std::vector<motion::LegMaker> leg_makers(const std::vector<MotionTask>& requests, const expression::Cell& cell,
                                         const Surroundings& surroundings) {
  const Surroundings around = surroundings ? surroundings : surroundings_at(cell, {});
  std::vector<motion::LegMaker> makers;
  for (const MotionTask& request : requests) {
    makers.push_back(remembering(
        [&request, &cell, around](const JointVector& q_start) { return leg_of(request, cell, q_start, around); }));
  }
  return makers;
}

Result<motion::PairPlan> plan_pair_motions(const std::vector<MotionTask>& requests, const expression::Cell& cell,
                                           const motion::ArmPair& pair, const JointVector& q_leader,
                                           const JointVector& q_follower) {
  auto plan = motion::plan_pair(pair, q_leader, q_follower, leg_makers(requests, cell));
  if (plan) {
    plan->notes = notes_of_motions(plan->notes, requests);
    return plan;
  }
  // Of the follower, of the whole, of one of the motions.
  Diagnostics whole, all;
  for (Diagnostic diagnostic : plan.error().list()) {
    const bool follows = diagnostic.pointer.starts_with("/follower");
    if (!follows && !diagnostic.pointer.starts_with("/goal")) continue;
    if (follows) diagnostic.pointer = "/follower";
    whole.add(std::move(diagnostic));
  }
  all.append(as_seen_in_file(whole));
  all.append(of_motions(plan.error(), requests));
  return std::unexpected(std::move(all));
}

Result<motion::SequencePlan> plan_motions_from(const motion::Departure& from, const std::vector<MotionTask>& requests,
                                               const expression::Cell& cell, const Surroundings& surroundings) {
  const motion::ArmModel arm = expression::planning_model(cell.arms.find(requests.front().arm)->second);
  return motion::plan_take_over(arm, from, leg_makers(requests, cell, surroundings));
}

}  // namespace takt::operations
