#include "core/base/json_numbers.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

namespace takt {
namespace {

double rounded(double value, int digits) {
  std::array<char, 40> text{};
  const auto written =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::scientific, digits - 1);
  double read = value;
  (void)std::from_chars(text.data(), written.ptr, read);
  return read;
}

double meant(double value) {
  constexpr int kWritten = 12;  // digits that people write
  constexpr double kNoise = 4 * std::numeric_limits<double>::epsilon();
  if (!std::isfinite(value)) return value;
  const double plain = rounded(value, kWritten);
  return std::abs(value - plain) <= kNoise * std::abs(value) ? plain : value;
}

}  // namespace

/// Recursion is bounded by the depth that JSON files may have.
nlohmann::ordered_json without_noise(nlohmann::ordered_json json) {
  if (json.is_number_float()) return meant(json.get<double>());
  if (json.is_structured())
    for (auto& member : json) member = without_noise(std::move(member));
  return json;
}

}  // namespace takt
