#pragma once

#include <cmath>
#include <concepts>
#include <type_traits>

#include "core/net/value.h"

namespace takt::primitives {

/// Calls f(number of a, number of b...) for all numbers of values of one type; the result has the shape of the first.
/// Joint arrays must have one size. Realtime: cyclic.
template <class F>
net::Real each(F f, net::Real a, std::same_as<net::Real> auto... b) {
  return f(a, b...);
}
template <class F>
net::Vector each(F f, const net::Vector& a, const std::same_as<net::Vector> auto&... b) {
  return {f(a[0], b[0]...), f(a[1], b[1]...), f(a[2], b[2]...)};
}
template <class F>
net::Twist each(F f, const net::Twist& a, const std::same_as<net::Twist> auto&... b) {
  return {.linear = each(f, a.linear, b.linear...), .angular = each(f, a.angular, b.angular...)};
}
template <class F>
net::Wrench each(F f, const net::Wrench& a, const std::same_as<net::Wrench> auto&... b) {
  return {.force = each(f, a.force, b.force...), .torque = each(f, a.torque, b.torque...)};
}
template <class F>
net::JointArray each(F f, const net::JointArray& a, const std::same_as<net::JointArray> auto&... b) {
  net::JointArray result;
  result.size = a.size;
  for (std::size_t i = 0; i < static_cast<std::size_t>(a.size); ++i) result.value[i] = f(a.value[i], b.value[i]...);
  return result;
}

/// a + k (b - a): a step of a filter, a point of a line.
template <class T>
T toward(const T& a, const T& b, double k) {
  return each([k](double x, double y) { return x + k * (y - x); }, a, b);
}
template <class T>
T plus(const T& a, const T& b) {
  return each([](double x, double y) { return x + y; }, a, b);
}
template <class T>
T minus(const T& a, const T& b) {
  return each([](double x, double y) { return x - y; }, a, b);
}
template <class T>
T times(const T& a, double k) {
  return each([k](double x) { return k * x; }, a);
}

/// Whether an operation on both is defined; joint arrays of two sizes have none.
template <class T>
bool same_shape(const T& a, const T& b) {
  if constexpr (std::is_same_v<T, net::JointArray>) {
    return a.size == b.size;
  } else {
    return true;
  }
}

/// Whether every number is finite.
template <class T>
bool finite(const T& value) {
  bool all = true;
  each(
      [&all](double x) {
        all = all && std::isfinite(x);
        return x;
      },
      value);
  return all;
}

}  // namespace takt::primitives
