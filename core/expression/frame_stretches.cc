#include "core/expression/frame_stretches.h"

#include <algorithm>

namespace takt::expression {
namespace {

/// When a law is at s.
double time_at(const motion::TimeLaw& law, double s) {
  double before = 0.0, after = law.duration();
  if (s <= 0.0) return before;
  if (s >= 1.0) return after;
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (before + after);
    (law.at(middle).s < s ? before : after) = middle;
  }
  return after;
}

}  // namespace

std::vector<Interval> stretches_of_frame(const motion::Motion& motion) {
  std::vector<Interval> stretches;
  bool goes_on = false;
  for (const motion::PathPiece& piece : motion::pieces_of(motion.path)) {
    const bool cartesian = motion::is_cartesian(piece.geometry);
    if (cartesian && !goes_on) stretches.push_back({.begin = time_at(motion.law, piece.s_begin), .end = 0.0});
    if (cartesian) stretches.back().end = time_at(motion.law, piece.s_end);
    goes_on = cartesian;
  }
  return stretches;
}

Interval common(const Interval& a, const Interval& b) {
  return {.begin = std::max(a.begin, b.begin), .end = std::min(a.end, b.end)};
}
bool is_some(const Interval& interval) {
  constexpr double kLeast = 1e-6;  // s
  return interval.end - interval.begin > kLeast;
}

}  // namespace takt::expression
