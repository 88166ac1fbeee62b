#pragma once

#include "cell/judge/expectation_kind.h"

/// The kinds of expectations that takt itself brings; expectations.cc lists them. Realtime: setup.
namespace takt::cell {

[[nodiscard]] ExpectationKind belief_expectation();
[[nodiscard]] ExpectationKind contact_force_expectation();
[[nodiscard]] ExpectationKind contacts_expectation();
[[nodiscard]] ExpectationKind duration_expectation();
[[nodiscard]] ExpectationKind estimate_expectation();
[[nodiscard]] ExpectationKind event_expectation();
[[nodiscard]] ExpectationKind gripper_expectation();
[[nodiscard]] ExpectationKind limits_expectation();
[[nodiscard]] ExpectationKind mean_force_expectation();
[[nodiscard]] ExpectationKind monitor_expectation();
[[nodiscard]] ExpectationKind object_pose_expectation();
[[nodiscard]] ExpectationKind order_expectation();
[[nodiscard]] ExpectationKind peak_force_expectation();
[[nodiscard]] ExpectationKind relative_pose_expectation();
[[nodiscard]] ExpectationKind repeats_expectation();
[[nodiscard]] ExpectationKind screw_expectation();
[[nodiscard]] ExpectationKind seam_expectation();
[[nodiscard]] ExpectationKind signal_expectation();
[[nodiscard]] ExpectationKind step_expectation();
[[nodiscard]] ExpectationKind tool_pose_expectation();
[[nodiscard]] ExpectationKind value_expectation();

}  // namespace takt::cell
