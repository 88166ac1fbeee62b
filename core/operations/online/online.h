#pragma once

#include <optional>
#include <string>
#include <utility>

#include "core/activity/activity_model.h"
#include "core/command/actions/online_action.h"
#include "core/expression/condition_state.h"
#include "core/operations/command/operation_command.h"
#include "core/operations/table/compliance.h"
#include "core/operations/table/operation.h"

/// What hold, jog and follow have in common: they move an arm, with set points found in the cycle, until a time, a
/// condition or a cancel. Realtime: setup.
namespace takt::operations {

/// What ends them in order.
struct OnlineEnd {
  std::string arm;
  std::optional<double> seconds;  ///< s; nothing: until it is cancelled
  std::optional<expression::StateSource> until;
};

/// @param P  has the members of an OnlineEnd
template <class P>
ParameterTable<P> online_parameters() {
  ParameterTable<P> table;
  table.name("arm", NameOf::kArm, &P::arm, "Arm that moves.")
      .number("seconds", "s", &P::seconds, {.low = 0.0, .high = 3600.0}, "Ends after this time.")
      .condition("until", &P::until, "Ends when this becomes true.");
  add_common_parameters(table);
  return table;
}
template <class P>
void add_tool_limits(ParameterTable<P>& table) {
  table
      .number("linear_max_m_s", "m/s", &P::linear_max, {.low = 0.0, .high = 1.0, .low_open = true},
              "Largest speed of the tool.")
      .number("angular_max_deg_s", "deg/s", &P::angular_max, {.low = 0.0, .high = 180.0, .low_open = true},
              "Largest angular speed of the tool.");
}
/// The limits of the tool.
template <class P>
command::TrackingParameters tool_limits(const P& p) {
  return {.linear_max = p.linear_max, .angular_max = p.angular_max};
}

/// A channel by its name. Its type can only be checked where channels are known.
void check_channel(const std::string& name, net::ValueType type, const ReadContext& from, const char* key = "channel");

/// What moves an arm until it is cancelled, or until a time or a condition.
class OnlineCommand : public OperationCommand {
 public:
  [[nodiscard]] MadeCommand make(const BuildContext& context, const std::string& key) const final;
  /// Where it goes shows in the run: the rehearsal goes on from where it is.
  void rehearse(Rehearsal& rehearsal, Diagnostics& diagnostics) const final;
  /// A compliant arm.
  [[nodiscard]] IntendedContact meant_touch() const final;

 protected:
  template <class P>
  explicit OnlineCommand(const P& p) : OperationCommand(p), end_{p.arm, p.seconds, p.until} {}
  [[nodiscard]] virtual command::Action action_of(const BuildContext& context) const = 0;
  /// What ends it, or is observed, beside time and `until`. By default nothing. @param key  as in make()
  virtual void add_ends(MadeCommand&, const BuildContext&, const std::string& key) const { (void)key; }

 private:
  OnlineEnd end_;
};

}  // namespace takt::operations
