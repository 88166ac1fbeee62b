#pragma once

#include <vector>

#include <Eigen/Core>

namespace takt::operations {

/// Points of a search in a plane, m from where it begins; the first is not the beginning itself.
enum class SearchPattern { kSpiral, kZigzag };

/// Rows or turns lie `pitch` apart; the pattern ends `radius` from the middle (zigzag: fills a square of twice that).
/// Realtime: setup.
[[nodiscard]] std::vector<Eigen::Vector2d> search_points(SearchPattern pattern, double radius, double pitch);
/// More are refused by `search`.
inline constexpr std::size_t kMostSearchPoints = 199;
/// How many there are.
[[nodiscard]] std::size_t search_size(SearchPattern pattern, double radius, double pitch);

}  // namespace takt::operations
