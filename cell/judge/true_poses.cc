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
    const world::Relation& relation = *frames.relation(name);
    X = relation.X_PF * X;
    if (relation.kind == Kind::kFlange) return true_flange(built, relation.source) * X;
    if (relation.kind == Kind::kLink)
      return true_pose(built, expression::link_frame(relation.source, relation.link)) * X;
    if (relation.kind == Kind::kChannel || relation.kind == Kind::kUnknown) return std::nullopt;
  }
  return X;
}

Isometry3d true_tool(const BuiltCell& built, const std::string& arm) {
  return true_flange(built, arm) * expression::default_tcp(built.cell, arm);
}

}  // namespace takt::cell
