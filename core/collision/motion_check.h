#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/collision/scene.h"
#include "core/collision/trajectory.h"

namespace takt::collision {

/// What two bodies may do during a motion.
struct PairRule {
  enum class Kind {
    kApart,    ///< keep the margin
    kTouch,    ///< may touch, and overlap by `overlap`: a held part that is set down
    kLeave,    ///< as kApart, once they have parted; if they do not, the motion must not end deeper than it began
    kIgnored,  ///< not looked at
  };
  Kind kind = Kind::kApart;
  double overlap = 0.0;   ///< m; kTouch
  bool may_part = false;  ///< kLeave where they are in contact, or overlap too far, when the motion begins
};

/// Two bodies that come too near.
struct Hit {
  int a = -1, b = -1;
  double time = 0.0;      ///< s, when they first are too near
  double distance = 0.0;  ///< m: the least signed distance from then on until they part again; negative: overlap
  std::vector<double> q;  ///< of all joints at `time`
};

struct CheckOptions {
  double margin = 1e-3;                             ///< m, > 0: nearer than this is a hit
  std::function<PairRule(int a, int b)> rule = {};  ///< of pairs that can meet; empty: kApart for all
  std::vector<bool> bodies = {};                    ///< only pairs with one of these; empty: any that the motion moves
};

/// Checks a motion against all bodies of the scene, without gaps between samples: from one look at a pair to the next
/// no point of them travels further than they were apart (docs/world.md, "Without gaps"). What is reported is nearer
/// than the margin at some time; what is not reported never touches. Bodies that the motion moves as one are not
/// looked at.
/// @return the hits, one at most for each pair, in the order of their times. Realtime: setup, deterministic.
[[nodiscard]] std::vector<Hit> check_motion(const Scene& scene, const State& state, const Trajectory& motion,
                                            const CheckOptions& options);

/// Checks a state at rest. @param moved  pairs with one of these only. `time` of the hits is 0.
[[nodiscard]] std::vector<Hit> check_state(const Scene& scene, const State& state, const std::vector<bool>& moved,
                                           const CheckOptions& options);

}  // namespace takt::collision
