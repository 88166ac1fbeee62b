#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/findings.h"

namespace takt::world {

/// Named frames, each fixed to a parent; the root is "world". A relation may be replaced when something is measured.
/// Thread: the program's. Realtime: setup.
class FrameGraph {
 public:
  static constexpr std::string_view kWorld = "world";

  /// Adds frame `name` at X_PF in `parent`.
  /// @return a finding if the name exists, the parent does not, or the name is empty.
  [[nodiscard]] Findings add(const std::string& name, const std::string& parent, const Eigen::Isometry3d& X_PF);
  /// Replaces the relation of a frame to its parent, or adds the frame.
  [[nodiscard]] Findings set(const std::string& name, const std::string& parent, const Eigen::Isometry3d& X_PF);

  [[nodiscard]] bool contains(std::string_view name) const;
  /// Pose of frame `of` in frame `in`; findings name the unknown frame and the nearest one.
  [[nodiscard]] Result<Eigen::Isometry3d> pose(std::string_view of, std::string_view in = kWorld) const;
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  struct Relation {
    std::string parent;
    Eigen::Isometry3d X_PF;
  };
  [[nodiscard]] Result<Eigen::Isometry3d> in_world(std::string_view name) const;
  [[nodiscard]] bool is_below(std::string_view name, std::string_view ancestor) const;

  std::map<std::string, Relation, std::less<>> relations_;
};

}  // namespace takt::world
