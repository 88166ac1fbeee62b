#include "core/planning/shorten.h"

#include <algorithm>
#include <utility>

#include "core/planning/path_query.h"

namespace takt::planning {
namespace {

/// Tries in a row without success after which a path is as short as it gets.
constexpr int kTries = 30;
/// What counts as success, and what a cut has to gain, as shares of the length.
constexpr double kSuccess = 0.01;
constexpr double kGain = 1e-3;

class Shortening {
 public:
  Shortening(FreeSpace& space, std::vector<JointVector>& points, const JointVector& speed, Random& random)
      : space_(space), points_(points), speed_(speed), random_(random) {}

  void run(std::int64_t looks) {
    for (int failed = 0; failed < kTries && points_.size() > 2 && space_.looks() < looks; ++failed) {
      const double before = length_of(points_, speed_);
      if (cut() && length_of(points_, speed_) < (1.0 - kSuccess) * before) failed = -1;
    }
    leave_out();
  }

 private:
  /// A place on the path: a share of one of its lines.
  struct Place {
    std::size_t line;
    JointVector q;
  };

  /// From each point on to the furthest that can be reached straight.
  void leave_out() {
    for (std::size_t from = 0; from + 2 < points_.size(); ++from) {
      for (std::size_t to = points_.size() - 1; to > from + 1; --to) {
        if (!space_.is_free_line(points_[from], points_[to])) continue;
        points_.erase(points_.begin() + static_cast<std::ptrdiff_t>(from) + 1,
                      points_.begin() + static_cast<std::ptrdiff_t>(to));
        break;
      }
    }
  }

  [[nodiscard]] Place place_at(double way) const {
    std::size_t line = 0;
    double length = length_of(points_[0], points_[1], speed_);
    while (line + 2 < points_.size() && way > length) {
      way -= length;
      ++line;
      length = length_of(points_[line], points_[line + 1], speed_);
    }
    const double share = length > 0.0 ? std::min(way / length, 1.0) : 0.0;
    return {line, points_[line] + share * (points_[line + 1] - points_[line])};
  }

  /// @return true: the path is shorter by something
  bool cut() {
    const double whole = length_of(points_, speed_);
    double first = random_.uniform(0.0, whole), second = random_.uniform(0.0, whole);
    if (first > second) std::swap(first, second);
    // All joints every second time, one of them else.
    const auto choice = static_cast<Eigen::Index>(random_.uniform(0.0, 2.0 * static_cast<double>(speed_.size())));
    const Place begin = place_at(first), end = place_at(second);
    if (begin.line == end.line) return false;
    std::vector<JointVector> middle{begin.q};
    if (choice < speed_.size()) add_with_straight_joint(begin, end, choice, middle);
    middle.push_back(end.q);
    return replace(begin, end, middle, whole);
  }

  /// The points between, with one joint on its straight line.
  void add_with_straight_joint(const Place& begin, const Place& end, Eigen::Index joint,
                               std::vector<JointVector>& middle) const {
    double whole = length_of(points_[end.line], end.q, speed_), way = 0.0;
    whole += length_of(begin.q, points_[begin.line + 1], speed_);
    for (std::size_t i = begin.line + 1; i < end.line; ++i) whole += length_of(points_[i], points_[i + 1], speed_);
    const JointVector* before = &begin.q;
    for (std::size_t i = begin.line + 1; i <= end.line; ++i) {
      way += length_of(*before, points_[i], speed_);
      before = &points_[i];
      middle.push_back(points_[i]);
      middle.back()[joint] = begin.q[joint] + way / whole * (end.q[joint] - begin.q[joint]);
    }
  }

  bool replace(const Place& begin, const Place& end, const std::vector<JointVector>& middle, double before) {
    std::vector<JointVector> shorter(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(begin.line) + 1);
    shorter.insert(shorter.end(), middle.begin(), middle.end());
    shorter.insert(shorter.end(), points_.begin() + static_cast<std::ptrdiff_t>(end.line) + 1, points_.end());
    if (length_of(shorter, speed_) > (1.0 - kGain) * before) return false;
    for (std::size_t i = 0; i + 1 < middle.size(); ++i)
      if (!space_.is_free_line(middle[i], middle[i + 1])) return false;
    shorter.erase(std::unique(shorter.begin(), shorter.end()), shorter.end());
    points_ = std::move(shorter);
    return true;
  }

  FreeSpace& space_;
  std::vector<JointVector>& points_;
  const JointVector& speed_;
  Random& random_;
};

}  // namespace

void shorten(FreeSpace& space, std::vector<JointVector>& points, const JointVector& speed, Random& random,
             std::int64_t looks) {
  Shortening(space, points, speed, random).run(looks);
}

}  // namespace takt::planning
