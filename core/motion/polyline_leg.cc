#include "core/motion/polyline_leg.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "core/motion/plan_checks.h"

namespace takt::motion {
namespace {

/// A line whose joints all move less than this has no direction, rad or m.
constexpr double kNoLine = 1e-9;

/// Lines between points, by the time that they take at the velocity limits ("cost").
class Polyline {
 public:
  Polyline(const ArmModel& arm, const JointVector& q_start, const std::vector<JointVector>& points) {
    q_.push_back(q_start);
    q_.insert(q_.end(), points.begin(), points.end());
    for (std::size_t i = 0; i + 1 < q_.size(); ++i)
      cost_.push_back((q_[i + 1] - q_[i]).cwiseAbs().cwiseQuotient(arm.limits.velocity).maxCoeff());
  }

  Leg leg(const std::vector<double>& corners) {
    double left = 0.0;  // of the line, taken by the corner before
    for (std::size_t i = 0; i < cost_.size(); ++i) {
      const bool last = i + 1 == cost_.size();
      const double taken = last ? 0.0 : corners[i] * std::min(cost_[i], cost_[i + 1]);
      add(JointLine{q_[i], q_[i + 1]}, cost_[i] - left - taken, left / cost_[i], 1.0 - taken / cost_[i]);
      if (!last) add(corner(i, taken), 2.0 * taken, 0.0, 1.0);
      left = taken;
    }
    for (PathPiece& piece : leg_.pieces) {
      piece.s_begin /= whole_;
      piece.s_end /= whole_;
    }
    leg_.pieces.back().s_end = 1.0;
    return std::move(leg_);
  }

 private:
  [[nodiscard]] JointVector direction(std::size_t line) const { return (q_[line + 1] - q_[line]) / cost_[line]; }

  /// Between the lines i and i + 1; joins both with their speed and without acceleration.
  [[nodiscard]] Geometry corner(std::size_t i, double taken) const {
    const JointVector zero = JointVector::Zero(q_[0].size()), in = direction(i), out = direction(i + 1);
    const Jet<JointVector> begin{q_[i + 1] - taken * in, 2.0 * taken * in, zero};
    const Jet<JointVector> end{q_[i + 1] + taken * out, 2.0 * taken * out, zero};
    return JointCurve{Quintic<JointVector>::between(begin, end)};
  }

  void add(Geometry geometry, double cost, double own_begin, double own_end) {
    leg_.pieces.push_back({.geometry = std::move(geometry),
                           .s_begin = whole_,
                           .s_end = whole_ + cost,
                           .own_begin = own_begin,
                           .own_end = own_end});
    whole_ += cost;
  }

  std::vector<JointVector> q_;
  std::vector<double> cost_;  ///< of each line, s
  Leg leg_ = {};
  double whole_ = 0.0;
};

Diagnostics check(const ArmModel& arm, const JointVector& q_start, const std::vector<JointVector>& points,
                  const std::vector<double>& corners) {
  Diagnostics diagnostics;
  check_limits(arm.chain, arm.limits, diagnostics);
  check_configuration(arm.chain, arm.limits, q_start, "/start", diagnostics);
  for (std::size_t i = 0; i < points.size(); ++i)
    check_configuration(arm.chain, arm.limits, points[i], "/points" + pointer_segment(i), diagnostics);
  if (points.empty() || corners.size() + 1 != points.size())
    diagnostics.error(Code::kWrongSize, "/corners", fmt::format("{} for {} points", corners.size(), points.size()),
                      "Give one less than points");
  if (std::ranges::any_of(corners, [](double share) { return !(share > 0.0 && share <= 0.5); }))
    diagnostics.error(Code::kOutOfRange, "/corners", "a share outside of its range",
                      "Choose a share above 0, at most 0.5");
  if (diagnostics.has_errors()) return diagnostics;
  for (std::size_t i = 0; points.size() > 1 && i < points.size(); ++i) {
    const JointVector& before = i == 0 ? q_start : points[i - 1];
    if ((points[i] - before).cwiseAbs().maxCoeff() < kNoLine)
      diagnostics.error(Code::kInvalidValue, "/points" + pointer_segment(i), "the point is the same as the one before",
                        "Choose points that differ");
  }
  return diagnostics;
}

}  // namespace

Result<Leg> polyline_leg(const ArmModel& arm, const JointVector& q_start, const std::vector<JointVector>& points,
                         const std::vector<double>& corners) {
  Diagnostics diagnostics = check(arm, q_start, points, corners);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  if (points.size() == 1) return ptp_leg(arm, q_start, points.front());
  return Polyline(arm, q_start, points).leg(corners);
}

JointVector fastest_of(const JointCurve& curve) {
  // Of the derivative, of degree 4: b_i = sum over k <= i of C(i, k) / C(4, k) d_k.
  constexpr std::array<std::array<double, 5>, 5> kPascal{
      {{1, 0, 0, 0, 0}, {1, 1, 0, 0, 0}, {1, 2, 1, 0, 0}, {1, 3, 3, 1, 0}, {1, 4, 6, 4, 1}}};
  JointVector fastest = JointVector::Zero(curve.q.c[0].size());
  for (std::size_t i = 0; i < 5; ++i) {
    JointVector point = JointVector::Zero(fastest.size());
    for (std::size_t k = 0; k <= i; ++k)
      point += kPascal[i][k] / kPascal[4][k] * static_cast<double>(k + 1) * curve.q.c[k + 1];
    fastest = fastest.cwiseMax(point.cwiseAbs());
  }
  return fastest;
}

}  // namespace takt::motion
