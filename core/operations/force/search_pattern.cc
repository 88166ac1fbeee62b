#include "core/operations/force/search_pattern.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace takt::operations {
namespace {

/// Points a turn: a spline through them leaves a circle by less than a thousandth of its radius.
constexpr int kPointsPerTurn = 10;
constexpr int kPointsPerRow = 5;

std::size_t rows(double radius, double pitch) { return static_cast<std::size_t>(std::floor(2.0 * radius / pitch)) + 1; }

/// Archimedes' spiral: the radius grows by `pitch` a turn.
std::vector<Eigen::Vector2d> spiral(double radius, double pitch) {
  std::vector<Eigen::Vector2d> points;
  const std::size_t count = search_size(SearchPattern::kSpiral, radius, pitch);
  for (std::size_t i = 1; i <= count; ++i) {
    const double turns = static_cast<double>(i) / kPointsPerTurn;
    const double angle = 2.0 * std::numbers::pi * turns;
    points.push_back(std::min(radius, pitch * turns) * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

/// Rows of a square, each opposite to the one before.
std::vector<Eigen::Vector2d> zigzag(double radius, double pitch) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t row = 0; row < rows(radius, pitch); ++row) {
    const double y = static_cast<double>(row) * pitch - radius;
    const double sign = row % 2 == 0 ? 1.0 : -1.0;
    for (int i = 0; i < kPointsPerRow; ++i) {
      const double x = sign * radius * (2.0 * i / (kPointsPerRow - 1) - 1.0);
      points.emplace_back(x, y);
    }
  }
  return points;
}

}  // namespace

std::size_t search_size(SearchPattern pattern, double radius, double pitch) {
  if (pattern == SearchPattern::kZigzag) return rows(radius, pitch) * kPointsPerRow;
  return static_cast<std::size_t>(std::ceil(kPointsPerTurn * radius / pitch)) + kPointsPerTurn;
}

std::vector<Eigen::Vector2d> search_points(SearchPattern pattern, double radius, double pitch) {
  return pattern == SearchPattern::kSpiral ? spiral(radius, pitch) : zigzag(radius, pitch);
}

}  // namespace takt::operations
