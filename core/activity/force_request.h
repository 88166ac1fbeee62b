#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/activity/search_pattern.h"
#include "core/base/object_reader.h"
#include "core/command/condition.h"
#include "core/command/force_net.h"
#include "core/motion/leg.h"

namespace takt::activity {

/// What a step "press" or "search" says, in numbers. Keys: docs/scenarios.md.
struct ForceRequest {
  /// What is followed across the direction.
  struct Pattern {
    SearchPattern kind = SearchPattern::kSpiral;
    double radius = 0.01, pitch = 0.001, velocity = 0.01;  ///< m, m, m/s
  };

  std::string name, pointer, arm, sensor;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  std::string in;                                        ///< whose axes the direction is along
  double force = 10.0, approach = 0.002, travel = 0.05;  ///< N, m/s, m
  std::optional<double> hold, drop;                      ///< s, m
  std::optional<command::Condition> until;
  std::optional<Pattern> pattern;
  bool must_find = true;  ///< a pattern that ends without anything found is a failure

  /// The way of the tool depends on where the arm is: its own axes, or a pattern from there.
  [[nodiscard]] bool needs_place() const { return pattern || in == "tcp"; }
};

/// The keys of "press"; without `seconds` and `until` it presses for `hold` s, or, without that, until it is cancelled.
[[nodiscard]] ForceRequest read_press(ObjectReader& reader, const command::Cell& cell, std::optional<double> hold);
[[nodiscard]] ForceRequest read_search(ObjectReader& reader, const command::Cell& cell);

/// A command, and the plan that it refers to.
struct PreparedPress {
  command::PressCommand command;
  std::shared_ptr<const motion::Motion> path;  ///< null: none
};
/// What it comes to with the arm at q (rad or m). @return findings without a place: an unknown frame, a pattern that
/// the arm cannot follow. Realtime: setup.
[[nodiscard]] Result<PreparedPress> prepare_press(const ForceRequest& request, const command::Cell& cell,
                                                  const kinematics::JointVector& q);

}  // namespace takt::activity
