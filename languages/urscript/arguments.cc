#include "languages/urscript/arguments.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace takt::languages::urscript {

std::int32_t to_integer(double value) {
  using Limits = std::numeric_limits<std::int32_t>;
  if (!(value == value)) return 0;
  return static_cast<std::int32_t>(
      std::clamp(value, static_cast<double>(Limits::min()), static_cast<double>(Limits::max())));
}

void Arguments::refuse(std::size_t i, std::string_view expected) const {
  const auto given = i < size() ? std::string(call_.arguments[i].kind()) : "missing";
  throw BadArgument{fmt::format("argument {} is {}, expected {}", i + 1, given, expected)};
}

double Arguments::real(std::size_t i) const {
  if (i < size())
    if (const auto number = call_.arguments[i].number(); number && std::isfinite(*number)) return *number;
  refuse(i, "a number");
}

int Arguments::integer(std::size_t i) const { return to_integer(real(i)); }

int Arguments::integer(std::size_t i, int lower, int upper) const {
  const int value = integer(i);
  if (value < lower || value > upper)
    throw BadArgument{fmt::format("argument {} is {}, expected {} to {}", i + 1, value, lower, upper)};
  return value;
}

bool Arguments::boolean(std::size_t i) const {
  if (i < size())
    if (const auto truth = call_.arguments[i].truth()) return *truth;
  refuse(i, "a Boolean");
}

std::string Arguments::text(std::size_t i) const {
  if (i < size()) return call_.arguments[i].text();
  refuse(i, "a string");
}

Pose Arguments::pose(std::size_t i) const {
  if (i < size()) {
    if (const auto pose = call_.arguments[i].pose()) return *pose;
    if (const auto list = call_.arguments[i].numbers(6)) {
      Pose pose;
      std::ranges::copy(*list, pose.begin());
      return pose;
    }
  }
  refuse(i, "a pose");
}

std::vector<double> Arguments::numbers(std::size_t i, std::size_t count) const {
  if (i < size()) {
    const auto list = call_.arguments[i].numbers(count);
    if (list && std::ranges::all_of(*list, [](double x) { return std::isfinite(x); })) return *list;
  }
  refuse(i, fmt::format("a list of {} numbers", count));
}

kinematics::JointVector Arguments::joints(std::size_t i, std::size_t count) const {
  const auto list = numbers(i, count);
  kinematics::JointVector joints(static_cast<Eigen::Index>(count));
  std::ranges::copy(list, joints.begin());
  return joints;
}

}  // namespace takt::languages::urscript
