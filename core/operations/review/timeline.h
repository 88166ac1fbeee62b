#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/activity/motion_collisions.h"
#include "core/base/diagnostics.h"

/// What the branches of a program do at the same time, as it is rehearsed (docs/world.md). Realtime: setup.
namespace takt::operations {

/// Something of a branch at a time of the rehearsal: how it believes the cell to be, and the motion that begins then.
struct PlayedStep {
  double begin = 0.0;  ///< s
  int branch = 0;
  bool timed = true;  ///< `begin` is known
  collision::CellState before;
  std::optional<activity::CheckedMotion> motion = {};
  double stops = 0.0;                   ///< s after its begin: the motion goes no further, it touches
  std::string arm = {};                 ///< of the motion of a `move`, also of one that finds no path
  std::vector<std::string> moves = {};  ///< pointers of the `move`s in it
  bool may_wait = true;                 ///< it begins at rest, so it may begin later
  /// Pointers of motions of other branches that are over before it begins, or begin once it is over, whenever that is.
  std::set<std::string> never_beside = {};

  [[nodiscard]] double end() const { return begin + (motion ? motion->duration() : 0.0); }
  /// It drives one of these arms.
  [[nodiscard]] bool drives(const std::set<std::string>& arms) const;
};
using PlayedSteps = std::vector<std::shared_ptr<const PlayedStep>>;

/// A collision of a motion. @param time  s after the motion begins
[[nodiscard]] activity::FoundCollision found_in(const activity::CheckedMotion& motion,
                                                const collision::CellShapes& shapes, const collision::State& before,
                                                const collision::Hit& hit, double time);

/// Motions of one branch or of several, on one clock.
class Timeline {
 public:
  /// The cell must outlive it. @param begin  how all of it is before anything of this happens
  Timeline(const expression::Cell& cell, collision::CellState begin, PlayedSteps played);

  /// Checks all motions against each other and against what stands.
  /// @param found  gets the collisions; may be null
  void check(std::vector<activity::FoundCollision>* found, Diagnostics& diagnostics);

  [[nodiscard]] const expression::Cell& cell() const { return cell_; }
  [[nodiscard]] const PlayedSteps& played() const { return played_; }
  /// Times at which something begins, ends or changes hands, s, in their order.
  [[nodiscard]] const std::vector<double>& borders() const { return borders_; }
  /// All that is known of the cell at a time, but for where the motions are that are being carried out then.
  [[nodiscard]] collision::CellState situation_at(double time) const;
  /// All arms that carry a body, an arm's base among them.
  [[nodiscard]] std::set<std::string> arms_of(int body, const collision::CellState& situation) const;

 private:
  void find_borders();
  /// Goals on what moves meanwhile.
  void check_goals(Diagnostics& diagnostics) const;
  /// Between two borders nothing begins, ends or changes hands.
  void check_between(double from, double to, std::vector<activity::FoundCollision>* found, Diagnostics& diagnostics);
  /// One for each pair of machines or objects: what follows of a collision is no news.
  void report(const collision::Hit& hit, double from, const collision::CellState& at_begin,
              const std::vector<const PlayedStep*>& moving, std::vector<activity::FoundCollision>* found,
              Diagnostics& diagnostics);
  /// Either one branch alone brings both where they meet, or all times are known until then.
  [[nodiscard]] bool is_certain(const std::set<std::string>& of_a, const std::set<std::string>& of_b,
                                double time) const;
  /// What its branch has changed since it began is so; the latest counts.
  template <class Differs>
  [[nodiscard]] const collision::CellState& latest(double time, const Differs& differs) const;
  void put_objects(double time, collision::CellState& now) const;
  void put_fingers(double time, collision::CellState& now) const;

  const expression::Cell& cell_;
  const collision::CellShapes& shapes_;
  collision::CellState begin_;
  PlayedSteps played_;
  std::map<int, const PlayedStep*> first_of_branch_;
  std::vector<double> borders_;
  std::set<std::tuple<const PlayedStep*, std::string, std::string>> reported_;
};

}  // namespace takt::operations
