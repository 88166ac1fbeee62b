#pragma once

#include <optional>
#include <string>

#include "core/expression/cell.h"
#include "core/operations/table/step.h"

/// What grip and release, attach and detach do to the belief, in a rehearsal as in a run. Realtime: setup.
namespace takt::operations {

/// What a gripper, or a tool that holds without fingers, has got hold of, or lets go.
struct Gripping {
  std::string gripper = {};
  std::optional<std::string> part = {};   ///< object, as the program names it; nothing: whatever is there
  std::optional<std::string> grasp = {};  ///< of the object, that is at the tool centre point; nothing: as believed
  double part_mass = 0.0;                 ///< kg, as the program says; 0: it says nothing
  std::optional<std::string> onto =
      {};  ///< frame, device or object that the part stands on then; nothing: what is there
  std::optional<Eigen::Isometry3d> X_left = {};  ///< where it is then, in `onto`, m; nothing: where it is held
  kinematics::JointVector q = {};                ///< of the arm that carries the gripper, rad or m
};

/// The fingers have stopped at a part: the object that the program names, or the free object nearest to the point
/// between the fingers, within 10 mm. It rides on the flange from now on.
/// @return what is held, or diagnostics below the step: the object is fixed, has no such grasp, or nobody knows where
/// it is
[[nodiscard]] Result<world::Hold> take_part(expression::Cell& cell, const Gripping& gripping);

/// The fingers have opened: what they held stays where it is, on or in whatever is there as far as shapes tell, or on
/// `onto`. @return what was held, or diagnostics below the step
Result<std::optional<world::Hold>> leave_part(expression::Cell& cell, const Gripping& gripping);

/// The frame that something stands on that stands on this device, object or frame: of a base that of its body.
[[nodiscard]] std::string standing_frame(const expression::Cell& cell, const std::string& name);

/// The masses that programs told for an object that is held, of all its grippers, and what it weighs with all that
/// stands on it. Nothing: each is its mass, or they are shares that add up to it, or one of the two is not known.
struct PayloadMismatch {
  double told = 0.0, known = 0.0;  ///< kg
};
[[nodiscard]] std::optional<PayloadMismatch> payload_mismatch(const world::Belief& belief, const std::string& object);

/// The same of a mass that a program tells an arm for all that its grippers hold.
[[nodiscard]] std::optional<PayloadMismatch> told_mismatch(const world::Belief& belief, const std::string& arm,
                                                           double told);

/// After a step of a rehearsal: objects that it lifted have to weigh what the program said. Before that another gripper
/// may take its share. @param before  where the arms were before the step
void check_told_masses(const expression::Places& before, Rehearsal& rehearsal, Diagnostics& diagnostics);

}  // namespace takt::operations
