#include "core/world/frame_graph.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace takt::world {

Diagnostics FrameGraph::add(const std::string& name, const std::string& parent, const Eigen::Isometry3d& X_PF) {
  if (!contains(name)) return set(name, parent, X_PF);
  Diagnostics diagnostics;
  diagnostics.error(Code::kDuplicate, {}, fmt::format("a frame named '{}' exists already", name), "Use each name once");
  return diagnostics;
}

Diagnostics FrameGraph::set(const std::string& name, const Relation& relation) {
  Diagnostics diagnostics;
  const std::string& parent = relation.parent;
  if (name.empty()) diagnostics.error(Code::kMissing, {}, "a frame without a name", "Give it a name of its own");
  if (name == kWorld)
    diagnostics.error(Code::kInvalidName, {}, "the frame 'world' is the root and cannot be placed",
                      "Choose another name");
  if (!contains(parent)) {
    diagnostics.error(Code::kUnknownName, {}, fmt::format("there is no frame '{}'", parent),
                      nearest_choice(parent, names()));
  } else if (depends_on(parent, name)) {
    diagnostics.error(Code::kInvalidValue, {},
                      fmt::format("frame '{}' cannot be its own ancestor through '{}'", name, parent),
                      "Choose a parent that is not mounted on it");
  }
  if (!relation.X_PF.matrix().allFinite()) {
    diagnostics.error(Code::kInvalidValue, {}, fmt::format("the pose of frame '{}' is not finite", name),
                      "Give finite numbers");
  }
  if (relation.moves() && relation.source.empty()) {
    diagnostics.error(Code::kMissing, {}, fmt::format("frame '{}' moves, but nothing says where it is", name),
                      "Give the name of its source");
  }
  if (!diagnostics.empty()) return diagnostics;
  relations_[name] = relation;
  ++changes_;
  return diagnostics;
}

bool FrameGraph::remove(std::string_view name) {
  const auto found = relations_.find(name);
  if (found == relations_.end() || found->second.kind != Relation::Kind::kEstimate) return false;
  const Relation gone = found->second;
  relations_.erase(found);
  for (auto& [child, relation] : relations_) {
    if (relation.parent != name) continue;
    relation.parent = gone.parent;
    relation.X_PF = gone.X_PF * relation.X_PF;
  }
  ++changes_;
  return true;
}

void FrameGraph::see(std::string_view name, const Eigen::Isometry3d& X_PF) {
  const auto found = relations_.find(name);
  if (found != relations_.end() && found->second.moves()) found->second.X_seen = X_PF;
}

void FrameGraph::update_arm_frames(std::string_view arm, LinkPoses X_BL) {
  const auto found = arms_.find(arm);
  if (found != arms_.end())
    found->second = std::move(X_BL);
  else
    arms_.emplace(arm, std::move(X_BL));
}

/// Where a frame that moves is in its parent, as far as anybody has looked.
std::optional<Eigen::Isometry3d> FrameGraph::seen(const Relation& relation) const {
  const auto arm = relation.rides_on_arm() ? arms_.find(relation.source) : arms_.end();
  if (arm == arms_.end()) return relation.X_seen;
  const auto X_BL = arm->second(relation.link);
  return X_BL ? std::optional<Eigen::Isometry3d>(*X_BL * relation.X_PF) : std::nullopt;
}

std::vector<std::string> FrameGraph::moving() const {
  std::vector<std::string> names;
  for (const auto& [name, relation] : relations_) {
    if (relation.moves()) names.push_back(name);
  }
  return names;
}

bool FrameGraph::contains(std::string_view name) const { return name == kWorld || relations_.contains(name); }

bool FrameGraph::depends_on(std::string_view name, std::string_view ancestor) const {
  const auto path = path_to_world(name);
  return ancestor == kWorld || std::ranges::find(path, ancestor) != path.end();
}

const Relation* FrameGraph::relation(std::string_view name) const {
  const auto found = relations_.find(name);
  return found == relations_.end() ? nullptr : &found->second;
}

std::vector<std::string_view> FrameGraph::path_to_world(std::string_view name) const {
  std::vector<std::string_view> path;
  for (auto at = relations_.find(name); at != relations_.end(); at = relations_.find(at->second.parent)) {
    path.push_back(at->first);
  }
  return path;
}

/// Pose of the first frame of the path in the parent of the last of `count` frames.
Result<Eigen::Isometry3d> FrameGraph::along(const std::vector<std::string_view>& path, std::size_t count) const {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < count; ++i) {
    const Relation& relation = *this->relation(path[i]);
    if (relation.kind == Relation::Kind::kUnknown) {
      return failure(Code::kUnknownPose, {}, fmt::format("it is not known where '{}' is", path[i]),
                     "Choose a frame whose pose is known, or measure this one before");
    }
    const auto X_seen = relation.moves() ? seen(relation) : relation.X_PF;
    if (!X_seen) {
      return failure(Code::kInvalidValue, {}, fmt::format("frame '{}' moves with '{}'", path[i], relation.source),
                     "Choose a frame that does not, or use a sensor");
    }
    X = *X_seen * X;
  }
  return X;
}

Result<Eigen::Isometry3d> FrameGraph::pose(std::string_view of, std::string_view in) const {
  for (const std::string_view name : {of, in}) {
    if (!contains(name)) {
      return failure(Code::kUnknownName, {}, fmt::format("there is no frame '{}'", name),
                     nearest_choice(name, names()));
    }
  }
  const auto from = path_to_world(of), to = path_to_world(in);
  // What both hang on does not matter, and may move.
  std::size_t shared = 0;
  while (shared < from.size() && shared < to.size() && from[from.size() - 1 - shared] == to[to.size() - 1 - shared]) {
    ++shared;
  }
  const auto X_CF = along(from, from.size() - shared);
  const auto X_CI = along(to, to.size() - shared);
  if (!X_CF) return X_CF;
  if (!X_CI) return X_CI;
  return X_CI->inverse() * *X_CF;
}

std::vector<std::string> FrameGraph::names() const {
  std::vector<std::string> names{std::string(kWorld)};
  for (const auto& [name, relation] : relations_) names.push_back(name);
  return names;
}

}  // namespace takt::world
