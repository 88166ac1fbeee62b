#include "languages/urscript/session.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include <fmt/format.h>

namespace takt::languages::urscript {

namespace {

constexpr int kMainThread = 1;

/// Functions of UR's controllers that have no match here: they are told apart from mistakes.
constexpr std::array kUnsupported = {"conveyor_pulse_decode",
                                     "encoder_enable_pulse_decode",
                                     "encoder_enable_set_tick_count",
                                     "encoder_get_tick_count",
                                     "force",
                                     "force_mode_set_damping",
                                     "force_mode_set_gain_scaling",
                                     "get_actual_joint_speeds",
                                     "get_actual_tcp_speed",
                                     "get_controller_temp",
                                     "get_flag",
                                     "get_joint_temp",
                                     "get_joint_torques",
                                     "get_target_joint_speeds",
                                     "get_target_tcp_speed",
                                     "get_target_waypoint",
                                     "get_tcp_force",
                                     "get_tool_accelerometer_reading",
                                     "get_tool_current",
                                     "interpreter_mode",
                                     "is_within_safety_limits",
                                     "modbus_add_signal",
                                     "optimovej",
                                     "optimovel",
                                     "path_offset_enable",
                                     "position_deviation_warning",
                                     "powerdown",
                                     "protective_stop",
                                     "read_input_boolean_register",
                                     "read_input_float_register",
                                     "read_input_integer_register",
                                     "request_boolean_from_primary_client",
                                     "reset_revolution_counter",
                                     "rpc_factory",
                                     "rtde_set_watchdog",
                                     "screw_driving",
                                     "set_conveyor_tick_count",
                                     "set_flag",
                                     "set_gravity",
                                     "set_tool_voltage",
                                     "socket_close",
                                     "socket_open",
                                     "socket_read_ascii_float",
                                     "socket_read_string",
                                     "socket_send_line",
                                     "socket_send_string",
                                     "speedj",
                                     "tool_contact",
                                     "track_conveyor_circular",
                                     "track_conveyor_linear",
                                     "write_output_boolean_register",
                                     "write_output_float_register",
                                     "write_output_integer_register"};

Diagnostic to_diagnostic(const ScriptError& error, const std::string& file, const Library& library) {
  Diagnostic made{.code = takt::Code::kSyntax,
                  .file = file,
                  .pointer = {},
                  .message = error.text,
                  .hint = {},
                  .line = error.line,
                  .column = error.column};
  if (error.unknown.empty()) return made;
  if (std::ranges::find(kUnsupported, error.unknown) != kUnsupported.end()) {
    made.code = takt::Code::kUnsupported;
    made.message = fmt::format("'{}' is not supported", error.unknown);
    made.hint = "Use a word of docs/urscript.md, or give the function in \"calls\" of the map";
    return made;
  }
  made.code = takt::Code::kUnknownName;
  made.message = fmt::format("there is no {} '{}'", error.is_call ? "function" : "variable", error.unknown);
  if (!error.is_call) {
    made.hint = "Declare it before, or give it in \"frames\" or \"tools\" of the map";
    return made;
  }
  std::vector<std::string> names;
  for (const Builtin& one : library.all()) names.push_back(one.name);
  const std::string nearest = nearest_choice(error.unknown, names);
  made.hint = "Define it, or give it in \"calls\" of the map";
  if (nearest.starts_with("did you mean")) made.hint += "; " + nearest.substr(0, nearest.find('?') + 1);
  return made;
}

}  // namespace

Result<std::shared_ptr<const Program>> compile_for_arm(const ScriptText& text, const std::set<std::string>& calls,
                                                       const std::vector<std::string>& given) {
  constexpr std::size_t kMostBytes = 1u << 20;
  if (text.source.size() > kMostBytes) {
    Diagnostics large;
    large.add({.code = takt::Code::kTooLarge,
               .file = text.file,
               .pointer = {},
               .message = fmt::format("a program of {} bytes", text.source.size()),
               .hint = "Split it: 1 MiB at most",
               .line = 1,
               .column = 1});
    return std::unexpected(std::move(large));
  }
  const Library library = arm_library(nullptr, calls);
  ScriptErrors errors;
  auto program = compile(text.source, library, errors, given);
  Diagnostics diagnostics;
  std::ranges::sort(errors, {}, [](const ScriptError& one) { return std::tuple(one.line, one.column, one.text); });
  for (const ScriptError& one : errors) diagnostics.add(to_diagnostic(one, text.file, library));
  if (program != nullptr && program->secondary)
    diagnostics.add({.code = takt::Code::kUnsupported,
                     .file = text.file,
                     .pointer = {},
                     .message = "a secondary program has no main program beside which it runs",
                     .hint = "Begin it with 'def'",
                     .line = 1,
                     .column = 1});
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return program;
}

Session::Session(std::shared_ptr<const Program> program, Host& host, const std::set<std::string>& calls,
                 const std::vector<GivenVariable>& given)
    : host_(host), functions_(host), library_(arm_library(&functions_, calls)), machine_(std::move(program), library_) {
  functions_.attach(machine_);
  for (std::size_t i = 0; i < given.size(); ++i) machine_.set_global(i, given[i].value);
}

Session::Progress Session::advance() {
  if (progress_ != Progress::kRunning) return progress_;
  functions_.begin_round();
  const bool runs = machine_.run_frame();
  if (machine_.error()) {
    error_ = *machine_.error();
    return end(Progress::kFailed);
  }
  if (runs && machine_.frames_without_time() >= kMostFrames) {
    error_ = {machine_.line(), machine_.column(), "a loop takes no time: write sync() or sleep() into it"};
    return end(Progress::kFailed);
  }
  const std::vector<int> ended = machine_.take_ended_threads();
  if (runs) {
    functions_.release(ended);
    return Progress::kRunning;
  }
  halted_ = machine_.stopped();
  return end(Progress::kEnded);
}

/// Motions that the main program has given go on to their goals, unless it was halted.
Session::Progress Session::end(Progress progress) {
  const bool goes_on = progress == Progress::kEnded && !halted_ && functions_.owner() == kMainThread && !host_.lasts();
  if (!goes_on && functions_.busy()) host_.stop();
  return progress_ = progress;
}

}  // namespace takt::languages::urscript
