#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/activity/activity_model.h"
#include "core/rcc/control_core.h"

namespace takt::activity {

/// Brings arms into control modes while no net holds them, all at the same time (ControlCore::change_mode). Thread: the
/// one that steps the core, between cycles. Realtime: setup.
class ModeChange {
 public:
  /// Asks the core. An arm that is in its mode already is not asked.
  ModeChange(rcc::ControlCore& core, const ControlModes& modes);

  /// Looks for answers among what the core has said since the last call. @return whether all have answered
  bool poll(std::span<const rcc::Event> events);
  /// Why arms did not come into their modes.
  [[nodiscard]] const Diagnostics& diagnostics() const { return diagnostics_; }
  /// The modes in which the arms were when it was asked for.
  [[nodiscard]] const ControlModes& before() const { return before_; }

 private:
  struct Open {
    rcc::RequestId request;
    const device::Arm* arm;
  };
  ControlModes before_;
  std::vector<Open> open_;
  Diagnostics diagnostics_;
};

/// Brings an arm into a control mode, and does nothing else: without a net.
[[nodiscard]] ActivityPtr mode_activity(const std::string& arm, device::ControlMode mode);

/// Whether an arm can be brought from one mode into another; a diagnostic with what is allowed if not.
[[nodiscard]] Diagnostics check_mode_change(const device::Arm& arm, device::ControlMode from, device::ControlMode to);

/// Whether an arm that is in mode `is` (nothing: not known) can start in mode `needed`; a diagnostic with what to do if
/// not.
[[nodiscard]] Diagnostics check_needed_mode(const device::Arm& arm, std::optional<device::ControlMode> is,
                                            device::ControlMode needed);

/// Looks at what the commands of an activity want of the control modes of their arms: whether START can give it, and in
/// which mode each arm is after it, if the activity does not say so.
/// @return for each arm that is in another mode then what to do
[[nodiscard]] Diagnostics agree_on_modes(PlannedActivity& prepared, const PlanningContext& planning);

}  // namespace takt::activity
