#pragma once

#include <optional>
#include <string>

#include "core/command/actions/device_commands.h"
#include "core/operations/parameter_table.h"
#include "core/operations/step.h"

namespace takt::activity {

/// What a step "grip" or "release" says, in numbers. Absent figures are those of the gripper. Keys: docs/scenarios.md.
struct GripRequest : OperationHead {
  std::string gripper;
  bool opens = false;
  std::optional<double> width, speed, force;  ///< m, m/s, N
  enum class Expect { kPart, kNothing, kAny } expect = Expect::kPart;
  std::optional<std::string> part;  ///< object that the arm now carries; nothing: none that matters
  double mass = 0.0;                ///< kg of the part, told to the arm; 0: the arm is told nothing
};
[[nodiscard]] const ParameterTable<GripRequest>& grip_parameters();
[[nodiscard]] const ParameterTable<GripRequest>& release_parameters();
[[nodiscard]] GripRequest read_grip(ObjectReader& reader, const command::Cell& cell);
[[nodiscard]] GripRequest read_release(ObjectReader& reader, const command::Cell& cell);

[[nodiscard]] command::GripCommand command_of(const GripRequest& request, const device::GripperDescription& gripper);
/// @return false with diagnostics below `pointer`: figures that the gripper does not have.
bool check_figures(const GripRequest& request, const device::GripperDescription& gripper, const std::string& pointer,
                   Diagnostics& diagnostics);

/// How things were when the fingers stood.
struct GripOutcome {
  std::optional<bool> holding;  ///< nothing: it did not answer
  std::optional<double> width;  ///< m
  kinematics::JointVector q;    ///< of the arm that carries the gripper, as sent
};
/// What has come of it: whether that is what was expected, and what the arm carries now.
Progress note_grip(const GripRequest& request, const GripOutcome& outcome, Context& context, Diagnostics& diagnostics);
/// The same for a rehearsal, in which every grip finds its part.
void rehearse_grip(const GripRequest& request, Rehearsal& rehearsal, Diagnostics& diagnostics);

}  // namespace takt::activity
