#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/expression/condition.h"
#include "core/expression/state.h"

namespace takt::operations {

/// The state of an event of a transaction, as a file has it:
///   a condition over sensors (core/expression/condition.h)
///   {"completed": COMMAND}                     also started, active, stopped, cancelled
///   {"action": COMMAND, "is": "error"}         a state of what the command does
///   {"action": COMMAND, "at_path": 0.5}        a planned motion is at or past this share of its path
///   {"action": COMMAND, "via_passed": 0}       motions as one: that blend is passed
///   {"actuator": DEVICE, "is": "completed"}    also invalid_set_point, emergency_stop
///   {"raised": NAME}
///   {"all": [...]}, {"any": [...]}, {"not": {...}}
/// each with "held_for_s": it holds once it has held so long without a break.
struct StateParameters {
  enum class Kind { kCondition, kCommand, kAction, kActuator, kRaised, kAll, kAny, kNot };
  Kind kind = Kind::kCondition;
  std::string pointer;
  expression::Condition condition;        ///< of kCondition
  std::string of;                         ///< command, device, or raised state
  std::string is;                         ///< which state of it; of kAction "at_path" and "via_passed" too
  double share = 0.0;                     ///< of "at_path"
  int index = 0;                          ///< of "via_passed"
  std::optional<double> held_for;         ///< s
  std::vector<StateParameters> operands;  ///< of kAll and kAny at least one, of kNot exactly one
};
/// Diagnostics: all that is wrong with its form. Realtime: setup.
[[nodiscard]] StateParameters read_state(const nlohmann::ordered_json& json, const std::string& pointer,
                                         const expression::Cell& cell, Diagnostics& diagnostics);

/// A value that a transaction captures, or that an output follows, as a file has it:
///   {"sensor": NAME, "quantity": Q}     as in conditions
///   {"input": NAME}, {"gripper": NAME}, {"channel": NAME}    level or value; width; Real or Boolean
///   {"speed": ARM}                      of its tool centre point in its base, measured, m/s
///   {"progress": COMMAND}               how far a planned motion is on its path, 0 to 1
struct ValueParameters {
  enum class Kind { kForce, kInput, kWidth, kChannel, kSpeed, kProgress };
  Kind kind = Kind::kForce;
  std::string of;
  expression::Quantity quantity = expression::Quantity::kForce;
};
[[nodiscard]] ValueParameters read_value(const nlohmann::ordered_json& json, const std::string& pointer,
                                         const expression::Cell& cell, Diagnostics& diagnostics);
/// Whether it is a number for sure, and not true or false; false with a diagnostic below the pointer.
bool check_number(const ValueParameters& value, const expression::Cell& cell, const std::string& pointer,
                  Diagnostics& diagnostics);
/// Its unit; null for one that does not exist, or is no number.
[[nodiscard]] std::optional<std::string> unit_of(const ValueParameters& value, const expression::Cell& cell);
/// The number as a sensor. Not of kProgress. @param biases  as tared until now
[[nodiscard]] expression::RealSensor number_of(const ValueParameters& value, const expression::Cell& cell,
                                               const expression::Biases& biases);
/// It is true or false: a digital input, a Boolean channel.
[[nodiscard]] bool is_boolean(const ValueParameters& value, const expression::Cell& cell);
[[nodiscard]] expression::State boolean_of(const ValueParameters& value, const expression::Cell& cell);

}  // namespace takt::operations
