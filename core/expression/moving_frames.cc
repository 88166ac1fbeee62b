#include "core/expression/moving_frames.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/kinematics/chain.h"
#include "core/kinematics/link_path.h"

namespace takt::expression {

using kinematics::JointVector;

namespace {

/// X_BL; "" is the flange.
std::optional<Eigen::Isometry3d> link_pose(const device::ArmDescription& arm, const std::string& link,
                                           const JointVector& q) {
  if (link.empty()) return arm.chain->forward(q);
  const auto* path = arm.links == nullptr ? nullptr : arm.links->find(link);
  return path == nullptr ? std::nullopt : std::optional(path->pose(q));
}

}  // namespace

void update_flange_frames(Cell& cell, const std::function<JointVector(const std::string&)>& q_of) {
  for (const auto& [name, arm] : cell.arms) {
    if (arm.device == nullptr || arm.device->description().chain == nullptr) continue;
    const JointVector q = q_of(name);
    if (q.size() != arm.device->joint_count()) continue;
    const device::ArmDescription* description = &arm.device->description();
    cell.frames.update_arm_frames(
        name, [description, q](const std::string& link) { return link_pose(*description, link, q); });
  }
}

namespace {

/// What channels move is where their newest values say.
void see_channels(Cell& cell) {
  for (const std::string& name : cell.frames.moving()) {
    const world::Relation relation = *cell.frames.relation(name);
    if (relation.kind != world::Relation::Kind::kChannel) continue;
    const auto channel = cell.channels.find(relation.source);
    if (channel == cell.channels.end() || channel->second == nullptr) continue;
    const auto& pose = channel->second->slot<net::Frame>();
    if (pose.null == 0) cell.frames.see(name, pose.value * relation.X_PF);
  }
}

}  // namespace

void update_flange_frames(Cell& cell) {
  see_channels(cell);
  update_flange_frames(cell, [&](const std::string& name) {
    const MountedArm& arm = cell.arms.find(name)->second;
    const JointVector& sent = arm.set_point();
    return sent.size() > 0 ? sent : arm.start;
  });
}

Cell cell_at(const Cell& cell, const Places& places) {
  Cell there = cell;
  update_flange_frames(there, [&](const std::string& name) {
    const auto place = places.find(name);
    return place == places.end() ? JointVector() : place->second;
  });
  for (const auto& [name, q] : places)
    if (q.size() == 0) there.frames.update_arm_frames(name, [](const std::string&) { return std::nullopt; });
  return there;
}

/// What rides on the same link, one by one up to the world, goes along with the other.
std::set<std::string> movers_between(const world::FrameGraph& frames, std::string_view of, std::string_view in) {
  using Ride = std::pair<std::string, std::string>;  // arm, link
  const auto rides_of = [&frames](std::string_view name) {
    std::vector<Ride> rides;
    for (const std::string_view one : frames.path_to_world(name))
      if (const auto* relation = frames.relation(one); relation->rides_on_arm())
        rides.emplace_back(relation->source, relation->link);
    return rides;
  };
  auto from = rides_of(of), to = rides_of(in);
  while (!from.empty() && !to.empty() && from.back() == to.back()) {
    from.pop_back();
    to.pop_back();
  }
  from.insert(from.end(), to.begin(), to.end());
  std::set<std::string> movers;
  for (const Ride& ride : from) movers.insert(ride.first);
  return movers;
}

bool moves(const world::FrameGraph& frames, std::string_view of, std::string_view in) {
  auto from = frames.path_to_world(of), to = frames.path_to_world(in);
  // Parents that both have do not matter.
  while (!from.empty() && !to.empty() && from.back() == to.back()) {
    from.pop_back();
    to.pop_back();
  }
  from.insert(from.end(), to.begin(), to.end());
  return std::ranges::any_of(from, [&](std::string_view name) { return frames.relation(name)->moves(); });
}

}  // namespace takt::expression
