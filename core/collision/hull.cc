#include "core/collision/hull.h"

#include <array>
#include <cstdio>
#include <map>
#include <memory>
#include <utility>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace takt::collision {
namespace {

/// Qhull's state, and a stream for its messages: they are not ours to print.
class HullState {
 public:
  HullState() : messages_(std::fopen("/dev/null", "w"), &std::fclose) { qh_zero(&state_, messages_.get()); }
  ~HullState() {
    qh_freeqhull(&state_, !qh_ALL);
    int count = 0, size = 0;
    qh_memfreeshort(&state_, &count, &size);
  }
  HullState(const HullState&) = delete;
  HullState& operator=(const HullState&) = delete;

  /// @return false: there is no hull
  bool run(std::vector<double>& coordinates) {
    std::array<char, 12> command{"qhull Qt"};
    const int count = static_cast<int>(coordinates.size() / 3);
    FILE* const none = messages_.get();
    return qh_new_qhull(&state_, 3, count, coordinates.data(), False, command.data(), none, none) == 0;
  }
  qhT* get() { return &state_; }

 private:
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> messages_;
  qhT state_;
};

/// A triangle with its corners in the order that makes its normal point outwards.
std::array<int, 3> oriented(qhT* qh, const facetT* facet, std::span<const Eigen::Vector3d> points) {
  std::array<int, 3> corners{};
  std::size_t count = 0;
  vertexT *vertex = nullptr, **vertexp = nullptr;
  FOREACHvertex_(facet->vertices) {
    if (count < 3) corners[count] = qh_pointid(qh, vertex->point);
    ++count;
  }
  const auto at = [&](std::size_t i) { return points[static_cast<std::size_t>(corners[i])]; };
  const Eigen::Vector3d normal(facet->normal[0], facet->normal[1], facet->normal[2]);
  if ((at(1) - at(0)).cross(at(2) - at(0)).dot(normal) < 0.0) std::swap(corners[1], corners[2]);
  return corners;
}

}  // namespace

Result<HullMesh> convex_hull(std::span<const Eigen::Vector3d> points) {
  for (const Eigen::Vector3d& point : points) {
    if (!point.allFinite()) return failure(Code::kInvalidValue, "", "a point of the hull is not finite");
  }
  if (points.size() < 4)
    return failure(Code::kInvalidValue, "", "a hull of fewer than four points has no inside",
                   "Give the points of a solid");
  std::vector<double> coordinates;
  coordinates.reserve(3 * points.size());
  for (const Eigen::Vector3d& point : points) coordinates.insert(coordinates.end(), point.data(), point.data() + 3);
  HullState state;
  if (!state.run(coordinates))
    return failure(Code::kInvalidValue, "", "all points of the hull lie in one plane, or nearly so",
                   "Give the points of a solid");
  HullMesh hull;
  std::map<int, int> numbers;  // of points that are corners
  qhT* const qh = state.get();
  facetT* facet = nullptr;
  FORALLfacets {
    for (const int point : oriented(qh, facet, points)) {
      const auto [number, fresh] = numbers.emplace(point, static_cast<int>(hull.corners.size()));
      if (fresh) hull.corners.push_back(points[static_cast<std::size_t>(point)]);
      hull.triangles.push_back(number->second);
    }
  }
  return hull;
}

}  // namespace takt::collision
