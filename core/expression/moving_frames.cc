#include "core/expression/moving_frames.h"

#include <algorithm>
#include <vector>

#include "core/kinematics/chain.h"

namespace takt::activity {

using kinematics::JointVector;

namespace {

/// The frame and all its parents.
std::vector<std::string_view> way_to_world(const world::FrameGraph& frames, std::string_view name) {
  std::vector<std::string_view> way;
  for (const world::Relation* at = frames.relation(name); at != nullptr; at = frames.relation(name)) {
    way.push_back(name);
    name = at->parent;
  }
  return way;
}

}  // namespace

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
    const JointVector& sent = arm.set_point();
    return sent.size() > 0 ? sent : arm.start;
  });
}

command::Cell cell_at(const command::Cell& cell, const command::Places& places) {
  command::Cell there = cell;
  see_flanges(there, [&](const std::string& name) {
    const auto place = places.find(name);
    return place == places.end() ? JointVector() : place->second;
  });
  for (const std::string& name : there.frames.moving()) {
    world::Relation relation = *there.frames.relation(name);
    const auto place = places.find(relation.source);
    if (relation.kind != world::Relation::Kind::kFlange || place == places.end() || place->second.size() > 0) continue;
    relation.X_seen.reset();
    (void)there.frames.set(name, relation);  // its parent stays the same
  }
  return there;
}

bool moves(const world::FrameGraph& frames, std::string_view of, std::string_view in) {
  auto from = way_to_world(frames, of), to = way_to_world(frames, in);
  // Parents that both have do not matter.
  while (!from.empty() && !to.empty() && from.back() == to.back()) {
    from.pop_back();
    to.pop_back();
  }
  from.insert(from.end(), to.begin(), to.end());
  return std::ranges::any_of(from, [&](std::string_view name) { return frames.relation(name)->moves(); });
}

}  // namespace takt::activity
