// The layer below: commands with event handlers, and transactions of them (docs/command-layer.md).
#include <optional>
#include <string>

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>

#include "core/command/actions/device_action.h"
#include "core/command/actions/motion_action.h"
#include "core/command/actions/online_action.h"
#include "core/command/command.h"
#include "python/activities.h"
#include "python/bindings.h"
#include "python/errors.h"

namespace takt::python {
namespace {

namespace nb = nanobind;
using Command = Owned<command::Command>;
using Transaction = Owned<std::shared_ptr<command::TransactionCommand>>;
using Action = Owned<command::Action>;
using Raised = Owned<command::RaisedState>;
using Matrix = Eigen::Matrix4d;
using Device = std::string;
using C = const CellPtr&;

/// The actuator of an arm or an output.
command::Actuator actuator_of(app::Cell& cell, const std::string& name) {
  if (cell.model().arms.contains(name)) return command::arm(cell.model(), name);
  if (cell.model().grippers.contains(name)) return command::gripper(cell.model(), name);
  return command::output(cell.model(), cell.output(name).name());
}

Command runtime_command(C cell, const std::string& name, const Device& device, const Action& action) {
  return {cell, command::RuntimeCommand(name, actuator_of(cell->get(), device), action.value)};
}
Command wait_command(C cell, const std::string& name, const std::variant<double, State>& what,
                     std::optional<double> timeout) {
  (void)cell->get();
  if (const auto* seconds = std::get_if<double>(&what)) return {cell, command::WaitCommand(name, *seconds)};
  return {cell, command::WaitCommand(name, std::get<State>(what).value, timeout)};
}

// -- Actions ---------------------------------------------------------------------------------------------------------

command::PlanParameters plan_parameters(double speed, double acceleration, std::optional<double> velocity) {
  return {.velocity = speed, .acceleration = acceleration, .linear_velocity = velocity};
}

void bind_actions(nb::module_& module) {
  nb::class_<Action>(module, "Action", "What a command lets a device do.");
  module.def("action_ptp", [](C c, const Eigen::VectorXd& q, double speed, double acceleration) {
    return Action{c, command::ptp(kinematics::JointVector(q), plan_parameters(speed, acceleration, {}))};
  });
  module.def("action_lin", [](C c, const Matrix& X, double speed, double acceleration, std::optional<double> velocity) {
    return Action{c, command::lin(pose_from(X, "to"), plan_parameters(speed, acceleration, velocity))};
  });
  module.def("action_hold_force", [](C c, const Real& pressing, const Triple& direction, double force, double gain) {
    return Action{c, command::hold_force(pressing.value, Eigen::Isometry3d::Identity(), vector_from(direction),
                                         {.force = force, .gain = gain})};
  });
  module.def("action_set", [](C c, bool value) { return Action{c, command::set_value(value)}; });
  module.def("action_set", [](C c, double value) { return Action{c, command::set_value(value)}; });
  module.def("action_hold", [](C c) { return Action{c, command::hold()}; });
}

// -- Commands --------------------------------------------------------------------------------------------------------

void bind_effects(nb::module_& module) {
  nb::class_<command::Effect>(module, "Effect", "What an event does.");
  module.def("effect_start", [](const Command& one) { return command::start(one.value); });
  module.def("effect_stop", [](const Command& one) { return command::stop(one.value); });
  module.def("effect_cancel", [](const Command& one) { return command::cancel(one.value); });
  module.def("effect_raise", [](const Raised& one) { return command::raise(one.value); });
  nb::class_<Raised>(module, "RaisedState").def_prop_ro("state", [](const Raised& one) {
    return State{one.cell, one.value.state()};
  });
}

void bind_command_states(nb::class_<Command>& made) {
  const auto add = [&made](const char* name, expression::State (command::Command::*state)() const, const char* doc) {
    made.def_prop_ro(
        name,
        [state](const Command& one) {
          return State{one.cell, (one.value.*state)()};
        },
        doc);
  };
  add("started", &command::Command::started, "A state: it has begun.");
  add("active", &command::Command::active, "A state: it runs.");
  add("completed", &command::Command::completed, "A state: it ended in order.");
  add("failed", &command::Command::failed, "A state: it has failed.");
  add("stopped", &command::Command::stopped, "A state: a stop has ended it.");
  add("cancelled", &command::Command::cancelled, "A state: its cancel was asked for.");
  add("paused", &command::Command::paused, "A state: people hold its arms still.");
}

void bind_command(nb::module_& module) {
  nb::class_<Command> made(module, "Command", "Something that is to happen in real time.");
  made.def_prop_ro("name", [](const Command& one) { return one.value.name(); })
      .def(
          "on_entered",
          [](Command& one, const State& state, const command::Effect& effect, double after_s, bool first_only) {
            (void)one.cell->get();
            one.value.on_entered(state.value, effect, {.first_only = first_only, .delay = after_s});
          },
          nb::arg("state"), nb::arg("effect"), nb::arg("after_s") = 0.0, nb::arg("first_only") = false,
          "When the state becomes true while the command is active, then the effect.")
      .def(
          "on_left",
          [](Command& one, const State& state, const command::Effect& effect, double after_s, bool first_only) {
            (void)one.cell->get();
            one.value.on_left(state.value, effect, {.first_only = first_only, .delay = after_s});
          },
          nb::arg("state"), nb::arg("effect"), nb::arg("after_s") = 0.0, nb::arg("first_only") = false,
          "When the state ceases to be true while the command is active, then the effect.")
      .def(
          "fails_if", [](Command& one, const State& state) { one.value.fails_if(state.value); }, nb::arg("state"));
  bind_command_states(made);
  module.def("runtime_command", runtime_command);
  module.def("wait_command", wait_command, nb::arg(), nb::arg(), nb::arg(), nb::arg().none());
}

void bind_transaction(nb::module_& module) {
  nb::class_<Transaction>(module, "Transaction", "Commands in one real-time context.")
      .def(
          "add", [](Transaction& one, const Command& part) { one.value->add(part.value); }, nb::arg("command"),
          "A command that an event starts.")
      .def(
          "add_started", [](Transaction& one, const Command& part) { one.value->add_started(part.value); },
          nb::arg("command"), "A command that starts in the cycle in which this does.")
      .def(
          "raised",
          [](Transaction& one, const std::string& name) {
            return Raised{one.cell, one.value->raised(name)};
          },
          nb::arg("name"), "A state that handlers in here may raise.")
      .def("as_command", [](const Transaction& one) {
        return Command{one.cell, *one.value};
      });
  module.def("transaction", [](C c, const std::string& name) {
    (void)c->get();
    return Transaction{c, std::make_shared<command::TransactionCommand>(name)};
  });
  module.def("command_activity", [](C c, const Command& one) { return Activity{c, c->get().as_activity(one.value)}; });
}

}  // namespace

void bind_commands(nb::module_& module) {
  bind_actions(module);
  bind_effects(module);
  bind_command(module);
  bind_transaction(module);
}

}  // namespace takt::python
