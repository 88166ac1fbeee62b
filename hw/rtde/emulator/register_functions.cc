// Registers and terminals, as programs read and write them.
#include <fmt/format.h>

#include "hw/rtde/emulator/arguments.h"
#include "hw/rtde/emulator/controller.h"

namespace takt::rtde {

namespace {

using urscript::Library;
using urscript::Outcome;
using urscript::Value;

std::size_t index(const Arguments& a, std::size_t i, int count) {
  return static_cast<std::size_t>(a.integer(i, 0, count - 1));
}

/// "input_int_register_24" or "speed_slider_mask": number of an input field.
FieldTable::Id field_of(const Arguments& a) {
  const auto id = input_fields().find(a.text(0));
  if (!id) throw BadArgument{fmt::format("'{}' is no input field of RTDE", a.text(0))};
  return *id;
}

Programs::WatchdogAction action_of(const std::string& text) {
  if (text == "ignore") return Programs::WatchdogAction::kIgnore;
  if (text == "pause") return Programs::WatchdogAction::kPause;
  if (text == "stop") return Programs::WatchdogAction::kStop;
  throw BadArgument{fmt::format("action '{}', expected 'ignore', 'pause' or 'stop'", text)};
}

void add_reading(Library& library, Controller& c, const std::string& prefix, Registers& (Controller::*of)()) {
  library.add(prefix + "_integer_register(address)", checked([&c, of](const Arguments& a) -> Outcome {
                return Value((c.*of)().ints[index(a, 0, Registers::kCount)]);
              }));
  library.add(prefix + "_float_register(address)", checked([&c, of](const Arguments& a) -> Outcome {
                return Value((c.*of)().reals[index(a, 0, Registers::kCount)]);
              }));
  library.add(prefix + "_boolean_register(address)", checked([&c, of](const Arguments& a) -> Outcome {
                return Value(bool{(c.*of)().bits[index(a, 0, Registers::kBits)]});
              }));
}

void add_digital(Library& library, Controller& c, const std::string& group, int first, int count) {
  library.add(fmt::format("set_{}digital_out(n, b)", group), checked([=, &c](const Arguments& a) -> Outcome {
                c.io().set_digital_out(first + a.integer(0, 0, count - 1), a.boolean(1));
                return Value();
              }));
  library.add(fmt::format("get_{}digital_out(n)", group), checked([=, &c](const Arguments& a) -> Outcome {
                return Value(c.io().digital_output(first + a.integer(0, 0, count - 1)));
              }));
  library.add(fmt::format("get_{}digital_in(n)", group), checked([=, &c](const Arguments& a) -> Outcome {
                return Value(c.io().digital_input(first + a.integer(0, 0, count - 1)));
              }));
}

void add_analog(Library& library, Controller& c) {
  for (const char* signature : {"set_standard_analog_out(n, f)", "set_analog_out(n, f)"})
    library.add(signature, checked([&c](const Arguments& a) -> Outcome {
                  c.io().analog_out[index(a, 0, 2)] = std::clamp(a.real(1), 0.0, 1.0);
                  return Value();
                }));
  for (const char* signature : {"get_standard_analog_in(n)", "get_analog_in(n)"})
    library.add(signature,
                checked([&c](const Arguments& a) -> Outcome { return Value(c.io().analog_in[index(a, 0, 2)]); }));
  for (const char* signature : {"get_standard_analog_out(n)", "get_analog_out(n)"})
    library.add(signature,
                checked([&c](const Arguments& a) -> Outcome { return Value(c.io().analog_out[index(a, 0, 2)]); }));
  library.add("get_tool_analog_in(n)",
              checked([&c](const Arguments& a) -> Outcome { return Value(c.io().tool_analog_in[index(a, 0, 2)]); }));
  library.add("set_tool_voltage(voltage)", checked([&c](const Arguments& a) -> Outcome {
                const int voltage = a.integer(0);
                if (voltage != 0 && voltage != 12 && voltage != 24)
                  throw BadArgument{fmt::format("{} V, expected 0, 12 or 24", voltage)};
                c.io().tool_voltage = voltage;
                return Value();
              }));
  for (const char* signature :
       {"set_standard_analog_input_domain(port, domain)", "set_tool_analog_input_domain(port, domain)"})
    library.add(signature, checked([](const Arguments& a) -> Outcome {
                  (void)a.integer(0, 0, 1);
                  (void)a.integer(1, 0, 1);
                  return Value();
                }));
  library.add("set_analog_outputdomain(port, domain)", checked([&c](const Arguments& a) -> Outcome {
                const unsigned bit = 4u << index(a, 0, 2);
                const bool voltage = a.integer(1, 0, 1) == 1;
                c.io().analog_types =
                    static_cast<std::uint8_t>(voltage ? c.io().analog_types | bit : c.io().analog_types & ~bit);
                return Value();
              }));
}

}  // namespace

void add_register_functions(Library& library, Controller& c) {
  add_reading(library, c, "read_input", &Controller::inputs);
  add_reading(library, c, "read_output", &Controller::outputs);
  library.add("write_output_integer_register(address, value)", checked([&c](const Arguments& a) -> Outcome {
                c.outputs().ints[index(a, 0, Registers::kCount)] = a.integer(1);
                return Value();
              }));
  library.add("write_output_float_register(address, value)", checked([&c](const Arguments& a) -> Outcome {
                c.outputs().reals[index(a, 0, Registers::kCount)] = a.real(1);
                return Value();
              }));
  library.add("write_output_boolean_register(address, value)", checked([&c](const Arguments& a) -> Outcome {
                c.outputs().bits[index(a, 0, Registers::kBits)] = a.boolean(1);
                return Value();
              }));
  library.add("rtde_set_watchdog(variable_name, min_frequency, action='pause')",
              checked([&c](const Arguments& a) -> Outcome {
                const double frequency = a.real(1);
                if (frequency <= 0.0) throw BadArgument{"the frequency must be above 0 Hz"};
                const auto longest = static_cast<Nanoseconds>(static_cast<double>(kSecond) / std::max(frequency, 1e-3));
                c.programs().set_watchdog(field_of(a), longest, action_of(a.text(2)));
                return Value();
              }));
}

void add_io_functions(Library& library, Controller& c) {
  add_digital(library, c, "standard_", 0, 8);
  add_digital(library, c, "configurable_", Terminals::kConfigurable, 8);
  add_digital(library, c, "tool_", Terminals::kTool, 2);
  add_digital(library, c, "", 0, 10);
  add_analog(library, c);
}

}  // namespace takt::rtde
