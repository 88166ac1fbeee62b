#include "cell/judge/true_poses.h"

#include "core/expression/tool_settings.h"

namespace takt::cell {
namespace {

using Eigen::Isometry3d;
using Kind = world::Relation::Kind;

Isometry3d true_flange(const BuiltCell& built, const std::string& arm) {
  const device::Arm& device = *built.cell.arms.find(arm)->second.device;
  return true_pose(built, arm + "/" + device.description().flange_link);
}

}  // namespace

Isometry3d true_pose(const BuiltCell& built, const std::string& object) {
  const auto moving = built.true_body.find(object);
  const int body = built.world->body(moving == built.true_body.end() ? object : moving->second);
  return body >= 0 ? built.world->body_pose(body) : built.truth_W.find(object)->second;
}

std::optional<Isometry3d> true_frame(const BuiltCell& built, const std::string& frame) {
  const world::FrameGraph& frames = built.cell.frames;
  if (!frames.contains(frame)) return std::nullopt;
  Isometry3d X = Isometry3d::Identity();
  for (const std::string_view name : frames.path_to_world(frame)) {
    if (built.cell.objects.contains(name)) return true_pose(built, std::string(name)) * X;
    const std::string owner(name.substr(0, name.find('/')));
    if (owner.size() < name.size() && built.cell.tools.contains(owner)) {
      // A tool centre point that is a link of its tool is where its springs let it be.
      if (const int body = built.world->body(std::string(name)); body >= 0) return built.world->body_pose(body) * X;
    }
    const world::Relation& relation = *frames.relation(name);
    const auto drawn = built.true_mounts.find(name);
    X = (drawn == built.true_mounts.end() ? relation.X_PF : drawn->second) * X;
    if (relation.kind == Kind::kFlange) return true_flange(built, relation.source) * X;
    if (relation.kind == Kind::kLink)
      return true_pose(built, expression::link_frame(relation.source, relation.link)) * X;
    if (relation.kind == Kind::kChannel || relation.kind == Kind::kUnknown) return std::nullopt;
  }
  return X;
}

Isometry3d true_tool(const BuiltCell& built, const std::string& arm) {
  const Isometry3d X_FT = expression::default_tcp(built.cell, arm);
  const std::string& tool = built.cell.arms.find(arm)->second.tool_name;
  const auto mounted = built.cell.tools.find(tool);
  const bool drawn =
      built.true_mounts.contains(tool) && mounted != built.cell.tools.end() && mounted->second.arm == arm;
  const auto X_WM = drawn ? true_frame(built, tool) : std::nullopt;
  const auto X_FM = built.cell.frames.pose(tool, expression::flange_frame(arm));
  return X_WM && X_FM ? *X_WM * X_FM->inverse() * X_FT : true_flange(built, arm) * X_FT;
}

}  // namespace takt::cell
