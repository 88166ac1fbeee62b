#include "core/activity/held_parts.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/expression/tool_coupling.h"
#include "core/expression/tool_settings.h"

namespace takt::activity {
namespace {

/// Something drives the fingers, or has since they gripped: a step that will say itself what becomes of the part.
bool is_driven(const device::Gripper& gripper, const world::Hold& hold) {
  return gripper.held() && gripper.set_point().sequence != hold.command;
}

/// Why the gripper does not hold its part any more; empty: it does, or nothing new is known.
std::string sign_of_loss(const device::Gripper& gripper, const world::Hold& hold) {
  constexpr double kWidth_m = 1.5e-3;   // parts yield a little, and pads too
  constexpr double kForceShare = 0.25;  // of what it pressed with: less is no grip
  const device::GripperSample& sample = gripper.sample();
  if (!gripper.has_sample() || !gripper.answered() || sample.state == device::GripperState::kMoving) return {};
  if (sample.state == device::GripperState::kLost) return "the gripper says so";
  const double wrong_m = std::max(kWidth_m, 2.0 * gripper.description().width_resolution);
  if (hold.width && std::abs(sample.width - *hold.width) > wrong_m)
    return fmt::format("the fingers stand {:.1f} mm apart, not {:.1f} mm", 1e3 * sample.width, 1e3 * *hold.width);
  if (hold.force && std::abs(sample.force) < kForceShare * std::abs(*hold.force))
    return fmt::format("the fingers press with {:.1f} N, not {:.1f} N", std::abs(sample.force), std::abs(*hold.force));
  return {};
}

/// It says so, and no step is unlocking it.
bool has_let_go(const expression::Cell& cell, const std::string& changer) {
  namespace terminal = device::changer_terminal;
  const auto coupled = cell.digital_inputs.find(fmt::format("{}/{}", changer, terminal::kCoupled));
  const auto lock = cell.digital_outputs.find(fmt::format("{}/{}", changer, terminal::kLock));
  if (coupled == cell.digital_inputs.end() || coupled->second == nullptr) return false;
  const bool driven = lock != cell.digital_outputs.end() && lock->second != nullptr && lock->second->held();
  return !driven && coupled->second->has_sample() && !coupled->second->sample().value;
}

}  // namespace

void notice_lost_parts(Context& context) {
  expression::Cell& cell = context.cell;
  for (auto at = cell.held.begin(); at != cell.held.end();) {
    const auto [gripper, hold] = *at++;  // a copy: what follows may remove it
    const auto mounted = cell.grippers.find(gripper);
    if (mounted == cell.grippers.end() || mounted->second.device == nullptr) continue;
    const device::Gripper& device = *mounted->second.device;
    const std::string why = is_driven(device, hold) ? std::string() : sign_of_loss(device, hold);
    if (why.empty()) continue;
    const std::string what = hold.object.empty() ? "its part" : fmt::format("'{}'", hold.object);
    context.event(gripper, "lost", fmt::format("{}: {}", what, why));
    // Another gripper may hold it still: then it is where that one has it.
    const auto left = cell.let_go(gripper, Eigen::Isometry3d::Identity(), std::string(world::FrameGraph::kWorld));
    if (left && !hold.object.empty() && cell.holders_of(hold.object).empty()) cell.lose(hold.object);
    expression::tell_tool_settings(cell);
  }
}

void notice_lost_tools(Context& context) {
  expression::Cell& cell = context.cell;
  for (const auto& [name, changer] : cell.changers) {
    const std::string side = coupled_side(cell, name);
    if (side.empty() || !has_let_go(cell, name)) continue;
    context.event(name, "lost", fmt::format("'{}': it is not coupled any more", side));
    lose_coupled(cell, name);
    expression::tell_tool_settings(cell);
  }
}

}  // namespace takt::activity
