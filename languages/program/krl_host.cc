#include "languages/program/krl_host.h"

#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/device/arm.h"

namespace takt::languages {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace

void KrlHost::move(krl::MotionCommand motion) {
  KrlItem item{
      .motion = {}, .steps = {}, .name = step_name(motion.at, motion.label), .module = motion.module, .at = motion.at};
  item.motion = std::move(motion);
  queue_.push_back(std::move(item));
}

std::string KrlHost::write(krl::Live output, int number, double value, std::optional<double> pulse, bool beside) {
  const auto step = output_step(map_, output, number, value, pulse);
  if (step.is_null())
    return fmt::format("{}[{}] is no signal of this cell", output == krl::Live::kOut ? "$OUT" : "$ANOUT", number);
  written_[{output, number}] = value;
  KrlItem item{.motion = {}, .steps = step.dump(), .name = fmt::format("output {}", number), .module = 0, .at = {}};
  if (beside) {
    run_beside(std::move(item));
  } else {
    queue_.push_back(std::move(item));
  }
  return {};
}

void KrlHost::call(const std::string& name, int module, const TextLocation& at) {
  const auto found = map_.calls.find(name);
  queue_.push_back({.motion = {},
                    .steps = found == map_.calls.end() ? "[]" : found->second,
                    .name = fmt::format("{}: {}", at.line, name),
                    .module = module,
                    .at = at});
}

std::vector<double> KrlHost::to_axes(const kinematics::JointVector& q) const {
  std::vector<double> axes;
  for (std::size_t i = 0; i < map_.axes.size(); ++i)
    axes.push_back(q[static_cast<Eigen::Index>(i)] / kDegree + map_.offsets[i]);
  return axes;
}

Eigen::Isometry3d KrlHost::flange(const std::vector<double>& axes) {
  kinematics::JointVector q = arm().start;
  for (std::size_t i = 0; i < axes.size(); ++i) q[static_cast<Eigen::Index>(i)] = (axes[i] - map_.offsets[i]) * kDegree;
  const expression::MountedArm& mounted = arm();
  return expression::tool_pose(mounted, q) * mounted.X_FT.inverse();
}

void KrlHost::prepare(krl::Machine& machine) {
  const auto usual = cell_.tools.find(arm().tool_name);
  if (usual != cell_.tools.end()) machine.set_frame("$TOOL", 0, usual->second.X_FT.at(usual->second.tcp));
  for (const auto& [number, tool] : map_.tools) machine.set_frame("TOOL_DATA", number, tool.X_FT);
  const auto X_WB = cell_.frames.pose(map_.arm);
  for (const auto& [number, frame] : map_.bases) {
    const auto X_WF = cell_.frames.pose(frame);
    if (X_WB && X_WF) machine.set_frame("BASE_DATA", number, X_WB->inverse() * *X_WF);
  }
  if (arm().device == nullptr) return;
  const std::vector<double> home = to_axes(arm().device->description().home);
  machine.set_axes("$H_POS", home);
  machine.set_axes("XHOME", home);
}

}  // namespace takt::languages
