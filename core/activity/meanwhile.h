#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "core/collision/swept_space.h"
#include "core/kinematics/types.h"

namespace takt::activity {

/// What the rehearsal found of the other branches of a `parallel`, for a `move` in one of them.
struct MeanwhileSpace {
  collision::SweptSpace swept = {};  ///< while it is carried out
  double wait = 0.0;                 ///< s: it begins so much later, for before that no path keeps clear of it
  /// Joints (rad or m) of machines that carry its arm and drive meanwhile: what is swept is as if they stood there, and
  /// all else moved about them.
  std::map<std::string, kinematics::JointVector, std::less<>> carriers = {};
};

/// The same of all (docs/planning.md), by the pointers of the outermost `parallel` and of the `move`.
using MeanwhileSpaces = std::map<std::pair<std::string, std::string>, std::shared_ptr<const MeanwhileSpace>>;

/// The same, seen from within a program. Any thread.
struct ConcurrentMotions {
  std::shared_ptr<const MeanwhileSpaces> spaces = {};
  std::string parallel = {};  ///< pointer of the outermost one that is being played or run; empty: none

  /// What was found for the `move` with this pointer; null: nothing.
  [[nodiscard]] std::shared_ptr<const MeanwhileSpace> of(const std::string& move) const {
    if (spaces == nullptr || parallel.empty()) return nullptr;
    const auto found = spaces->find({parallel, move});
    return found == spaces->end() ? nullptr : found->second;
  }
  /// What is swept beside it; null: nothing.
  [[nodiscard]] std::shared_ptr<const collision::SweptSpace> beside(const std::string& move) const {
    const auto found = of(move);
    return found == nullptr ? nullptr : std::shared_ptr<const collision::SweptSpace>(found, &found->swept);
  }
  /// How long it waits before it begins, s.
  [[nodiscard]] double wait_before(const std::string& move) const {
    const auto found = of(move);
    return found == nullptr ? 0.0 : found->wait;
  }
};

}  // namespace takt::activity
