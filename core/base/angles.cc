#include "core/base/angles.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

namespace takt {
namespace {

constexpr double kPi = std::numbers::pi;

/// People write pi with two digits or more behind the point.
bool is_part_of_pi(double angle) {
  constexpr double kWritten = 0.002;
  const auto is_multiple_of = [angle](double part) {
    const double count = std::round(angle / part);
    return count != 0.0 && std::abs(angle - count * part) < kWritten;
  };
  return is_multiple_of(kPi / 6.0) || is_multiple_of(kPi / 4.0);
}

}  // namespace

bool look_like_radians(std::span<const double> degrees) {
  constexpr double kTurn = 2.0 * kPi + 0.01;
  return std::ranges::all_of(degrees, [](double angle) { return std::abs(angle) <= kTurn; }) &&
         std::ranges::any_of(degrees, is_part_of_pi);
}

void warn_of_radians(std::span<const double> degrees, std::string pointer, Diagnostics& diagnostics) {
  if (!look_like_radians(degrees)) return;
  const double angle = *std::ranges::find_if(degrees, is_part_of_pi);
  diagnostics.warning(Code::kInvalidValue, std::move(pointer),
                      fmt::format("these angles look like radians: {:g} is taken as {:g} deg", angle, angle),
                      fmt::format("Give degrees: {:g} rad are {:.6g} deg", angle, angle * 180.0 / kPi));
}

}  // namespace takt
