#pragma once

#include "core/expression/sensor.h"

namespace takt::expression {

/// Something that holds or does not hold in each cycle: of a sensor, an action, an actuator, a command, or raised by an
/// event. Logic has three values (row N2); what null means where a state acts, the event handler says (command.h). A
/// cheap value: a handle to an immutable formula. Any thread.
class State {
 public:
  explicit State(ExpressionPtr node) : node_(std::move(node)) {}

  /// Holds once this has held without a break for `seconds` (whole cycles, rounded up).
  [[nodiscard]] State held_for(double seconds) const;
  /// Holds from the first cycle on in which this did. Never null: a null of this counts as not holding.
  [[nodiscard]] State once() const;
  /// Whether it holds now, outside of a net; nothing for null and for states of actions and commands. As Sensor::now().
  [[nodiscard]] std::optional<bool> now() const { return evaluate<net::Boolean>(node_); }
  [[nodiscard]] const ExpressionPtr& node() const { return node_; }

 private:
  ExpressionPtr node_;
};

// With the words of the language: `force_high and not door_open`. Realtime: setup.
[[nodiscard]] State operator&&(const State& a, const State& b);
[[nodiscard]] State operator||(const State& a, const State& b);
[[nodiscard]] State operator!(const State& a);

// States of sensors. Null where a side is null.
[[nodiscard]] State holds(const BooleanSensor& sensor);
[[nodiscard]] State is_greater(const RealTerm& a, const RealTerm& b);
[[nodiscard]] State is_less(const RealTerm& a, const RealTerm& b);
[[nodiscard]] State in_range(const RealTerm& a, const RealTerm& lower, const RealTerm& upper);
/// @param tolerance  largest difference that counts as equal, in the unit of both
[[nodiscard]] State equals(const RealTerm& a, const RealTerm& b, double tolerance);
[[nodiscard]] State equals(const Term<net::Integer>& a, const Term<net::Integer>& b);
/// Two poses differ by at most m and rad.
[[nodiscard]] State near(const FrameTerm& a, const FrameTerm& b, double distance, double angle);
/// No element differs by more than the tolerance, rad.
[[nodiscard]] State near(const JointsSensor& a, const Term<net::JointArray>& b, double tolerance);
/// The sensor does not answer. Never null.
template <class T>
[[nodiscard]] State is_null(const Sensor<T>& sensor);

}  // namespace takt::expression
