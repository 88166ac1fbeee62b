#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/object_reader.h"
#include "core/command/compliance_action.h"

namespace takt::activity {

/// How an arm gives way while a step does something else: key "compliance" (docs/scenarios.md).
struct ComplianceRequest {
  device::ControlMode mode = device::ControlMode::kPosition;
  /// As they stand in the file, by key: one number for all joints or axes, or one for each.
  std::map<std::string, std::vector<double>, std::less<>> values;
  bool in_tool_axes = false;

  [[nodiscard]] bool operator==(const ComplianceRequest&) const = default;
};

/// The key "compliance" of a step; nothing: the step has none. Findings: all that is wrong with its form. Realtime:
/// setup.
[[nodiscard]] std::optional<ComplianceRequest> read_compliance(ObjectReader& step);

/// @param joint_count  of the arm
[[nodiscard]] command::ComplianceWish wish_of(const ComplianceRequest& request, int joint_count);

/// What the arm's device does not allow, at its key below the step. Nothing of an arm of which only the name is known.
[[nodiscard]] Findings check_compliance(const ComplianceRequest& request, const command::Cell& cell,
                                        const std::string& arm);

/// Where below the step stands what the command layer finds at a place below a command: theirs, ours.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> places_of(const ComplianceRequest& request);

}  // namespace takt::activity
