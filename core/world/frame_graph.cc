#include "core/world/frame_graph.h"

#include <fmt/format.h>

namespace takt::world {

Findings FrameGraph::add(const std::string& name, const std::string& parent, const Eigen::Isometry3d& X_PF) {
  if (!contains(name)) return set(name, parent, X_PF);
  Findings findings;
  findings.error({}, fmt::format("a frame named '{}' exists already", name), "each name once");
  return findings;
}

Findings FrameGraph::set(const std::string& name, const std::string& parent, const Eigen::Isometry3d& X_PF) {
  Findings findings;
  if (name.empty()) findings.error({}, "a frame needs a name");
  if (name == kWorld) findings.error({}, "the frame 'world' is the root and cannot be placed");
  if (!contains(parent)) {
    findings.error({}, fmt::format("there is no frame '{}'", parent), nearest_choice(parent, names()));
  } else if (is_below(parent, name)) {
    findings.error({}, fmt::format("frame '{}' cannot hang below itself through '{}'", name, parent));
  }
  if (!X_PF.matrix().allFinite()) findings.error({}, fmt::format("the pose of frame '{}' is not finite", name));
  if (findings.empty()) relations_[name] = {parent, X_PF};
  return findings;
}

bool FrameGraph::contains(std::string_view name) const { return name == kWorld || relations_.contains(name); }

bool FrameGraph::is_below(std::string_view name, std::string_view ancestor) const {
  while (name != kWorld) {
    if (name == ancestor) return true;
    name = relations_.find(name)->second.parent;
  }
  return name == ancestor;
}

Result<Eigen::Isometry3d> FrameGraph::in_world(std::string_view name) const {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  while (name != kWorld) {
    const auto found = relations_.find(name);
    if (found == relations_.end()) {
      return failure({}, fmt::format("there is no frame '{}'", name), nearest_choice(name, names()));
    }
    X = found->second.X_PF * X;
    name = found->second.parent;
  }
  return X;
}

Result<Eigen::Isometry3d> FrameGraph::pose(std::string_view of, std::string_view in) const {
  const auto X_WF = in_world(of);
  const auto X_WI = in_world(in);
  if (!X_WF) return X_WF;
  if (!X_WI) return X_WI;
  return X_WI->inverse() * *X_WF;
}

std::vector<std::string> FrameGraph::names() const {
  std::vector<std::string> names{std::string(kWorld)};
  for (const auto& [name, relation] : relations_) names.push_back(name);
  return names;
}

}  // namespace takt::world
