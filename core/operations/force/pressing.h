#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/activity/activity_model.h"
#include "core/command/actions/press_action.h"
#include "core/expression/condition_state.h"
#include "core/motion/planner.h"
#include "core/operations/command/operation_command.h"
#include "core/operations/table/compliance.h"
#include "core/operations/table/operation.h"
#include "core/operations/table/parameter_table.h"

/// What press, search and wipe come down to: along a direction until contact, then a force, with or without a path
/// across it. Realtime: setup.
namespace takt::operations {

struct Pressing {
  /// From where a path across the direction is planned.
  struct Start {
    const expression::Cell& cell;
    const Eigen::Vector3d& direction_B;  ///< of length 1, in the arm's base
    const Eigen::Isometry3d& X_BT;       ///< the tool, m
    const kinematics::JointVector& q;    ///< rad or m
  };
  using PathPlanner = std::function<Result<motion::SequencePlan>(const Start&)>;

  std::string_view type = "press";  ///< of the operation
  std::string name, pointer;        ///< of the operation
  std::string arm, sensor;
  ToolChoice tool = {};
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  std::string in = "tcp";                      ///< whose axes the direction is along
  double force = 0, approach = 0, travel = 0;  ///< N, m/s, m
  std::optional<double> seconds = {};          ///< for which the force is held once it is there
  std::optional<double> seconds_alone = {};    ///< the same where it is no part of a transaction
  double tolerance = 0.1;                      ///< share of the force: so far off counts as at force
  std::optional<double> drop = {};             ///< m
  std::optional<double> depth = {};            ///< m beyond the touch: more is not what was expected
  std::optional<double> lateral = {};          ///< N across the direction at most
  std::optional<expression::StateSource> until = {};
  std::optional<ComplianceParameters> compliance = {};
  std::optional<expression::StateSource> abort_if = {};
  PathPlanner path = {};        ///< of what is followed across the direction; null: nothing
  std::string path_key = {};    ///< where below the operation the path is described
  bool path_end_fails = false;  ///< the path was to find something: its end is a failure

  /// What it does depends on where the arm is: along the tool's own axes, a path from there, springs of the joints.
  [[nodiscard]] bool needs_place() const;
};

/// How it presses.
struct PlannedPressing {
  Eigen::Vector3d direction_B;  ///< of the force that the tool exerts, in the arm's base; of length 1
  command::PressControlParameters control;
};
/// What it comes to with the arm at q (rad or m). Without a compliance of its own the springs are those that the arm
/// has now. @return diagnostics: an unknown frame, a path that the arm cannot follow, springs that take up the travel.
[[nodiscard]] Result<PlannedPressing> plan_pressing(const Pressing& pressing, const expression::Cell& cell,
                                                    const kinematics::JointVector& q);

/// How an operation that presses has ended.
enum class PressOutcome : std::uint8_t {
  kRunning,         ///< it has not
  kHeld,            ///< the force was there for as long as was asked
  kFound,           ///< `drop` deeper than at the touch
  kConditionMet,    ///< `until` became true
  kPathEnded,       ///< the path or the pattern was gone through
  kNotTouched,      ///< the travel is used up and nothing was touched
  kTravelUsedUp,    ///< likewise, after the touch
  kDeeper,          ///< the tool went deeper than `depth_max_m` beyond the touch
  kPushedSideways,  ///< the force across the direction was more than `lateral_max_N`
  kSensorSilent,    ///< the force is not known
  kAborted,         ///< `abort_if` became true, or was unknown
  kStopped,         ///< by a fault or a stop, or it could not begin: ActivityRun::diagnostics() say why
  kInterrupted,     ///< it was cancelled
};
/// Of a run of press, search or wipe; also of one that has failed. @param key  under which a command of a transaction
/// keeps its values; empty: the run is the operation itself
[[nodiscard]] PressOutcome press_outcome(const activity::RunView& run, const std::string& key = {});
[[nodiscard]] std::string_view name_of(PressOutcome outcome);

// -- The forms of an operation that presses --------------------------------------------------------------------------

[[nodiscard]] std::unique_ptr<OperationCommand> pressing_command(Pressing pressing);

// -- What their parameters have in common ----------------------------------------------------------------------------

/// @param P  has the members of a Pressing
template <class P>
void add_pressing_devices(ParameterTable<P>& table) {
  table.name("arm", NameOf::kArm, &P::arm, "Arm that presses.")
      .name("sensor", NameOf::kSensor, &P::sensor, "Force/torque sensor on that arm.");
}
template <class P>
void add_pressing_force(ParameterTable<P>& table) {
  table.number("force_N", "N", &P::force, {.low = 0.1, .high = 1000.0}, "Force that the tool exerts.")
      .number("approach_m_s", "m/s", &P::approach, {.low = 0.0, .high = 0.1, .low_open = true}, "Speed until contact.")
      .number("travel_m", "m", &P::travel, {.low = 0.0, .high = 2.0, .low_open = true},
              "Largest distance along the direction, from the start.")
      .number("tolerance", "", &P::tolerance, {.low = 0.01, .high = 0.5},
              "Share of the force by which it may be off and still counts as reached.")
      .number("depth_max_m", "m", &P::depth, {.low = 0.0, .high = 2.0, .low_open = true},
              "Largest distance beyond the touch, as measured; more is a failure.")
      .number("lateral_max_N", "N", &P::lateral, {.low = 0.1, .high = 1000.0},
              "Largest force across the direction; more is a failure.")
      .condition("until", &P::until, "Ends the operation when it becomes true.")
      .rule([](P& p, const ReadContext& from) { check_pressing_sensor(p.arm, p.sensor, from); });
  add_common_parameters(table);
}
/// All of them, with a direction of one's own.
template <class P>
ParameterTable<P> pressing_parameters() {
  ParameterTable<P> table;
  add_pressing_devices(table);
  table.direction("direction", &P::direction, "Direction of the motion and of the force; any length but 0.")
      .text("in", &P::in, "Frame whose axes the direction is along; \"tcp\": those of the tool.");
  add_pressing_force(table);
  return table;
}
/// The sensor is on the arm.
void check_pressing_sensor(const std::string& arm, const std::string& sensor, const ReadContext& from);

/// What such parameters come down to, but for what they have of their own.
template <class P>
Pressing pressing_of(const P& p, std::string_view type) {
  Pressing pressing;
  pressing.type = type;
  pressing.name = p.name.empty() ? std::string(type) : p.name;
  pressing.pointer = p.pointer;
  pressing.arm = p.arm;
  pressing.sensor = p.sensor;
  pressing.tool = p.tool;
  pressing.force = p.force;
  pressing.approach = p.approach;
  pressing.travel = p.travel;
  pressing.tolerance = p.tolerance;
  pressing.depth = p.depth;
  pressing.lateral = p.lateral;
  pressing.until = p.until;
  pressing.compliance = p.compliance;
  pressing.abort_if = p.abort_if;
  if constexpr (requires { p.direction; }) pressing.direction = p.direction;
  if constexpr (requires { p.direction; }) pressing.in = p.in;
  return pressing;
}

}  // namespace takt::operations
