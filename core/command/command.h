#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/command/action.h"
#include "core/command/actuator.h"
#include "core/expression/state.h"

namespace takt::command {

class Command;

/// One occurrence of an external effect.
struct ExternalEvent {
  std::string name;
  std::int64_t count = 0;                  ///< of this effect, this occurrence included
  std::optional<std::int64_t> cycle = {};  ///< of the core; nothing: the queue had no room, only the count is known
};
using ExternalHandler = std::function<void(const ExternalEvent&)>;

/// A state of a transaction that an event makes hold, from that cycle on until the transaction ends.
class RaisedState {
 public:
  explicit RaisedState(std::string name);
  [[nodiscard]] expression::State state() const;
  [[nodiscard]] const expression::SubjectPtr& subject() const { return subject_; }

 private:
  expression::SubjectPtr subject_;
};

/// What happens when an event does.
struct Effect {
  enum class Kind : std::uint8_t { kStart, kStop, kCancel, kRaise, kExternal };
  Kind kind = Kind::kCancel;
  expression::SubjectPtr target = {};  ///< a command or a raised state
  std::string name = {};               ///< of the external effect
  ExternalHandler external = {};  ///< called between cycles by who runs the command, not in the cycle; may be empty
};
[[nodiscard]] Effect start(const Command& command);
[[nodiscard]] Effect stop(const Command& command);
[[nodiscard]] Effect cancel(const Command& command);
[[nodiscard]] Effect raise(const RaisedState& state);
[[nodiscard]] Effect external(std::string name, ExternalHandler handler = {});

/// When an event counts.
struct Trigger {
  bool first_only = false;  ///< of an external effect; everything else happens once at most anyway
  double delay = 0.0;       ///< from the event to the effect, s
};

/// "When the state is entered (or left) while the command is active, then ...". A state that holds already when the
/// command becomes active counts as entered in that cycle. Null counts as entered, and as left, where the effect is
/// stop or cancel (row N3): a dead sensor does not switch a guard off; elsewhere it is no event.
struct EventHandler {
  expression::State state;
  bool entered = true;
  Effect effect;
  Trigger trigger;
};

/// What CANCEL does to a transaction (rule C4).
struct CancelPolicy {
  enum class Kind : std::uint8_t {
    /// To all that run. Nothing starts any more but what handlers on the transaction's `cancelled` start, and what that
    /// leads to: clean-up, which the cancel does not concern.
    kForward,
    kForwardTo,  ///< to these; the others go on, and may start
    kIgnore      ///< nothing happens but what handlers on the transaction's `cancelled` do
  };
  Kind kind = Kind::kForward;
  std::vector<expression::SubjectPtr> targets;
};

/// A value that people or the program want to see: as it is, or as it was when a state was first entered.
struct Observation {
  std::string name;
  expression::ExpressionPtr value;
  expression::ExpressionPtr when;  ///< a Boolean; null: always
};

/// The name under which a part of a composition observes something: "/1" and "touch" are "/1 touch", "/1" and
/// "/grip width" are "/1/grip width".
[[nodiscard]] std::string scoped_name(const std::string& part, const std::string& observation);

/// What a command is made of; for checks and the mapping. Kind by what is set: action, wait, or neither: a transaction.
struct CommandNode {
  std::string name;
  expression::SubjectPtr subject;
  std::vector<EventHandler> handlers;
  std::vector<Observation> observations;
  std::optional<expression::State> fails_if;
  std::string part;  ///< of a composition, "/1": what is observed in it has this before its name (scoped_name())
  // Runtime.
  std::optional<Actuator> actuator;
  std::optional<Action> action;
  std::shared_ptr<const ActionModel> planned;  ///< the action, once it is planned
  // Wait.
  std::optional<double> seconds;
  std::optional<expression::State> until;
  // Transaction.
  std::vector<std::shared_ptr<CommandNode>> children;
  std::vector<bool> started_with;  ///< per child: it starts in the cycle in which the transaction does
  /// Names of transactions around this one that were added to it. The check refuses them (rule C6); as children they
  /// would own one another, and nobody would free them.
  std::vector<std::string> circular;
  CancelPolicy cancel_policy;
  std::vector<RaisedState> raised;

  [[nodiscard]] bool is_runtime() const { return action.has_value(); }
  [[nodiscard]] bool is_wait() const { return seconds.has_value() || until.has_value(); }
  [[nodiscard]] bool is_transaction() const { return !is_runtime() && !is_wait(); }
  [[nodiscard]] const ActionModel& model() const { return planned ? *planned : action->model(); }
};

/// Something that is to happen in real time. A handle: copies are the same command. It runs once at most (rule C5) and
/// is in one tree, once (rule C6). Built by one thread.
class Command {
 public:
  [[nodiscard]] const std::string& name() const { return node_->name; }
  [[nodiscard]] const expression::SubjectPtr& subject() const { return node_->subject; }
  [[nodiscard]] const std::shared_ptr<CommandNode>& node() const { return node_; }

  // States. "Completed": it ended in order, by itself or after a cancel, and has not failed. "Failed": it ended in
  // order and fails_if() held; a wait whose time was over; a transaction in which something has failed. "Cancelled":
  // from the cycle of the request on. "Stopped": a stop has ended it; what moves an arm rests by then.
  [[nodiscard]] expression::State started() const { return state("started"); }
  [[nodiscard]] expression::State active() const { return state("active"); }
  [[nodiscard]] expression::State completed() const { return state("completed"); }
  [[nodiscard]] expression::State failed() const { return state("failed"); }
  [[nodiscard]] expression::State stopped() const { return state("stopped"); }
  [[nodiscard]] expression::State cancelled() const { return state("cancelled"); }
  /// It is active, and people hold the arms that it moves still: their speed is 0 (ActuatorModel::speed()), or unknown.
  /// From the cycle on in which they want that: the arms brake then. Of a transaction: one of the commands that it has
  /// when this is called.
  [[nodiscard]] expression::State paused() const;

  // Event handlers.
  Command& on_entered(expression::State state, Effect effect, Trigger trigger = {});
  Command& on_left(expression::State state, Effect effect, Trigger trigger = {});

  /// What makes it fail: the state holds, or is null (row N3), in the last cycle of the command. Several: any of them.
  Command& fails_if(const expression::State& state);

  /// Shows a value outside of the net under a name (activity::ActivityRun::value).
  template <class T>
  Command& observe(std::string name, const expression::Sensor<T>& sensor) {
    return observe_node(std::move(name), sensor.node(), nullptr);
  }
  Command& observe(std::string name, const expression::State& state) {
    return observe_node(std::move(name), state.node(), nullptr);
  }
  /// The value of the cycle in which the state was first entered, kept from then on. Null of the state is no event.
  template <class T>
  Command& capture(std::string name, const expression::Sensor<T>& sensor, const expression::State& state) {
    return observe_node(std::move(name), sensor.node(), state.node());
  }
  Command& capture(std::string name, const expression::State& value, const expression::State& state) {
    return observe_node(std::move(name), value.node(), state.node());
  }

 protected:
  explicit Command(std::string name);
  [[nodiscard]] expression::State state(const char* which) const {
    return expression::State(expression::leaf(net::ValueType::kBoolean, node_->subject, which));
  }

 private:
  Command& observe_node(std::string name, expression::ExpressionPtr value, expression::ExpressionPtr when);

  std::shared_ptr<CommandNode> node_;
};

/// An action on an actuator.
class RuntimeCommand : public Command {
 public:
  RuntimeCommand(std::string name, Actuator actuator, Action action);
  [[nodiscard]] const Actuator& actuator() const { return *node()->actuator; }
  [[nodiscard]] const Action& action() const { return *node()->action; }
};

/// Lets time pass, or waits for a state.
class WaitCommand : public Command {
 public:
  /// @param seconds  >= 0, in whole cycles, rounded up
  WaitCommand(std::string name, double seconds);
  /// @param timeout  s; if the state has not held by then, the wait ends without being completed: timed_out()
  WaitCommand(std::string name, expression::State until, std::optional<double> timeout = {});
  /// Its time was over and the state had not held, or was unknown. Only of a wait with a timeout.
  [[nodiscard]] expression::State timed_out() const { return state("timed_out"); }
};

/// Commands in one real-time context. It has ended when all that were started have ended and nothing in it can be
/// started any more: a start that waits for a sensor keeps it alive (row L9).
class TransactionCommand : public Command {
 public:
  explicit TransactionCommand(std::string name) : Command(std::move(name)) {}

  /// Adds a command that an event starts.
  TransactionCommand& add(const Command& command);
  /// Adds a command that starts in the cycle in which this does.
  TransactionCommand& add_started(const Command& command);
  /// A state that handlers in here may raise.
  RaisedState raised(std::string name);

  TransactionCommand& on_cancel_forward();
  TransactionCommand& on_cancel_forward_to(const std::vector<Command>& commands);
  TransactionCommand& on_cancel_ignore();

 private:
  TransactionCommand& add_child(const Command& command, bool started);
};

}  // namespace takt::command
