#include "core/planning/rounded_path.h"

#include <utility>

namespace takt::planning {
namespace {

constexpr double kRoundest = 0.45;  ///< of a line, so that some of it is left between two corners
constexpr double kSharpest = 1e-3;

bool is_free(FreeSpace& space, const motion::JointCurve& curve) {
  return space.is_free(Stretch{.at = [&curve](double u, JointVector& q) { q = curve.q.at(u).value; },
                               .fastest = motion::fastest_of(curve)});
}

}  // namespace

Result<motion::Leg> rounded_path(FreeSpace& space, const motion::ArmModel& arm,
                                 const std::vector<JointVector>& points) {
  space.relax();
  const std::vector<JointVector> after(points.begin() + 1, points.end());
  std::vector<double> corners(after.size() - 1, kRoundest);
  std::vector<bool> done(corners.size(), false);
  for (;;) {
    auto leg = motion::polyline_leg(arm, points.front(), after, corners);
    if (!leg) return leg;
    bool all = true;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      // A corner is where it is whatever its neighbours take.
      if (done[i]) continue;
      done[i] = is_free(space, std::get<motion::JointCurve>(leg->pieces[2 * i + 1].geometry));
      if (done[i]) continue;
      all = false;
      corners[i] *= 0.5;
      if (corners[i] < kSharpest)
        return failure(Code::kPlanningFailed, "", "a corner of the path found cannot be rounded without a collision",
                       "Increase 'clearance_m', or choose another 'seed'");
    }
    if (all) return leg;
  }
}

}  // namespace takt::planning
