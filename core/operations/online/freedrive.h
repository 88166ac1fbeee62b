#pragma once

#include <optional>
#include <string>

#include "core/activity/activity_model.h"
#include "core/expression/condition_state.h"
#include "core/operations/table/operation.h"
#include "core/operations/table/tool_choice.h"

/// "freedrive": a person guides an arm by hand. Realtime: setup.
namespace takt::operations {

struct FreedriveParameters {
  std::string arm = {};                                 ///< empty: the only one
  std::optional<expression::StateSource> enabled = {};  ///< dead-man switch; nothing: always
  std::optional<expression::StateSource> until = {};
  std::optional<double> seconds = {};                    ///< s; with neither until it is cancelled
  double velocity = 0.25;                                ///< of the tool at most, m/s
  double turn = 1.0;                                     ///< of the tool at most, rad/s
  std::optional<expression::StateSource> abort_if = {};  ///< must not hold: it comes to rest and fails
  ToolChoice tool = {};                                  ///< of the arm; default: the one that the cell declares
  std::string name = {}, pointer = {};                   ///< for people; in its file
};
[[nodiscard]] const ParameterTable<FreedriveParameters>& freedrive_parameters();
/// From the control mode that the arm is in back into that; where the arm is then is unknown before the run.
[[nodiscard]] activity::ActivityPtr freedrive_activity(const FreedriveParameters& parameters,
                                                       const expression::Cell& cell, const expression::Biases& biases);
[[nodiscard]] Operation freedrive_operation();

}  // namespace takt::operations
