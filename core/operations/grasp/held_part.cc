#include "core/operations/grasp/held_part.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/expression/tool_settings.h"
#include "core/kinematics/chain.h"
#include "core/kinematics/plane.h"
#include "core/operations/grasp/closing_fingers.h"

namespace takt::operations {
namespace {

using Eigen::Isometry3d;

constexpr double kReach_m = 0.01;     ///< from the point between the fingers to the surface of a part
constexpr double kContact_m = 0.005;  ///< a part that is put down is believed to be this near to what it lies on

const std::string& arm_with(const expression::Cell& cell, const std::string& gripper) {
  const auto tool = cell.tools.find(gripper);
  return tool != cell.tools.end() ? tool->second.arm : cell.grippers.find(gripper)->second.arm;
}

/// Flange of the gripper's arm in the world.
Result<Isometry3d> flange_in_world(const expression::Cell& cell, const Gripping& gripping) {
  const std::string& arm = arm_with(cell, gripping.gripper);
  const auto X_WB = cell.frames.pose(arm);
  if (!X_WB) return X_WB;
  return *X_WB * cell.arms.find(arm)->second.device->description().chain->forward(gripping.q);
}

/// An object that a program names has to be one that can be taken, at a place that is known.
Diagnostics check_part(const expression::Cell& cell, const std::string& part) {
  Diagnostics diagnostics;
  const auto object = cell.objects.find(part);
  if (object != cell.objects.end() && object->second.fixed)
    diagnostics.error(Code::kConflict, "/part", fmt::format("'{}' is fixed to the cell", part),
                      "Set \"fixed\": false for this object, or name another one");
  if (const auto X_WO = cell.frames.pose(part); !X_WO) diagnostics.append(X_WO.error(), "/part");
  return diagnostics;
}

/// Fingers around something that is fixed to the cell cannot carry it away.
Diagnostics check_fixed(const expression::Cell& cell, const Gripping& gripping, const Eigen::Vector3d& p_WG) {
  constexpr double kInside_m = 1e-3;  // what lies flat under the fingers is not between them
  Diagnostics diagnostics;
  if (!cell.grippers.contains(gripping.gripper)) return diagnostics;
  for (const auto& [name, object] : cell.objects) {
    const auto X_WO = cell.frames.pose(name);
    if (!object.fixed || !X_WO || world::signed_distance(object, X_WO->inverse() * p_WG) > -kInside_m) continue;
    diagnostics.error(Code::kConflict, "",
                      fmt::format("'{}', which is between the fingers, is fixed to the cell", name),
                      "Set \"fixed\": false of this object, or grip another one");
  }
  return diagnostics;
}

/// How the object is in the flange while it is held.
Result<Isometry3d> held_pose(const expression::Cell& cell, const Gripping& gripping, const std::string& object,
                             const Isometry3d& X_WF) {
  if (!gripping.grasp) {
    const Isometry3d X_FO = X_WF.inverse() * *cell.frames.pose(object);
    // What another gripper holds stays where that one has it.
    return cell.holders_of(object).empty() ? pushed_by_fingers(cell, gripping.gripper, object, X_FO) : X_FO;
  }
  const auto& grasps = cell.objects.find(object)->second.grasps;
  if (const auto grasp = grasps.find(*gripping.grasp); grasp != grasps.end())
    return expression::gripping_point(cell, gripping.gripper) * grasp->second.inverse();
  std::vector<std::string> names;
  for (const auto& [name, X_OG] : grasps) names.push_back(name);
  return failure(Code::kUnknownName, "/grasp", fmt::format("'{}' has no grasp '{}'", object, *gripping.grasp),
                 nearest_choice(*gripping.grasp, names));
}

/// Within what scales and data sheets differ by, or one of them is not known.
bool agree(const PayloadMismatch& masses) {
  constexpr double kShare = 0.02, kLeast_kg = 5e-3;
  if (masses.known == 0.0 || masses.told == 0.0) return true;
  return std::abs(masses.told - masses.known) <= std::max(kShare * masses.known, kLeast_kg);
}

/// The arm is known to be elsewhere now.
bool has_moved(const std::string& arm, const expression::Places& before, const expression::Places& now) {
  const auto was = before.find(arm), is = now.find(arm);
  if (was == before.end() || is == now.end() || was->second.size() != is->second.size()) return false;
  return was->second != is->second;
}

/// What the part stands on from now on.
std::string base_of(const expression::Cell& cell, const Gripping& gripping, const std::string& object,
                    const Isometry3d& X_WO) {
  if (gripping.onto) return standing_frame(cell, *gripping.onto);
  return cell.support_of(object, X_WO, kContact_m).value_or(std::string(world::FrameGraph::kWorld));
}

}  // namespace

std::string standing_frame(const expression::Cell& cell, const std::string& name) {
  const auto arm = cell.arms.find(name);
  const bool drives = arm != cell.arms.end() && arm->second.device != nullptr &&
                      kinematics::moves_in_plane(*arm->second.device->description().chain);
  return drives ? expression::flange_frame(name) : name;
}

Result<world::Hold> take_part(expression::Cell& cell, const Gripping& gripping) {
  const auto X_WF = flange_in_world(cell, gripping);
  if (!X_WF) return std::unexpected(X_WF.error());
  world::Hold hold{.arm = arm_with(cell, gripping.gripper),
                   .p_FG = expression::gripping_point(cell, gripping.gripper).translation(),
                   .mass = gripping.part_mass};
  if (gripping.part) {
    if (Diagnostics wrong = check_part(cell, *gripping.part); wrong.has_errors())
      return std::unexpected(std::move(wrong));
    hold.object = *gripping.part;
  } else {
    hold.object = cell.free_object_at(*X_WF * hold.p_FG, kReach_m).value_or("");
    if (Diagnostics wrong = check_fixed(cell, gripping, *X_WF * hold.p_FG); hold.object.empty() && wrong.has_errors())
      return std::unexpected(std::move(wrong));
  }
  if (!hold.object.empty()) {
    const auto X_FO = held_pose(cell, gripping, hold.object, *X_WF);
    if (!X_FO) return std::unexpected(X_FO.error());
    hold.X_FO = *X_FO;
  }
  if (Diagnostics wrong = cell.take(gripping.gripper, hold); wrong.has_errors())
    return std::unexpected(std::move(wrong));
  return hold;
}

Result<std::optional<world::Hold>> leave_part(expression::Cell& cell, const Gripping& gripping) {
  const auto held = cell.held.find(gripping.gripper);
  if (held == cell.held.end()) return std::nullopt;
  const auto X_WF = flange_in_world(cell, gripping);
  if (!X_WF) return std::unexpected(X_WF.error());
  Isometry3d X_WO = *X_WF * held->second.X_FO;
  const std::string onto = base_of(cell, gripping, held->second.object, X_WO);
  if (gripping.X_left) {
    const auto X_WP = cell.frames.pose(onto);
    if (!X_WP) {
      Diagnostics unplaced;
      unplaced.append(X_WP.error(), "/onto");
      return std::unexpected(std::move(unplaced));
    }
    X_WO = *X_WP * *gripping.X_left;
  }
  auto left = cell.let_go(gripping.gripper, X_WO, onto);
  if (left) return left;
  Diagnostics placed;
  placed.append(left.error(), gripping.onto ? "/onto" : "");
  return std::unexpected(std::move(placed));
}

std::optional<PayloadMismatch> payload_mismatch(const world::Belief& belief, const std::string& object) {
  PayloadMismatch masses{.told = 0.0, .known = belief.mass_of(object).mass};
  bool all_whole = true, all_told = true;
  for (const std::string& gripper : belief.holders_of(object)) {
    const double told = belief.held.find(gripper)->second.mass;
    all_told = all_told && told > 0.0;
    all_whole = all_whole && agree({.told = told, .known = masses.known});
    masses.told += told;
  }
  const bool rest_is_open = !all_told && masses.told < masses.known;
  return all_whole || rest_is_open || agree(masses) ? std::nullopt : std::optional(masses);
}

std::optional<PayloadMismatch> told_mismatch(const world::Belief& belief, const std::string& arm, double told) {
  const PayloadMismatch masses{.told = told, .known = belief.load_of(arm).mass};
  return agree(masses) ? std::nullopt : std::optional(masses);
}

void check_told_masses(const expression::Places& before, Rehearsal& rehearsal, Diagnostics& diagnostics) {
  for (const auto& [gripper, hold] : rehearsal.cell.held) {
    const auto told = rehearsal.told_masses.find(gripper);
    if (told == rehearsal.told_masses.end() || !has_moved(hold.arm, before, rehearsal.q)) continue;
    const std::string pointer = told->second;
    rehearsal.told_masses.erase(told);
    const auto mismatch = payload_mismatch(rehearsal.cell, hold.object);
    if (!mismatch) continue;
    // Who names no part may mean any of several, of which one mass is as good as the other.
    const bool named = !rehearsal.one_of_many.contains(hold.object);
    diagnostics.add(
        {.severity = named ? Severity::kError : Severity::kWarning,
         .code = Code::kPayloadMismatch,
         .file = {},
         .pointer = pointer,
         .message = fmt::format("'{}' weighs {:g} kg, but the payload of its grippers is {:g} kg", hold.object,
                                mismatch->known, mismatch->told),
         .hint = "Give the mass of the object where it is described, and leave out 'part_mass_kg': takt knows it"});
  }
}

}  // namespace takt::operations
