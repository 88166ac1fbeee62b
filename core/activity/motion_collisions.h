#pragma once

#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/activity/activity_model.h"
#include "core/collision/contact_rules.h"
#include "core/collision/motion_check.h"
#include "core/command/actions/motion_action.h"
#include "core/expression/believed_shapes.h"
#include "core/motion/joint_track.h"

/// Planned motions against the believed world (docs/world.md, "Collisions in the rehearsal"). Realtime: setup.
namespace takt::activity {

/// The joints of an arm along a planned motion.
struct ArmTrack {
  std::string arm;
  motion::JointTrack joints;
};

/// A planned motion as it is checked.
struct CheckedMotion {
  /// One of the motions that are blended into it.
  struct Part {
    double begin = 0.0;                  ///< s
    std::string step, pointer;           ///< name for people; in its file
    std::set<std::string> goal_on = {};  ///< other machines on which it depends where its goal is
  };
  std::vector<ArmTrack> tracks;       ///< of each arm that it moves, on one clock
  std::vector<Part> parts = {};       ///< one at least, in the order of time
  collision::Touching touching = {};  ///< whose tools may touch
  double touch_from = 0.0;            ///< s: not before
  bool ends_at_touch = false;         ///< a guarded motion

  [[nodiscard]] double duration() const { return tracks.empty() ? 0.0 : tracks.front().joints.duration(); }
  [[nodiscard]] const Part& part_at(double time) const;
};

/// The arms of a planned motion. Empty: its joints cannot be followed.
[[nodiscard]] std::vector<ArmTrack> tracks_of(const command::PlannedMotion& motion,
                                              const command::ActuatorModel& actuator, const expression::Cell& cell);

/// The cell as it is believed to be when an activity begins: its arms where what runs on them ends, all others where
/// they are now. The cell has shapes.
[[nodiscard]] collision::CellState situation_before(const PlanningContext& planning);

/// How far apart the fingers of a gripper stand when they have closed on an object, m: 0 if it is not between them.
[[nodiscard]] double width_around(const collision::CellShapes& shapes, const collision::CellState& situation,
                                  const std::string& gripper, const std::string& object, double widest);

/// A motion that is carried out from `begin` (s) on; it stands still once it has run for `stops` (s).
struct PlayedTrack {
  const CheckedMotion* motion = nullptr;
  double begin = 0.0, stops = 0.0;
};
/// What moves between two times (s), for check_motion(). It refers to the motions.
[[nodiscard]] collision::Trajectory trajectory_of(const expression::Cell& cell, std::vector<PlayedTrack> motions,
                                                  double from, double to);

/// What a guarded motion does before it may touch, and when it touches first: its duration where it does not.
struct FirstTouch {
  double time = 0.0;                          ///< s
  std::vector<collision::Hit> too_soon = {};  ///< touches before touch_from
};
[[nodiscard]] FirstTouch first_touch(const expression::Cell& cell, const collision::CellState& begin,
                                     const CheckedMotion& motion);

/// Two bodies that collide.
struct FoundCollision {
  std::string step, pointer;  ///< of the motion; empty: at the start
  std::string a, b;           ///< names of the bodies
  double time = 0.0;          ///< s after the motion begins
  double distance = 0.0;      ///< m, the least until they part again; negative: overlap
  collision::State state;     ///< of the cell at that time
};

/// The same for people, without a pointer. @param meanwhile  what else moves one of the bodies; empty: nothing
[[nodiscard]] Diagnostic diagnostic_of(const FoundCollision& found, const collision::CellShapes& shapes,
                                       Severity severity, const std::string& meanwhile = {});

/// The same of an activity that is about to begin, where its planning asks for that (PlanningContext): its planned
/// motions against the cell as it is believed to be now. One that means to touch is checked until it may. Where another
/// activity brings its arms meanwhile is not known: these are left out. @param name  of the activity
[[nodiscard]] Diagnostics find_collisions(const PlannedActivity& planned, const PlanningContext& planning,
                                          const std::string& name);

}  // namespace takt::activity
