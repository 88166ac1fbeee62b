#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/command/actions/compliance_action.h"
#include "core/operations/table/parameter.h"

namespace takt::operations {

struct Rehearsal;

/// Compliance of an arm while an operation does something else: key "compliance" (docs/scenarios.md), or springs of a
/// program, which may be formulas.
struct ComplianceParameters {
  ComplianceParameters() = default;
  ComplianceParameters(const command::SpringParameters& springs)  // NOLINT: {.compliance = springs}
      : mode(command::mode_of(springs)), of_program(springs) {}
  ComplianceParameters(const command::Stiff& springs)  // NOLINT: likewise
      : ComplianceParameters(command::SpringParameters(springs)) {}
  ComplianceParameters(const command::JointCompliance& springs)  // NOLINT: likewise
      : ComplianceParameters(command::SpringParameters(springs)) {}
  ComplianceParameters(const command::CartesianCompliance& springs)  // NOLINT: likewise
      : ComplianceParameters(command::SpringParameters(springs)) {}

  device::ControlMode mode = device::ControlMode::kPosition;
  /// As they are in the file, by key: one number for all joints or axes, or one for each.
  std::map<std::string, std::vector<double>, std::less<>> values;
  bool in_tool_axes = false;

  std::optional<command::SpringParameters> of_program = {};  ///< in place of `values` and `in_tool_axes`

  [[nodiscard]] bool operator==(const ComplianceParameters& other) const {
    return mode == other.mode && values == other.values && in_tool_axes == other.in_tool_axes &&
           command::same(of_program, other.of_program);
  }
};

/// The parameter "compliance" of an operation, for its table.
[[nodiscard]] const ParameterInfo& compliance_parameter();
/// The key "compliance" of a step; nothing: the step has none. Diagnostics: all that is wrong with its form. Realtime:
/// setup.
[[nodiscard]] std::optional<ComplianceParameters> read_compliance(ObjectReader& step);

/// @param joint_count  of the arm
[[nodiscard]] command::SpringParameters compliance_of(const ComplianceParameters& request, int joint_count);

/// Two arms as one exert nothing beside their springs: diagnostics at its keys below the pointer of the step.
void check_springs_of_two(const ComplianceParameters& request, const std::string& pointer, Diagnostics& diagnostics);

/// The springs that the device has with it: what the request does not say is the device's standard. Of mode position if
/// it has none, or not that mode.
[[nodiscard]] device::Compliance springs_of(const ComplianceParameters& request, const device::ArmDescription& arm);

/// What the devices of the arms do not allow that are compliant together, at its key below the step. Nothing of
/// arms of which only the names are known.
[[nodiscard]] Diagnostics check_compliance(const ComplianceParameters& request, const expression::Cell& cell,
                                           const std::vector<std::string>& arms);

/// In a rehearsal: whether the arms can be in that mode there, and what their devices do not allow. After it they are
/// in that mode. @param pointer  of the step. @return false: with diagnostics
bool rehearse_compliance(const ComplianceParameters& request, Rehearsal& rehearsal,
                         const std::vector<std::string>& arms, const std::string& pointer, Diagnostics& diagnostics);

/// A step of a rehearsal needs a control mode: whether START can give it there, with diagnostics at "/compliance" below
/// the step if not. After it the arm is in that mode.
void rehearse_mode(Rehearsal& rehearsal, const std::string& arm, device::ControlMode needed, const std::string& pointer,
                   Diagnostics& diagnostics);

/// Locations below the step for those that the command layer reports below a command: theirs, ours.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> places_of(const ComplianceParameters& request);

}  // namespace takt::operations
