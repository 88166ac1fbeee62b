#include "core/planning/path_query.h"

namespace takt::planning {

double length_of(const JointVector& from, const JointVector& to, const JointVector& speed) {
  return (to - from).cwiseQuotient(speed).norm();
}

double length_of(const std::vector<JointVector>& points, const JointVector& speed) {
  double length = 0.0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) length += length_of(points[i], points[i + 1], speed);
  return length;
}

}  // namespace takt::planning
