// What installations set before a program: kinds of terminals, actions of inputs and outputs, the tool's connector,
// Modbus signals, flags.
#include <algorithm>
#include <initializer_list>

#include <fmt/format.h>

#include "hw/emulators/rtde/controller.h"

namespace takt::hw::rtde {

namespace {

using urscript::Library;
using urscript::Outcome;
using urscript::Value;

constexpr int kMostRunstates = 5;

/// A function that gives nothing.
template <class Run>
void add_command(Library& library, std::string_view signature, Run run) {
  library.add(signature, checked([run](const Arguments& a) -> Outcome {
                run(a);
                return Value();
              }));
}

/// Ports 0 and 1 are the controller's, whose ranges are all voltages; 2 and 3 are the tool's, whose range 2 is a
/// current.
void set_analog_input_range(Terminals& io, const Arguments& a) {
  const auto port = static_cast<unsigned>(a.integer(0, 0, 3));
  const int range = a.integer(1, 0, port < 2 ? 3 : 2);
  if (port < 2)
    Terminals::set_type(io.analog_types, port, true);
  else
    Terminals::set_type(io.tool_analog_types, port - 2, range < 2);
}

void add_terminals(Library& library, Controller& c) {
  add_command(library, "set_analog_inputrange(port, range)",
              [&c](const Arguments& a) { set_analog_input_range(c.io(), a); });
  const auto add_domain = [&library](std::string_view signature, std::uint8_t& types, unsigned first) {
    add_command(library, signature, [&types, first](const Arguments& a) {
      const auto port = static_cast<unsigned>(a.integer(0, 0, 1));
      Terminals::set_type(types, first + port, a.integer(1, 0, 1) == 1);
    });
  };
  add_domain("set_standard_analog_input_domain(port, domain)", c.io().analog_types, 0);
  add_domain("set_analog_outputdomain(port, domain)", c.io().analog_types, Terminals::kAnalogOut);
  add_domain("set_tool_analog_input_domain(port, domain)", c.io().tool_analog_types, 0);
}

void check_one_of(const Arguments& a, std::size_t i, std::initializer_list<int> allowed) {
  const int value = a.integer(i);
  if (std::ranges::find(allowed, value) != allowed.end()) return;
  throw BadArgument{fmt::format("argument {} is {}, expected one of {}", i + 1, value, fmt::join(allowed, ", "))};
}
void check_between(const Arguments& a, std::size_t i, double lower, double upper) {
  const double value = a.real(i);
  if (value < lower || value > upper)
    throw BadArgument{fmt::format("argument {} is {:g}, expected {:g} to {:g}", i + 1, value, lower, upper)};
}

/// The connector at the flange. Nothing hangs on it: what is said is checked.
void add_tool_connector(Library& library, Controller& c) {
  add_command(library, "set_tool_voltage(voltage)", [&c](const Arguments& a) {
    check_one_of(a, 0, {0, 12, 24});
    c.io().tool_voltage = a.integer(0);
  });
  add_command(library, "set_tool_output_mode(mode)", [](const Arguments& a) { (void)a.integer(0, 0, 1); });
  add_command(library, "set_tool_digital_output_mode(n, mode)", [](const Arguments& a) {
    (void)a.integer(0, 0, 1);
    (void)a.integer(1, 1, 3);
  });
  add_command(library, "set_tool_communication(enabled, baud_rate, parity, stop_bits, rx_idle_chars, tx_idle_chars)",
              [](const Arguments& a) {
                (void)a.boolean(0);
                check_one_of(a, 1, {9600, 19200, 38400, 57600, 115200, 1000000, 2000000, 5000000});
                (void)a.integer(2, 0, 2);
                (void)a.integer(3, 1, 2);
                check_between(a, 4, 1.0, 40.0);
                check_between(a, 5, 0.0, 40.0);
              });
}

/// What inputs do by themselves. The emulated ones do nothing beside what programs make of them, so only the default is
/// honest, and "freedrive" is refused.
void check_action(const Arguments& a, int ports) {
  (void)a.integer(0, 0, ports - 1);
  if (a.text(1) != "default")
    throw BadArgument{fmt::format("the action '{}' of an input is not emulated, only 'default' is", a.text(1))};
}

void add_actions(Library& library, Controller& c) {
  struct Group {
    const char* name;
    int first, count;
  };
  for (const Group& group : {Group{"standard", 0, 8}, Group{"configurable", Terminals::kConfigurable, 8},
                             Group{"tool", Terminals::kTool, 2}}) {
    const int count = group.count;
    add_command(library, fmt::format("set_{}_digital_input_action(port, action)", group.name),
                [count](const Arguments& a) { check_action(a, count); });
    add_command(library, fmt::format("set_runstate_{}_digital_output_to_value(outputId, state)", group.name),
                [&c, group](const Arguments& a) {
                  const int output = group.first + a.integer(0, 0, group.count - 1);
                  c.io().with_program[static_cast<std::size_t>(output)] =
                      static_cast<WithProgram>(a.integer(1, 0, kMostRunstates));
                });
  }
  add_command(library, "set_gp_boolean_input_action(port, action)",
              [](const Arguments& a) { check_action(a, Registers::kBits); });
  add_command(library, "set_input_actions_to_default()", [](const Arguments&) {});
  // These keep their values.
  add_command(library, "set_runstate_gp_boolean_output_to_value(outputId, state)", [](const Arguments& a) {
    (void)a.integer(0, 0, Registers::kBits - 1);
    (void)a.integer(1, 0, kMostRunstates);
  });
  add_command(library, "set_runstate_standard_analog_output_to_value(outputId, state)", [](const Arguments& a) {
    (void)a.integer(0, 0, 1);
    (void)a.integer(1, 0, kMostRunstates);
  });
  add_command(library, "set_runstate_outputs(outputs)", [](const Arguments& a) {
    if (!a.none(0) && a[0].get<urscript::List>() == nullptr) throw BadArgument{"argument 1 must be a list"};
  });
  add_command(library, "set_safety_mode_transition_hardness(type)",
              [](const Arguments& a) { (void)a.integer(0, 0, 1); });
}

/// There is no Modbus device: signals can be named, and none of them is connected.
void add_modbus(Library& library) {
  add_command(library,
              "modbus_add_signal(IP, slave_number, signal_address, signal_type, signal_name, use_register_names=False)",
              [](const Arguments& a) {
                (void)a.integer(1, 0, 255);
                (void)a.integer(2, 0, 65535);
                (void)a.integer(3, 0, 3);
                if (a.text(4).empty()) throw BadArgument{"a signal needs a name"};
              });
  add_command(library, "modbus_delete_signal(signal_name)", [](const Arguments& a) { (void)a.text(0); });
  add_command(library, "modbus_set_signal_update_frequency(signal_name, update_frequency)",
              [](const Arguments& a) { check_between(a, 1, 0.0, 125.0); });
  add_command(library, "modbus_set_runstate_dependent_choice(signal_name, runstate_choice)",
              [](const Arguments& a) { (void)a.integer(1, 0, 3); });
}

void add_flags(Library& library, Controller& c) {
  add_command(library, "set_flag(n, b)", [&c](const Arguments& a) {
    c.settings().flags[static_cast<std::size_t>(a.integer(0, 0, 31))] = a.boolean(1);
  });
  library.add("get_flag(n)", checked([&c](const Arguments& a) -> Outcome {
                return Value(bool{c.settings().flags[static_cast<std::size_t>(a.integer(0, 0, 31))]});
              }));
}

}  // namespace

void add_installation_functions(Library& library, Controller& c) {
  add_terminals(library, c);
  add_tool_connector(library, c);
  add_actions(library, c);
  add_modbus(library);
  add_flags(library, c);
}

}  // namespace takt::hw::rtde
