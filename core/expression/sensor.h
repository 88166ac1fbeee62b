#pragma once

#include <optional>
#include <string>

#include "core/expression/evaluate.h"

namespace takt::expression {

/// A source of values: a reading of a device, or a formula over others. It exists in the program (`now()`) and in every
/// net that uses it, and is the same primitives in both. A cheap value: a handle to an immutable formula. Any thread.
template <class T>
class Sensor {
 public:
  explicit Sensor(ExpressionPtr node) : node_(std::move(node)) {}

  /// The value now, outside of a net; nothing while there is none. What remembers (filters, timers) is as in the first
  /// cycle of a net. Thread: the one that steps the core, between cycles. Realtime: setup.
  [[nodiscard]] std::optional<T> now() const { return evaluate<T>(node_); }
  [[nodiscard]] const ExpressionPtr& node() const { return node_; }

 private:
  ExpressionPtr node_;
};

/// A side of a formula: a sensor, or a constant (in SI units).
template <class T>
class Term {
 public:
  Term(const Sensor<T>& sensor) : operand_{.node = sensor.node()} {}
  Term(const T& constant);
  [[nodiscard]] const Operand& operand() const { return operand_; }

 private:
  Operand operand_;
};

using RealSensor = Sensor<net::Real>;
using IntegerSensor = Sensor<net::Integer>;
using BooleanSensor = Sensor<net::Boolean>;
using VectorSensor = Sensor<net::Vector>;
using FrameSensor = Sensor<net::Frame>;
using TwistSensor = Sensor<net::Twist>;
using WrenchSensor = Sensor<net::Wrench>;
using JointsSensor = Sensor<net::JointArray>;
using RealTerm = Term<net::Real>;
using VectorTerm = Term<net::Vector>;
using FrameTerm = Term<net::Frame>;

// Arithmetic. Units are solved when the net is loaded; null of any side gives null. All: realtime: setup.
[[nodiscard]] RealSensor operator+(const RealTerm& a, const RealTerm& b);
[[nodiscard]] RealSensor operator-(const RealTerm& a, const RealTerm& b);
[[nodiscard]] RealSensor operator*(const RealTerm& a, const RealTerm& b);
[[nodiscard]] RealSensor operator/(const RealTerm& a, const RealTerm& b);  ///< null where b is 0
[[nodiscard]] RealSensor operator-(const RealSensor& a);
[[nodiscard]] RealSensor abs(const RealTerm& a);
[[nodiscard]] RealSensor sqrt(const RealTerm& a);  ///< null below 0
[[nodiscard]] RealSensor min(const RealTerm& a, const RealTerm& b);
[[nodiscard]] RealSensor max(const RealTerm& a, const RealTerm& b);
/// First-order low pass; begins with its first input. @param cutoff  Hz, at -3 dB
[[nodiscard]] RealSensor low_pass(const RealSensor& input, double cutoff);
[[nodiscard]] VectorSensor low_pass(const VectorSensor& input, double cutoff);
[[nodiscard]] WrenchSensor low_pass(const WrenchSensor& input, double cutoff);
/// Change per second, smoothed; 0 in the first cycle. @param cutoff  Hz, at -3 dB
[[nodiscard]] RealSensor derivative(const RealSensor& input, double cutoff);

[[nodiscard]] IntegerSensor operator+(const Term<net::Integer>& a, const Term<net::Integer>& b);
[[nodiscard]] IntegerSensor operator-(const Term<net::Integer>& a, const Term<net::Integer>& b);

// Vectors.
[[nodiscard]] VectorSensor operator+(const VectorTerm& a, const VectorTerm& b);
[[nodiscard]] VectorSensor operator-(const VectorTerm& a, const VectorTerm& b);
[[nodiscard]] VectorSensor operator*(const RealTerm& factor, const VectorSensor& vector);
[[nodiscard]] RealSensor norm(const VectorTerm& a);
[[nodiscard]] RealSensor dot(const VectorTerm& a, const VectorTerm& b);
[[nodiscard]] RealSensor distance(const VectorTerm& a, const VectorTerm& b);
/// @param axis  0: x, 1: y, 2: z
[[nodiscard]] RealSensor component(const VectorSensor& vector, int axis);

// Frames. What is between two of them has to meet: X_AB * X_BC.
[[nodiscard]] FrameSensor operator*(const FrameTerm& X_AB, const FrameTerm& X_BC);
[[nodiscard]] FrameSensor inverse(const FrameSensor& X_AB);
[[nodiscard]] VectorSensor position(const FrameSensor& X_AB);                                    ///< m
[[nodiscard]] RealSensor distance(const FrameTerm& a, const FrameTerm& b);                       ///< of the origins, m
[[nodiscard]] RealSensor angle(const FrameTerm& a, const FrameTerm& b);                          ///< rad, in [0, pi]
[[nodiscard]] TwistSensor difference(const FrameTerm& from, const FrameTerm& to);                ///< m, rad
[[nodiscard]] VectorSensor transform(const FrameTerm& X_AB, const VectorTerm& p_B);              ///< a point, m
[[nodiscard]] VectorSensor rotate(const FrameTerm& X_AB, const VectorTerm& v_B);                 ///< a direction
[[nodiscard]] TwistSensor transform(const FrameTerm& X_AB, const Term<net::Twist>& V_B);         ///< adjoint
[[nodiscard]] TwistSensor rotate(const FrameTerm& X_AB, const Term<net::Twist>& V_B);            ///< same point
[[nodiscard]] WrenchSensor transform(const FrameTerm& X_AB, const Term<net::Wrench>& wrench_B);  ///< adjoint

// Twists and wrenches.
[[nodiscard]] TwistSensor operator+(const TwistSensor& a, const Term<net::Twist>& b);
[[nodiscard]] TwistSensor operator-(const TwistSensor& a, const Term<net::Twist>& b);
[[nodiscard]] VectorSensor linear(const TwistSensor& twist);
[[nodiscard]] VectorSensor angular(const TwistSensor& twist);
[[nodiscard]] WrenchSensor operator+(const WrenchSensor& a, const Term<net::Wrench>& b);
[[nodiscard]] WrenchSensor operator-(const WrenchSensor& a, const Term<net::Wrench>& b);
[[nodiscard]] VectorSensor force(const WrenchSensor& wrench);   ///< N
[[nodiscard]] VectorSensor torque(const WrenchSensor& wrench);  ///< Nm

// Joints.
[[nodiscard]] JointsSensor operator-(const JointsSensor& a, const Term<net::JointArray>& b);
/// @param index  from 0; null where there is no such joint
[[nodiscard]] RealSensor element(const JointsSensor& joints, int index);
/// The largest size of an element.
[[nodiscard]] RealSensor largest(const JointsSensor& joints);

}  // namespace takt::expression
