#pragma once

#include <optional>
#include <string>

#include "core/operations/command/operation_activity.h"
#include "core/operations/process/weld_line.h"

/// "weld": welds along a line of a workpiece, as one command (docs/welding.md). Realtime: setup.
namespace takt::operations {

/// A swing of the torch across the line.
struct WeldWeave {
  double amplitude = 0.002, frequency = 2.0, ramp = 0.5;  ///< m, Hz, s
};

/// From where the arm is: to the beginning of the line, along it, and away from it.
struct WeldParameters {
  std::string arm = {};        ///< empty: the only one
  std::string torch = {};      ///< device with the signals gas, arc, wire, established; empty: the only one
  std::string workpiece = {};  ///< object with lines
  std::string line = {};       ///< of it
  double travel = 0.008;       ///< along the line, m/s
  TorchAngles angles = {};
  double blend = 0.004;  ///< at corners, m
  std::optional<WeldWeave> weave = {};
  double preflow = 0.3, ignition_timeout = 1.0, crater = 0.3, postflow = 0.5;  ///< s
  double overlap = 0.005;                                                      ///< m, after a break
  int restarts = 0;                                      ///< how often an arc that was lost is lit again
  double approach_velocity = 0.1;                        ///< to the line and away from it, m/s
  double retract = 0.05;                                 ///< m, along the torch
  std::optional<expression::StateSource> abort_if = {};  ///< must not hold: the seam is ended in order, and it fails
  ToolChoice tool = {};                                  ///< of the arm; default: the one that the cell declares
  std::string name = {}, pointer = {};                   ///< for people; in its file
};

[[nodiscard]] const ParameterTable<WeldParameters>& weld_parameters();
[[nodiscard]] std::unique_ptr<OperationCommand> weld_command(const WeldParameters& parameters);
[[nodiscard]] inline OperationForm<WeldParameters> form_of(const WeldParameters&) {
  return {"weld", weld_parameters, &WeldParameters::arm, weld_command};
}
[[nodiscard]] Operation weld_operation();

}  // namespace takt::operations
