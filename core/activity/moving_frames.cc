#include "core/activity/moving_frames.h"

#include "core/kinematics/chain.h"

namespace takt::activity {

using kinematics::JointVector;

void see_flanges(command::Cell& cell, const std::function<JointVector(const std::string&)>& q_of) {
  for (const std::string& name : cell.frames.moving()) {
    const world::Relation& relation = *cell.frames.relation(name);
    const auto arm = cell.arms.find(relation.source);
    const bool on_flange = relation.kind == world::Relation::Kind::kFlange && arm != cell.arms.end();
    if (!on_flange || arm->second.device == nullptr) continue;
    const JointVector q = q_of(relation.source);
    if (q.size() != arm->second.device->joint_count()) continue;
    cell.frames.see(name, arm->second.device->description().chain->forward(q) * relation.X_PF);
  }
}

void see_flanges(command::Cell& cell) {
  see_flanges(cell, [&](const std::string& name) {
    const command::MountedArm& arm = cell.arms.find(name)->second;
    const JointVector& sent = arm.device->set_point().q;
    return sent.size() > 0 ? sent : arm.start;
  });
}

}  // namespace takt::activity
