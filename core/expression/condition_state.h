#pragma once

#include <utility>
#include <variant>

#include "core/expression/cell.h"
#include "core/expression/condition.h"
#include "core/expression/state.h"

namespace takt::expression {

/// The number of a force/torque sensor that a comparison is about, N or Nm: the weight of what is mounted on it and its
/// bias removed, in its measuring frame. Null while it does not answer. Realtime: setup.
[[nodiscard]] RealSensor contact_quantity(const Cell& cell, const std::string& sensor, Quantity quantity,
                                          const Biases& biases);

/// Half the difference of what two wrist sensors feel, as forces in the world (N): what their arms do to the part
/// between them and not to its weight. Of arms whose bases are at rest. Null while one of them does not
/// answer. Realtime: setup.
[[nodiscard]] RealSensor internal_force(const Cell& cell, const std::string& one_sensor,
                                        const std::string& other_sensor, const Biases& biases = {});

/// A condition of a file as a state; a sensor that was never tared has no bias. Realtime: setup.
[[nodiscard]] State state_of(const Condition& condition, const Cell& cell, const Biases& biases);

/// What an operation waits for or watches: a condition as files have it, or any state of a program. A cheap value.
class StateSource {
 public:
  StateSource() = default;                                             ///< a condition that has not been read
  StateSource(Condition condition) : source_(std::move(condition)) {}  // NOLINT: {.until = condition}
  StateSource(State state) : source_(std::move(state)) {}              // NOLINT: {.until = is_greater(force, 5.0)}
  /// Null: it is a state of a program.
  [[nodiscard]] const Condition* condition() const { return std::get_if<Condition>(&source_); }
  [[nodiscard]] State state(const Cell& cell, const Biases& biases) const {
    return condition() != nullptr ? state_of(*condition(), cell, biases) : std::get<State>(source_);
  }

 private:
  std::variant<Condition, State> source_;
};
[[nodiscard]] inline State state_of(const StateSource& source, const Cell& cell, const Biases& biases) {
  return source.state(cell, biases);
}

}  // namespace takt::expression
