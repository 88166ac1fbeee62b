#include "core/planning/merge_paths.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/planning/path_query.h"

namespace takt::planning {
namespace {

/// Places of a path at which it may be left or joined are so far apart, and two paths that are so near to each other
/// may be changed between, s.
constexpr double kPlaceSpacing = 0.15;
constexpr double kNearPlaces = 0.6;

constexpr double kNever = std::numeric_limits<double>::infinity();

class Merging {
 public:
  Merging(FreeSpace& space, const std::vector<std::vector<JointVector>>& paths, const JointVector& speed)
      : space_(space), speed_(speed) {
    for (const auto& path : paths) add(path);
    find_changes();
  }

  std::vector<JointVector> run(std::int64_t looks) {
    for (;;) {
      const std::vector<std::size_t> shortest = shortest_way(space_.looks() < looks);
      const auto open = first_open(shortest);
      if (!open) return points_of(shortest);
      Change& change = changes_.at(*open);
      change.state = space_.is_free_line(places_[open->first].q, places_[open->second].q) ? State::kFree : State::kNot;
    }
  }

 private:
  enum class State { kOpen, kFree, kNot };
  using Pair = std::pair<std::size_t, std::size_t>;  ///< the smaller number first
  struct Change {
    double length;
    State state = State::kOpen;
  };
  struct Place {
    JointVector q;
    std::size_t path;
    bool first, last;  ///< of its path
  };

  void add(const std::vector<JointVector>& path) {
    const std::size_t number = places_.empty() ? 0 : places_.back().path + 1;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
      const int parts =
          std::max(1, static_cast<int>(std::ceil(length_of(path[i], path[i + 1], speed_) / kPlaceSpacing)));
      for (int k = 0; k < parts; ++k) {
        const double share = static_cast<double>(k) / parts;
        places_.push_back({path[i] + share * (path[i + 1] - path[i]), number, i == 0 && k == 0, false});
      }
    }
    places_.push_back({path.back(), number, false, true});
  }

  void find_changes() {
    for (std::size_t a = 0; a < places_.size(); ++a) {
      for (std::size_t b = a + 1; b < places_.size(); ++b) {
        if (places_[a].path == places_[b].path) continue;
        const double length = length_of(places_[a].q, places_[b].q, speed_);
        const bool same = places_[a].q == places_[b].q;
        if (length < kNearPlaces) changes_[{a, b}] = {length, same ? State::kFree : State::kOpen};
      }
    }
    next_.resize(places_.size());
    for (const auto& [pair, change] : changes_) {
      next_[pair.first].push_back(pair.second);
      next_[pair.second].push_back(pair.first);
    }
  }

  /// How long it is from a place to another that is next to it.
  [[nodiscard]] double step(std::size_t a, std::size_t b, bool with_open) const {
    if (places_[a].path == places_[b].path) return length_of(places_[a].q, places_[b].q, speed_);
    const Change& change = changes_.at(std::minmax(a, b));
    const bool counts = change.state == State::kFree || (with_open && change.state == State::kOpen);
    return counts ? change.length : kNever;
  }

  /// From the start to an end. @param with_open  changes that were not looked at yet count as free
  [[nodiscard]] std::vector<std::size_t> shortest_way(bool with_open) const {
    const std::size_t n = places_.size();
    std::vector<double> length(n, kNever);
    std::vector<std::size_t> before(n, n);
    std::vector<bool> done(n, false);
    length[0] = 0.0;
    for (;;) {
      std::size_t at = n;
      for (std::size_t i = 0; i < n; ++i)
        if (!done[i] && length[i] < kNever && (at == n || length[i] < length[at])) at = i;
      done[at] = true;  // the end of the first path is reached in any case
      if (places_[at].last) return way_to(at, before);
      const auto reach = [&](std::size_t to) {
        const double there = length[at] + step(at, to, with_open);
        if (there < length[to]) length[to] = there, before[to] = at;
      };
      reach(at + 1);
      if (!places_[at].first) reach(at - 1);
      for (const std::size_t to : next_[at]) reach(to);
    }
  }
  [[nodiscard]] static std::vector<std::size_t> way_to(std::size_t end, const std::vector<std::size_t>& before) {
    std::vector<std::size_t> way;
    for (std::size_t at = end; at < before.size(); at = before[at]) way.push_back(at);
    std::ranges::reverse(way);
    return way;
  }

  [[nodiscard]] std::optional<Pair> first_open(const std::vector<std::size_t>& way) const {
    for (std::size_t i = 0; i + 1 < way.size(); ++i) {
      const auto change = changes_.find(std::minmax(way[i], way[i + 1]));
      if (change != changes_.end() && change->second.state == State::kOpen) return change->first;
    }
    return std::nullopt;
  }
  /// Without places in the middle of a line.
  [[nodiscard]] std::vector<JointVector> points_of(const std::vector<std::size_t>& way) const {
    std::vector<JointVector> points;
    for (const std::size_t at : way)
      if (points.empty() || points.back() != places_[at].q) points.push_back(places_[at].q);
    return points;
  }

  FreeSpace& space_;
  const JointVector& speed_;
  std::vector<Place> places_;
  std::map<Pair, Change> changes_;
  std::vector<std::vector<std::size_t>> next_;
};

}  // namespace

std::vector<JointVector> merge_paths(FreeSpace& space, const std::vector<std::vector<JointVector>>& paths,
                                     const JointVector& speed, std::int64_t looks) {
  return Merging(space, paths, speed).run(looks);
}

}  // namespace takt::planning
