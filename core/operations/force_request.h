#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/command/actions/press_action.h"
#include "core/expression/condition.h"
#include "core/operations/compliance_request.h"
#include "core/operations/parameter_table.h"
#include "core/operations/search_pattern.h"

namespace takt::activity {

/// What a step "press" or "search" says, in numbers. Keys: docs/scenarios.md.
struct ForceRequest : OperationHead {
  /// What is followed across the direction.
  struct Pattern {
    SearchPattern kind = SearchPattern::kSpiral;
    double radius = 0.01, pitch = 0.001, velocity = 0.01;  ///< m, m, m/s
  };

  std::string arm, sensor;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  std::string in = "tcp";                                ///< whose axes the direction is along
  double force = 10.0, approach = 0.002, travel = 0.05;  ///< N, m/s, m
  std::optional<double> hold, drop;                      ///< s, m
  std::optional<command::Condition> until;
  std::optional<Pattern> pattern;
  bool must_find = true;  ///< a pattern that ends without anything found is a failure
  std::optional<ComplianceRequest> compliance;

  /// What it does depends on where the arm is: along the tool's own axes, a pattern from there, springs of the joints.
  [[nodiscard]] bool needs_place() const;
};

[[nodiscard]] const ParameterTable<ForceRequest>& press_parameters();
[[nodiscard]] const ParameterTable<ForceRequest>& search_parameters();

/// The keys of "press"; without `seconds` and `until` it presses for `hold` s, or, without that, until it is cancelled.
[[nodiscard]] ForceRequest read_press(ObjectReader& reader, const command::Cell& cell, std::optional<double> hold);
[[nodiscard]] ForceRequest read_search(ObjectReader& reader, const command::Cell& cell);

/// How it presses.
struct PreparedPress {
  Eigen::Vector3d direction_B;  ///< of the force that the tool exerts, in the arm's base; of length 1
  command::PressWish wish;
};
/// What it comes to with the arm at q (rad or m). Without a compliance of its own the springs are those that the arm
/// has now. @return diagnostics: an unknown frame, a pattern that the arm cannot follow, springs that take up the
/// travel. Realtime: setup.
[[nodiscard]] Result<PreparedPress> prepare_press(const ForceRequest& request, const command::Cell& cell,
                                                  const kinematics::JointVector& q);

}  // namespace takt::activity
