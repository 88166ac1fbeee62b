#include "core/expression/sensor.h"

#include <array>

#include <nlohmann/json.hpp>

#include "core/net/value_json.h"

namespace takt::expression {
namespace {

using Json = nlohmann::ordered_json;

/// An output of a primitive with inputs of these names.
template <class T>
Sensor<T> of(const char* primitive, const std::vector<std::pair<std::string, Operand>>& operands,
             Json parameters = Json::object(), const char* output = "value") {
  return Sensor<T>(apply(net::kValueType<T>, primitive, operands, std::move(parameters), output));
}

template <class T>
Sensor<T> unary(const char* primitive, const Operand& input, const char* output = "value") {
  return of<T>(primitive, {{"input", input}}, Json::object(), output);
}

template <class T>
Sensor<T> binary(const char* primitive, const Operand& a, const Operand& b) {
  return of<T>(primitive, {{"a", a}, {"b", b}});
}

}  // namespace

template <class T>
Term<T>::Term(const T& constant) : operand_{.node = nullptr, .constant = net::value_to_json(constant)} {}

template class Term<net::Boolean>;
template class Term<net::Integer>;
template class Term<net::Real>;
template class Term<net::Vector>;
template class Term<net::Frame>;
template class Term<net::Twist>;
template class Term<net::Wrench>;
template class Term<net::JointArray>;

using net::Frame;
using net::Integer;
using net::JointArray;
using net::Real;
using net::Twist;
using net::Vector;
using net::Wrench;

RealSensor operator+(const RealTerm& a, const RealTerm& b) { return binary<Real>("Add", a.operand(), b.operand()); }
RealSensor operator-(const RealTerm& a, const RealTerm& b) {
  return binary<Real>("Subtract", a.operand(), b.operand());
}
RealSensor operator*(const RealTerm& a, const RealTerm& b) {
  return binary<Real>("Multiply", a.operand(), b.operand());
}
RealSensor operator/(const RealTerm& a, const RealTerm& b) { return binary<Real>("Divide", a.operand(), b.operand()); }
RealSensor operator-(const RealSensor& a) { return unary<Real>("Negate", {.node = a.node()}); }
RealSensor abs(const RealTerm& a) { return unary<Real>("Abs", a.operand()); }
RealSensor sqrt(const RealTerm& a) { return unary<Real>("SquareRoot", a.operand()); }
RealSensor min(const RealTerm& a, const RealTerm& b) { return binary<Real>("Min", a.operand(), b.operand()); }
RealSensor max(const RealTerm& a, const RealTerm& b) { return binary<Real>("Max", a.operand(), b.operand()); }

RealSensor low_pass(const RealSensor& input, double cutoff) {
  return of<Real>("LowPass", {{"input", {.node = input.node()}}}, {{"cutoff", cutoff}});
}
VectorSensor low_pass(const VectorSensor& input, double cutoff) {
  return of<Vector>("LowPassVector", {{"input", {.node = input.node()}}}, {{"cutoff", cutoff}});
}
WrenchSensor low_pass(const WrenchSensor& input, double cutoff) {
  return of<Wrench>("LowPassWrench", {{"input", {.node = input.node()}}}, {{"cutoff", cutoff}});
}
RealSensor derivative(const RealSensor& input, double cutoff) {
  return of<Real>("FilteredDifferentiator", {{"input", {.node = input.node()}}}, {{"cutoff", cutoff}});
}

IntegerSensor operator+(const Term<Integer>& a, const Term<Integer>& b) {
  return binary<Integer>("AddIntegers", a.operand(), b.operand());
}
IntegerSensor operator-(const Term<Integer>& a, const Term<Integer>& b) {
  return binary<Integer>("SubtractIntegers", a.operand(), b.operand());
}

VectorSensor operator+(const VectorTerm& a, const VectorTerm& b) {
  return binary<Vector>("AddVectors", a.operand(), b.operand());
}
VectorSensor operator-(const VectorTerm& a, const VectorTerm& b) {
  return binary<Vector>("SubtractVectors", a.operand(), b.operand());
}
VectorSensor operator*(const RealTerm& factor, const VectorSensor& vector) {
  return of<Vector>("ScaleVector", {{"vector", {.node = vector.node()}}, {"factor", factor.operand()}});
}
RealSensor norm(const VectorTerm& a) { return unary<Real>("Norm", a.operand()); }
RealSensor dot(const VectorTerm& a, const VectorTerm& b) {
  return binary<Real>("DotProduct", a.operand(), b.operand());
}
RealSensor distance(const VectorTerm& a, const VectorTerm& b) {
  return binary<Real>("Distance", a.operand(), b.operand());
}
RealSensor component(const VectorSensor& vector, int axis) {
  static constexpr std::array kPorts = {"x", "y", "z"};
  if (axis < 0 || axis > 2)
    return RealSensor(broken(Code::kOutOfRange, net::ValueType::kReal, "a vector has axes 0 to 2", "Use x, y or z"));
  return unary<Real>("VectorComponents", {.node = vector.node()}, kPorts[static_cast<std::size_t>(axis)]);
}

FrameSensor operator*(const FrameTerm& X_AB, const FrameTerm& X_BC) {
  return of<Frame>("Compose", {{"left", X_AB.operand()}, {"right", X_BC.operand()}});
}
FrameSensor inverse(const FrameSensor& X_AB) { return unary<Frame>("Inverse", {.node = X_AB.node()}); }
VectorSensor position(const FrameSensor& X_AB) {
  return unary<Vector>("FrameComponents", {.node = X_AB.node()}, "position");
}
RealSensor distance(const FrameTerm& a, const FrameTerm& b) {
  return of<Real>("FrameDistance", {{"a", a.operand()}, {"b", b.operand()}}, Json::object(), "distance");
}
RealSensor angle(const FrameTerm& a, const FrameTerm& b) {
  return of<Real>("FrameDistance", {{"a", a.operand()}, {"b", b.operand()}}, Json::object(), "angle");
}
TwistSensor difference(const FrameTerm& from, const FrameTerm& to) {
  return of<Twist>("FrameDifference", {{"from", from.operand()}, {"to", to.operand()}});
}
VectorSensor transform(const FrameTerm& X_AB, const VectorTerm& p_B) {
  return of<Vector>("TransformPoint", {{"frame", X_AB.operand()}, {"point", p_B.operand()}});
}
VectorSensor rotate(const FrameTerm& X_AB, const VectorTerm& v_B) {
  return of<Vector>("RotateVector", {{"frame", X_AB.operand()}, {"vector", v_B.operand()}});
}
TwistSensor transform(const FrameTerm& X_AB, const Term<Twist>& V_B) {
  return of<Twist>("TransformTwist", {{"frame", X_AB.operand()}, {"twist", V_B.operand()}});
}
TwistSensor rotate(const FrameTerm& X_AB, const Term<Twist>& V_B) {
  return of<Twist>("RotateTwist", {{"frame", X_AB.operand()}, {"twist", V_B.operand()}});
}
WrenchSensor transform(const FrameTerm& X_AB, const Term<Wrench>& wrench_B) {
  return of<Wrench>("TransformWrench", {{"frame", X_AB.operand()}, {"wrench", wrench_B.operand()}});
}

TwistSensor operator+(const TwistSensor& a, const Term<Twist>& b) {
  return binary<Twist>("AddTwists", {.node = a.node()}, b.operand());
}
TwistSensor operator-(const TwistSensor& a, const Term<Twist>& b) {
  return binary<Twist>("SubtractTwists", {.node = a.node()}, b.operand());
}
VectorSensor linear(const TwistSensor& twist) {
  return unary<Vector>("TwistComponents", {.node = twist.node()}, "linear");
}
VectorSensor angular(const TwistSensor& twist) {
  return unary<Vector>("TwistComponents", {.node = twist.node()}, "angular");
}
WrenchSensor operator+(const WrenchSensor& a, const Term<Wrench>& b) {
  return binary<Wrench>("AddWrenches", {.node = a.node()}, b.operand());
}
WrenchSensor operator-(const WrenchSensor& a, const Term<Wrench>& b) {
  return binary<Wrench>("SubtractWrenches", {.node = a.node()}, b.operand());
}
VectorSensor force(const WrenchSensor& wrench) {
  return unary<Vector>("WrenchComponents", {.node = wrench.node()}, "force");
}
VectorSensor torque(const WrenchSensor& wrench) {
  return unary<Vector>("WrenchComponents", {.node = wrench.node()}, "torque");
}

JointsSensor operator-(const JointsSensor& a, const Term<JointArray>& b) {
  return binary<JointArray>("SubtractJoints", {.node = a.node()}, b.operand());
}
RealSensor element(const JointsSensor& joints, int index) {
  return of<Real>("JointElement", {{"input", {.node = joints.node()}}}, {{"index", index}});
}
RealSensor largest(const JointsSensor& joints) { return unary<Real>("LargestJoint", {.node = joints.node()}); }

}  // namespace takt::expression
