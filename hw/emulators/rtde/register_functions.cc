// Registers and terminals, as programs read and write them.
#include <fmt/format.h>

#include "hw/emulators/rtde/controller.h"

namespace takt::hw::rtde {

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

/// @param bit_of  bit of the terminal that a program calls n
void add_digital(Library& library, Controller& c, const std::string& group, int count, int (*bit_of)(int)) {
  const auto bit = [=](const Arguments& a) { return bit_of(a.integer(0, 0, count - 1)); };
  library.add(fmt::format("set_{}digital_out(n, b)", group), checked([=, &c](const Arguments& a) -> Outcome {
                c.io().set_digital_out(bit(a), a.boolean(1));
                return Value();
              }));
  library.add(fmt::format("get_{}digital_out(n)", group),
              checked([=, &c](const Arguments& a) -> Outcome { return Value(c.io().digital_output(bit(a))); }));
  library.add(fmt::format("get_{}digital_in(n)", group),
              checked([=, &c](const Arguments& a) -> Outcome { return Value(c.io().digital_input(bit(a))); }));
}

void add_analog(Library& library, Controller& c) {
  for (const char* signature : {"set_standard_analog_out(n, f)", "set_analog_out(n, f)"})
    library.add(signature, checked([&c](const Arguments& a) -> Outcome {
                  c.io().analog_out[index(a, 0, 2)] = std::clamp(a.real(1), 0.0, 1.0);
                  return Value();
                }));
  library.add("get_standard_analog_in(n)",
              checked([&c](const Arguments& a) -> Outcome { return Value(c.io().analog_in[index(a, 0, 2)]); }));
  library.add("get_analog_in(n)", checked([&c](const Arguments& a) -> Outcome {  // 2 and 3 are the tool's
                const std::size_t n = index(a, 0, 4);
                return Value(n < 2 ? c.io().analog_in[n] : c.io().tool_analog_in[n - 2]);
              }));
  for (const char* signature : {"get_standard_analog_out(n)", "get_analog_out(n)"})
    library.add(signature,
                checked([&c](const Arguments& a) -> Outcome { return Value(c.io().analog_out[index(a, 0, 2)]); }));
  library.add("get_tool_analog_in(n)",
              checked([&c](const Arguments& a) -> Outcome { return Value(c.io().tool_analog_in[index(a, 0, 2)]); }));
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
  add_digital(library, c, "standard_", 8, [](int n) { return n; });
  add_digital(library, c, "configurable_", 8, [](int n) { return Terminals::kConfigurable + n; });
  add_digital(library, c, "tool_", 2, [](int n) { return Terminals::kTool + n; });
  // As before there were configurable terminals: 8 and 9 are the tool's.
  add_digital(library, c, "", 10, [](int n) { return n < 8 ? n : Terminals::kTool + n - 8; });
  add_analog(library, c);
}

}  // namespace takt::hw::rtde
