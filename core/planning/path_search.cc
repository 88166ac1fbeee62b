#include "core/planning/path_search.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "core/planning/merge_paths.h"
#include "core/planning/shorten.h"
#include "core/planning/tree_search.h"

namespace takt::planning {
namespace {

/// A path so near to the straight line is not improved any more.
constexpr double kGoodEnough = 1.1;
/// Trees after the first that found a path, and how many looks they may take together: a share of what was needed so
/// far, and at least so many.
constexpr int kMoreTrees = 6;
constexpr double kShareMore = 0.3;
constexpr std::int64_t kLeastMore = 2'000;
/// Looks to make each path shorter, to join the best of all paths, and to make that shorter.
constexpr std::int64_t kShorten = 600;
constexpr std::int64_t kMerge = 1'000;
constexpr std::int64_t kPolish = 1'500;

class Search {
 public:
  Search(FreeSpace& space, const Query& query) : space_(space), query_(query), begin_(space.looks()) {
    nearest_ = std::numeric_limits<double>::infinity();
    for (const JointVector& goal : query.goals)
      nearest_ = std::min(nearest_, length_of(query.start, goal, query.speed));
  }

  std::optional<FoundPath> run() {
    try_straight_lines();
    std::int64_t until = begin_ + query_.looks;
    bool first = true;
    for (int tree = 0; tree <= kMoreTrees && !is_good() && space_.looks() < until; ++tree) {
      grow(tree, until);
      if (best_ && std::exchange(first, false)) until = space_.looks() + more();
    }
    if (best_ && !is_good()) merge();
    if (best_ && !is_good()) polish();
    return std::move(best_);
  }

 private:
  [[nodiscard]] bool is_good() const { return best_ && best_->length <= kGoodEnough * nearest_; }

  [[nodiscard]] std::int64_t more() const {
    const auto share = static_cast<std::int64_t>(kShareMore * static_cast<double>(space_.looks() - begin_));
    return std::max(kLeastMore, share);
  }

  void merge() {
    if (paths_.size() < 2) return;
    keep(merge_paths(space_, paths_, query_.speed, space_.looks() + kMerge));
  }

  void polish() {
    Random random(query_.seed, "polish");
    shorten(space_, best_->points, query_.speed, random, space_.looks() + kPolish);
    best_->length = length_of(best_->points, query_.speed);
  }

  void try_straight_lines() {
    for (const JointVector& goal : query_.goals) {
      if (best_ && length_of(query_.start, goal, query_.speed) >= best_->length) continue;
      if (space_.is_free_line(query_.start, goal)) keep({query_.start, goal});
    }
  }

  /// Each tree has random numbers of its own, so that none depends on how long the one before took.
  void grow(int tree, std::int64_t until) {
    Random random(query_.seed, fmt::format("tree {}", tree));
    const double shorter_than = best_ ? best_->length : std::numeric_limits<double>::infinity();
    auto points = connect(space_, query_, shorter_than, random, until);
    if (!points) return;
    points->front() = query_.start;
    points->back() = query_.goals[nearest_goal(points->back())];
    shorten(space_, *points, query_.speed, random, std::min(until, space_.looks() + kShorten));
    paths_.push_back(*points);
    keep(std::move(*points));
  }

  /// OMPL computes with times: its ends are ours up to rounding.
  [[nodiscard]] std::size_t nearest_goal(const JointVector& q) const {
    const auto away = [&](const JointVector& goal) { return (goal - q).norm(); };
    return static_cast<std::size_t>(std::ranges::min_element(query_.goals, {}, away) - query_.goals.begin());
  }

  void keep(std::vector<JointVector> points) {
    const double length = length_of(points, query_.speed);
    if (best_ && best_->length <= length) return;
    const std::size_t goal = nearest_goal(points.back());
    best_ = FoundPath{std::move(points), goal, length};
  }

  FreeSpace& space_;
  const Query& query_;
  std::int64_t begin_;
  double nearest_;
  std::vector<std::vector<JointVector>> paths_;  ///< one of each tree
  std::optional<FoundPath> best_;
};

}  // namespace

std::optional<FoundPath> find_path(FreeSpace& space, const Query& query) { return Search(space, query).run(); }

}  // namespace takt::planning
