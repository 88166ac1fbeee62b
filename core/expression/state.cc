#include "core/expression/state.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::expression {
namespace {

using Json = nlohmann::ordered_json;

State of(std::string primitive, const std::vector<std::pair<std::string, Operand>>& operands,
         Json parameters = Json::object()) {
  return State(apply(net::ValueType::kBoolean, std::move(primitive), operands, std::move(parameters)));
}

State gate(const char* primitive, const State& a, const State& b) {
  return of(primitive, {{"a", {.node = a.node()}}, {"b", {.node = b.node()}}});
}

}  // namespace

State State::held_for(double seconds) const {
  constexpr double kLongest = 1e6;  // s: what timers take
  if (!(seconds >= 0.0 && seconds <= kLongest)) {
    return State(broken(Code::kOutOfRange, net::ValueType::kBoolean, fmt::format("a time of {:g} s", seconds),
                        fmt::format("Choose 0 to {:g} s", kLongest)));
  }
  return of("OnDelay", {{"input", {.node = node_}}}, {{"delay", seconds}});
}

State State::once() const {
  const State known = of("DefaultToBoolean", {{"input", {.node = node_}}}, {{"fallback", false}});
  return of("SetResetLatch", {{"set", {.node = known.node()}}, {"reset", {.node = {}, .constant = false}}});
}

State operator&&(const State& a, const State& b) { return gate("And", a, b); }
State operator||(const State& a, const State& b) { return gate("Or", a, b); }
State operator!(const State& a) { return of("Not", {{"input", {.node = a.node()}}}); }

State holds(const BooleanSensor& sensor) { return State(sensor.node()); }
State is_greater(const RealTerm& a, const RealTerm& b) {
  return of("GreaterThan", {{"a", a.operand()}, {"b", b.operand()}});
}
State is_less(const RealTerm& a, const RealTerm& b) { return of("LessThan", {{"a", a.operand()}, {"b", b.operand()}}); }
State in_range(const RealTerm& a, const RealTerm& lower, const RealTerm& upper) {
  return of("InRange", {{"input", a.operand()}, {"lower", lower.operand()}, {"upper", upper.operand()}});
}
State equals(const RealTerm& a, const RealTerm& b, double tolerance) {
  return of("Equal", {{"a", a.operand()}, {"b", b.operand()}}, {{"tolerance", tolerance}});
}
State equals(const Term<net::Integer>& a, const Term<net::Integer>& b) {
  return of("EqualIntegers", {{"a", a.operand()}, {"b", b.operand()}});
}
State near(const FrameTerm& a, const FrameTerm& b, double distance, double angle) {
  return of("FramesNear", {{"a", a.operand()}, {"b", b.operand()}}, {{"distance_max", distance}, {"angle_max", angle}});
}
State near(const JointsSensor& a, const Term<net::JointArray>& b, double tolerance) {
  return of("JointsNear", {{"a", {.node = a.node()}}, {"b", b.operand()}}, {{"tolerance", tolerance}});
}

template <class T>
State is_null(const Sensor<T>& sensor) {
  return of("IsNull" + std::string(net::name_of(net::kValueType<T>)), {{"input", {.node = sensor.node()}}});
}

template State is_null(const BooleanSensor&);
template State is_null(const IntegerSensor&);
template State is_null(const RealSensor&);
template State is_null(const VectorSensor&);
template State is_null(const FrameSensor&);
template State is_null(const TwistSensor&);
template State is_null(const WrenchSensor&);
template State is_null(const JointsSensor&);

}  // namespace takt::expression
