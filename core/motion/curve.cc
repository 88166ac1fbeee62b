#include "core/motion/curve.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::motion {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostPoints = 10000;
constexpr double kLargest = 1e100;
constexpr int kMostListed = 20;

/// What is wrong with one point; empty if nothing.
std::string fault(const Json& point, std::size_t size) {
  if (!point.is_array() || point.size() != size) return fmt::format("not an array of {} numbers", size);
  for (const Json& number : point) {
    if (!number.is_number() || !(std::abs(number.get<double>()) <= kLargest)) return "not all are numbers up to 1e100";
  }
  return {};
}

}  // namespace

Result<Curve> Curve::from_json(const Json& json, Form form, const std::string& pointer) {
  if (!json.is_array() || json.size() < 2 || json.size() > kMostPoints)
    return failure(Code::kWrongType, pointer, "not an array of points",
                   fmt::format("Give 2 to {} points [x, y, ...]", kMostPoints));
  const std::size_t size = json.front().is_array() ? json.front().size() : 0;
  if (size < 2 || size > static_cast<std::size_t>(kinematics::kMaxJoints) + 1)
    return failure(Code::kWrongType, pointer + "/0", "the first point is not an array of 2 to 13 numbers",
                   "Give x, then the values there");
  Diagnostics diagnostics;
  Curve curve;
  curve.dimension_ = static_cast<int>(size) - 1;
  for (std::size_t i = 0; i < json.size() && diagnostics.list().size() < kMostListed; ++i) {
    const std::string place = pointer + pointer_segment(i), wrong = fault(json[i], size);
    if (!wrong.empty()) {
      diagnostics.error(Code::kWrongSize, place, wrong,
                        fmt::format("Give x and {} values, as in the first point", curve.dimension_));
      continue;
    }
    const double x = json[i][0].get<double>();
    if (!curve.x_.empty() && x <= curve.x_.back())
      diagnostics.error(Code::kOutOfRange, place + "/0", fmt::format("x = {} is not above {}", x, curve.x_.back()),
                        "Give ascending x");
    curve.x_.push_back(x);
    JointVector y(curve.dimension_);
    for (int k = 0; k < curve.dimension_; ++k) y[k] = json[i][static_cast<std::size_t>(k) + 1].get<double>();
    curve.y_.push_back(y);
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  curve.bend(form);
  return curve;
}

/// The second derivatives that make the first ones meet: a tridiagonal system, solved from front to back and back again
/// (Thomas). A straight line has none.
void Curve::bend(Form form) {
  const std::size_t n = x_.size();
  const JointVector zero = JointVector::Zero(dimension_);
  bend_.assign(n, zero);
  if (form == Form::kLinear) return;
  const bool rest = form == Form::kRest;
  std::vector<double> upper(n, 0.0);
  const auto slope = [&](std::size_t i) -> JointVector { return (y_[i + 1] - y_[i]) / (x_[i + 1] - x_[i]); };
  const auto width = [&](std::size_t i) { return x_[i + 1] - x_[i]; };
  // Row i: below * bend[i-1] + diagonal * bend[i] + above * bend[i+1] = right.
  for (std::size_t i = 0; i < n; ++i) {
    const bool first = i == 0, last = i + 1 == n;
    if ((first || last) && !rest) continue;  // bend = 0
    const double below = first ? 0.0 : width(i - 1), above = last ? 0.0 : width(i);
    const JointVector right = 6.0 * ((last ? zero : slope(i)) - (first ? zero : slope(i - 1)));
    const double pivot = 2.0 * (below + above) - below * (first ? 0.0 : upper[i - 1]);
    upper[i] = above / pivot;
    bend_[i] = first ? JointVector(right / pivot) : JointVector((right - below * bend_[i - 1]) / pivot);
  }
  for (std::size_t i = n - 1; i-- > 0;) bend_[i] -= upper[i] * bend_[i + 1];
}

Curve::Sample Curve::at(double x) const {
  const JointVector zero = JointVector::Zero(dimension_);
  if (!(x >= first())) return {.y = y_.front(), .dy = zero, .ddy = zero, .inside = false};
  if (x > last()) return {.y = y_.back(), .dy = zero, .ddy = zero, .inside = false};
  const auto next = std::upper_bound(x_.begin() + 1, x_.end() - 1, x);
  const auto i = static_cast<std::size_t>(next - x_.begin()) - 1;
  const double h = x_[i + 1] - x_[i], b = (x - x_[i]) / h, a = 1.0 - b;
  Sample sample;
  sample.y = a * y_[i] + b * y_[i + 1] + (h * h / 6.0) * ((a * a * a - a) * bend_[i] + (b * b * b - b) * bend_[i + 1]);
  sample.dy =
      (y_[i + 1] - y_[i]) / h + (h / 6.0) * ((1.0 - 3.0 * a * a) * bend_[i] + (3.0 * b * b - 1.0) * bend_[i + 1]);
  sample.ddy = a * bend_[i] + b * bend_[i + 1];
  return sample;
}

}  // namespace takt::motion
