#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/kinematics/types.h"
#include "languages/urscript/program.h"

namespace takt::languages::urscript {

/// The nearest integer that a script can have; 0 for what is no number.
[[nodiscard]] std::int32_t to_integer(double value);

/// An argument of a built-in function that is not what it must be. Thrown and caught within one call.
struct BadArgument {
  std::string text;
};

/// The arguments of one call, by their places.
class Arguments {
 public:
  explicit Arguments(const Call& call) : call_(call) {}

  [[nodiscard]] int thread() const { return call_.thread; }
  [[nodiscard]] std::size_t size() const { return call_.arguments.size(); }
  [[nodiscard]] const Value& operator[](std::size_t i) const { return call_.arguments[i]; }
  /// Not given.
  [[nodiscard]] bool none(std::size_t i) const { return i >= size() || call_.arguments[i].is_none(); }
  [[nodiscard]] double real(std::size_t i) const;
  [[nodiscard]] int integer(std::size_t i) const;
  /// lower <= value <= upper
  [[nodiscard]] int integer(std::size_t i, int lower, int upper) const;
  [[nodiscard]] bool boolean(std::size_t i) const;
  [[nodiscard]] std::string text(std::size_t i) const;
  [[nodiscard]] Pose pose(std::size_t i) const;
  [[nodiscard]] std::vector<double> numbers(std::size_t i, std::size_t count) const;
  [[nodiscard]] kinematics::JointVector joints(std::size_t i, std::size_t count = 6) const;

 private:
  [[noreturn]] void refuse(std::size_t i, std::string_view expected) const;

  const Call& call_;
};

/// A function that may throw BadArgument, as a library wants it.
template <class Run>
[[nodiscard]] std::function<Outcome(const Call&)> checked(Run run) {
  return [run](const Call& call) -> Outcome {
    try {
      return run(Arguments(call));
    } catch (BadArgument& bad) {
      return Failed{std::move(bad.text)};
    }
  };
}

/// Six numbers, as scripts have joint positions, velocities and wrenches.
template <class Vector>
[[nodiscard]] Value to_value(const Vector& vector) {
  return to_list(std::vector<double>(vector.begin(), vector.end()));
}

}  // namespace takt::languages::urscript
