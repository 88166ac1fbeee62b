#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "core/collision/swept_space.h"

namespace takt::activity {

/// What the other branches of a `parallel` sweep while a `move` in one of them is carried out, as the rehearsal found
/// it (docs/planning.md). By the pointers of the outermost `parallel` and of the `move`.
using MeanwhileSpaces = std::map<std::pair<std::string, std::string>, std::shared_ptr<const collision::SweptSpace>>;

/// The same, seen from within a program. Any thread.
struct Meanwhile {
  std::shared_ptr<const MeanwhileSpaces> spaces = {};
  std::string parallel = {};  ///< pointer of the outermost one that is being played or run; empty: none

  /// What is swept beside the `move` with this pointer; null: nothing.
  [[nodiscard]] std::shared_ptr<const collision::SweptSpace> beside(const std::string& move) const {
    if (spaces == nullptr || parallel.empty()) return nullptr;
    const auto found = spaces->find({parallel, move});
    return found == spaces->end() ? nullptr : found->second;
  }
};

}  // namespace takt::activity
