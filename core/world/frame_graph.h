#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/diagnostics.h"

namespace takt::world {

/// How a frame hangs on its parent.
struct Relation {
  enum class Kind : std::uint8_t {
    kFixed,     ///< built in: X_PF
    kEstimate,  ///< measured once, and believed until it is measured again: X_PF
    kFlange,    ///< on the flange of the arm `source`, whose base the parent is; X_PF is its pose in the flange
    kLink,      ///< on link `link` of the arm `source`, whose base the parent is; X_PF is its pose in that link
    kChannel,   ///< the channel `source` gives a pose in the parent; X_PF is its pose behind that
    kUnknown    ///< lost: nobody knows where it is until it is found again
  };
  Kind kind = Kind::kFixed;
  std::string parent;
  Eigen::Isometry3d X_PF = Eigen::Isometry3d::Identity();  ///< m
  std::string source = {};
  std::string link = {};  ///< of kLink only
  /// Of one that moves, unless the graph has seen the arm that it rides on (FrameGraph::update_arm_frames): the frame
  /// in its parent when it was looked at last (FrameGraph::see); none: not yet.
  std::optional<Eigen::Isometry3d> X_seen = {};

  [[nodiscard]] bool rides_on_arm() const { return kind == Kind::kFlange || kind == Kind::kLink; }
  /// It changes while nets run.
  [[nodiscard]] bool moves() const { return rides_on_arm() || kind == Kind::kChannel; }
};

/// Named frames, each hanging on a parent; the root is "world". A relation may be replaced when something is measured.
/// Thread: the program's. Realtime: setup.
class FrameGraph {
 public:
  static constexpr std::string_view kWorld = "world";

  /// Adds frame `name` at X_PF in `parent`.
  /// @return a diagnostic if the name exists, the parent does not, or the name is empty.
  [[nodiscard]] Diagnostics add(const std::string& name, const std::string& parent, const Eigen::Isometry3d& X_PF);
  /// Replaces the relation of a frame to its parent, or adds the frame.
  [[nodiscard]] Diagnostics set(const std::string& name, const std::string& parent, const Eigen::Isometry3d& X_PF) {
    return set(name, Relation{.kind = Relation::Kind::kFixed, .parent = parent, .X_PF = X_PF});
  }
  [[nodiscard]] Diagnostics set(const std::string& name, const Relation& relation);
  /// Takes a frame away that a step has made (kEstimate). What was measured, made or put down on it stays where it is
  /// and depends on its parent from then on. Of other frames, and of the world, nothing happens. @return it was there
  bool remove(std::string_view name);
  /// Where a frame that moves is now, in its parent: what pose() answers until it is seen again. Others do not change.
  void see(std::string_view name, const Eigen::Isometry3d& X_PF);
  /// The same of all frames that ride on an arm: X_BL tells where a link of it is in its base, "" is the flange;
  /// nothing: nobody knows where. It is asked as often as pose() needs it until the arm is seen again, also by copies
  /// of the graph: it owns what it needs.
  using LinkPoses = std::function<std::optional<Eigen::Isometry3d>(const std::string& link)>;
  void update_arm_frames(std::string_view arm, LinkPoses X_BL);

  [[nodiscard]] bool contains(std::string_view name) const;
  /// How a frame hangs on its parent; null for the world and for frames that are not there.
  [[nodiscard]] const Relation* relation(std::string_view name) const;
  /// Pose of frame `of` in frame `in`; diagnostics name the unknown frame and the nearest one, or the frame between
  /// them that is lost (Code::kUnknownPose), or that moves and has not been seen: where that is only sensors tell
  /// (core/expression/frame_sensors.h).
  [[nodiscard]] Result<Eigen::Isometry3d> pose(std::string_view of, std::string_view in = kWorld) const;
  [[nodiscard]] std::vector<std::string> names() const;
  /// Names of the frames that move.
  [[nodiscard]] std::vector<std::string> moving() const;
  /// The frame and all that it depends on, the world left out; empty for the world and for frames that are not there.
  [[nodiscard]] std::vector<std::string_view> path_to_world(std::string_view name) const;
  /// The frame is `ancestor`, or depends on it.
  [[nodiscard]] bool depends_on(std::string_view name, std::string_view ancestor) const;
  /// Counts the relations that were set so far. Whoever keeps something in step with the graph looks here first.
  [[nodiscard]] std::uint64_t changes() const { return changes_; }

 private:
  [[nodiscard]] std::optional<Eigen::Isometry3d> seen(const Relation& relation) const;
  [[nodiscard]] Result<Eigen::Isometry3d> along(const std::vector<std::string_view>& path, std::size_t count) const;

  std::map<std::string, Relation, std::less<>> relations_;
  std::map<std::string, LinkPoses, std::less<>> arms_;  ///< that have been seen
  std::uint64_t changes_ = 0;
};

}  // namespace takt::world
