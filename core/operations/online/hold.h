#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/operations/command/operation_activity.h"
#include "core/operations/online/online.h"

/// "hold": an arm stays where it is, with a living command. Realtime: setup.
namespace takt::operations {

struct HoldParameters {
  std::string arm = {};                ///< empty: the only one
  std::optional<double> seconds = {};  ///< s; nothing: until it is cancelled
  std::optional<expression::StateSource> until = {};
  std::optional<expression::StateSource> abort_if = {};  ///< must not hold: it comes to rest and fails
  std::optional<ComplianceParameters> compliance = {};   ///< nothing: as the arm is
  ToolChoice tool = {};                                  ///< of the arm; default: the one that the cell declares
  std::string name = {}, pointer = {};                   ///< for people; in its file
};
[[nodiscard]] const ParameterTable<HoldParameters>& hold_parameters();
[[nodiscard]] std::unique_ptr<OperationCommand> hold_command(const HoldParameters& parameters);
[[nodiscard]] inline OperationForm<HoldParameters> form_of(const HoldParameters&) {
  return {"hold", hold_parameters, &HoldParameters::arm, hold_command, activity::ArmAfter::kStays};
}
[[nodiscard]] Operation hold_operation();

}  // namespace takt::operations
