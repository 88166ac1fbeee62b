#pragma once

#include <optional>
#include <string>

#include "core/command/actions/device_commands.h"
#include "core/operations/command/operation_activity.h"
#include "core/operations/table/operation.h"
#include "core/operations/table/step.h"

/// "grip": closes a gripper until a part stops its fingers; then the part goes with the arm in the belief, and is its
/// load. "release": opens it, and the part stays where it is (docs/world.md). Realtime: setup.
namespace takt::operations {

/// Absent figures are those of the gripper.
struct GripParameters {
  std::string gripper = {};                                  ///< empty: the only one
  std::optional<double> width = {}, speed = {}, force = {};  ///< m, m/s, N
  std::optional<double> timeout = {};                        ///< s, until the fingers are at rest
  enum class Expect { kPart, kNothing, kAny } expect = Expect::kPart;
  std::optional<std::string> part = {};  ///< object that is gripped; nothing: the free one between the fingers
  double part_mass = 0.0;                ///< kg, checked against what the object weighs; 0: not checked
  std::string name = {}, pointer = {};   ///< for people; in its file
};
struct ReleaseParameters {
  std::string gripper = {};                                  ///< empty: the only one
  std::optional<double> width = {}, speed = {}, force = {};  ///< m, m/s, N
  std::optional<double> timeout = {};                        ///< s, until the fingers are at rest
  std::optional<std::string> onto = {};                      ///< that the part stands on then; nothing: what is there
  std::string name = {}, pointer = {};                       ///< for people; in its file
};
[[nodiscard]] const ParameterTable<GripParameters>& grip_parameters();
[[nodiscard]] const ParameterTable<ReleaseParameters>& release_parameters();

[[nodiscard]] std::unique_ptr<OperationCommand> close_command(const GripParameters& parameters);
[[nodiscard]] inline OperationForm<GripParameters> form_of(const GripParameters&) {
  return {"grip", grip_parameters, &GripParameters::gripper, close_command};
}
[[nodiscard]] std::unique_ptr<OperationCommand> open_command(const ReleaseParameters& parameters);
[[nodiscard]] inline OperationForm<ReleaseParameters> form_of(const ReleaseParameters&) {
  return {"release", release_parameters, &ReleaseParameters::gripper, open_command};
}
[[nodiscard]] Operation grip_operation();
[[nodiscard]] Operation release_operation();

}  // namespace takt::operations
