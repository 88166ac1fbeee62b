#pragma once

#include <optional>
#include <string>

#include "core/activity/activity_model.h"
#include "core/command/actions/freedrive_action.h"

namespace takt::activity {

/// When a person no longer guides an arm.
struct FreedriveEnd {
  std::optional<command::State> until = {};  ///< it holds, or nobody knows (row N3)
  std::optional<double> seconds = {};        ///< so long after the begin
};

/// The command of a freedrive. While the motions of the arm are paused, by the program or by the operator, it stands.
[[nodiscard]] command::RuntimeCommand freedrive_command(const command::Cell& cell, const std::string& arm,
                                                        const command::GuidanceParameters& guidance,
                                                        const FreedriveEnd& end, const command::Biases& biases);

/// The control modes into which an arm has to be brought before, and from which it goes back after it; empty: none.
[[nodiscard]] ControlModes freedrive_modes(const command::Cell& cell, const std::string& arm);

/// A person guides an arm by hand, from the control mode that it is in back into that. Nobody knows where it is then.
/// Realtime: setup.
[[nodiscard]] ActivityPtr freedrive_activity(const command::Cell& cell, const std::string& arm,
                                             const command::GuidanceParameters& guidance, const FreedriveEnd& end,
                                             const command::Biases& biases);

}  // namespace takt::activity
