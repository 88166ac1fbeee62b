// Commands of programs: transactions and their events, motions in them, manual control, overlays, freedrive.
#include "tests/core/activity/broken_rules.h"

namespace takt::test {
namespace {

std::string tree(const std::string& commands, const std::string& more = "") {
  return R"({"do": "transaction", "commands": {)" + commands + "}" + more + "}";
}
/// A command that starts with its transaction.
std::string first(const std::string& name, const std::string& keys) {
  return "\"" + name + R"(": {"start": true, )" + keys + "}";
}
std::string later(const std::string& name, const std::string& keys) { return "\"" + name + "\": {" + keys + "}"; }

const std::string kDriver = R"("do": "set", "output": "driver", "value": true)";
const std::string kUp = R"("do": "lin", "to": {"by_m": [0, 0, 0.05]}, "velocity_m_s": 0.05)";
const std::string kHard = R"({"sensor": "wrist", "above_N": 900})";

/// A transaction with one command 'a' and one event handler.
std::string on(const std::string& handler) { return tree(first("a", kDriver), R"(, "on": [)" + handler + "]"); }
std::string then(const std::string& effect) { return on(R"({"entered": {"completed": "a"}, )" + effect + "}"); }
std::string when(const std::string& state) { return on(R"({"entered": )" + state + R"(, "cancel": "a"})"); }

std::vector<BrokenRule> commands() {
  return {
      {R"({"do": "transaction"})", "", Code::kMissing, {"commands"}},
      {tree(R"("a": 3)"), "/commands/a", Code::kWrongType, {"3"}},
      {tree(R"("a": {"seconds": 1})"), "/commands/a/do", Code::kMissing, {"do"}},
      {tree(first("a", R"("do": "prses")")), "/commands/a/do", Code::kUnknownName, {"prses", "press"}},
      {tree(first("a/b", R"("do": "wait", "seconds": 1)")), "/commands/a~1b", Code::kInvalidName, {"a/b", "/"}},
      {tree(first("a", kDriver + R"(, "name": "b")")), "/commands/a/name", Code::kDuplicate, {"a", "b"}},
      {tree(R"("a": {"start": 1, )" + kDriver + "}"), "/commands/a/start", Code::kWrongType, {"1"}},
      {R"({"do": "hold", "seconds": 1, "start": true})", "/start", Code::kConflict, {"start"}},
      {tree(first("a", kDriver), R"(, "capture": {"x": {}})"), "/capture/x", Code::kMissing, {"value"}},
      {tree(first("a", kDriver), R"(, "capture": {"x": {"value": {"progress": "b"}}})"),
       "/capture/x/value/progress",
       Code::kUnknownName,
       {"b", "transaction", "C6"}},
      {tree(first("a", kDriver), R"(, "capture": {"x": {"value": {"speed": "arm"}, "when": {"started": "a"},
                                                        "rate_Hz": 10}})"),
       "/capture/x/rate_Hz",
       Code::kConflict,
       {"rate_Hz", "when"}},
      {tree(first("a", kDriver), R"(, "on_cancel": "never")"), "/on_cancel", Code::kUnknownName, {"never"}},
      {tree(first("a", kDriver), R"(, "on_cancel": ["b"])"), "/on_cancel/0", Code::kUnknownName, {"b", "C6"}},
  };
}

std::vector<BrokenRule> events() {
  const std::string none = R"("cancel": "a")";
  return {
      {tree(first("a", kDriver), R"(, "on": 5)"), "/on", Code::kWrongType, {"5"}},
      {on("{" + none + "}"), "/on/0", Code::kMissing, {"entered", "left"}},
      {on(R"({"entered": {"completed": "a"}, "left": {"completed": "a"}, )" + none + "}"),
       "/on/0",
       Code::kMissing,
       {"entered", "left"}},
      {on(R"({"entered": {"completed": "a"}})"), "/on/0", Code::kMissing},
      {then(R"("cancel": {})"), "/on/0/cancel", Code::kWrongType},
      {then(R"("stop": [5])"), "/on/0/stop/0", Code::kWrongType, {"5"}},
      {then(R"("start": "b")"), "/on/0/start", Code::kUnknownName, {"b", "transaction", "C6"}},
      {then(R"("raise": "lost")"), "/on/0/raise", Code::kUnknownName, {"lost", "raised", "C10"}},
      {then(R"("tell": 5)"), "/on/0/tell", Code::kWrongType, {"5"}},
      {then(R"("tell": "")"), "/on/0/tell", Code::kMissing},
      {then(R"("tell": "it is done", "after_s": -1)"), "/on/0/after_s", Code::kOutOfRange, {"-1", "0", "3600"}},
      {when("{}"), "/on/0/entered", Code::kMissing},
      {when(R"({"any": []})"), "/on/0/entered/any", Code::kMissing},
      {when(R"({"completed": "b"})"), "/on/0/entered/completed", Code::kUnknownName, {"b", "C6"}},
      {when(R"({"raised": "lost"})"), "/on/0/entered/raised", Code::kUnknownName, {"lost", "raised", "C10"}},
      {when(R"({"action": "a", "at_path": 2})"), "/on/0/entered/at_path", Code::kOutOfRange, {"2", "0", "1"}},
      {when(R"({"actuator": "amr", "is": "completed"})"), "/on/0/entered/actuator", Code::kUnknownName, {"amr", "arm"}},
      {when(R"({"channel": "speed"})"), "/on/0/entered/channel", Code::kTypeMismatch, {"speed", "is"}},
  };
}

std::vector<BrokenRule> motions() {
  const std::string to_home = R"("do": "ptp", "to": "home")";
  const auto several = [](const std::string& steps) {
    return tree(first("m", R"("do": "motions", "steps": [)" + steps + "]"));
  };
  const std::string blended = "{" + kUp + R"(, "blend_m": 0.01})";
  return {
      {several(""), "/commands/m/steps", Code::kMissing},
      {several(blended + R"(, {"do": "hold", "seconds": 1})"), "/commands/m/steps/1/do", Code::kUnknownName, {"hold"}},
      {several("{" + kUp + R"(, "blend_m": 0.01, "until": )" + kHard + "}, {" + to_home + "}"),
       "/commands/m/steps/0/until", Code::kConflict},
      {several("{" + kUp + "}, {" + to_home + "}"), "/commands/m/steps/0", Code::kConflict},
      {several("{" + kUp + R"(, "blend_m": 0.01, "base_to": "home"}, {)" + to_home + "}"),
       "/commands/m/steps/0/base_to",
       Code::kConflict,
       {"lin"}},
      {tree(first("m", kUp + R"(, "base_to": "home", "force_offset": {"force_N": 5})")),
       "/commands/m/force_offset",
       Code::kConflict,
       {"force_offset"}},
      {tree(first("m", kUp + R"(, "base_to": "home", "weave": {"amplitude_m": 0.002, "frequency_Hz": 2})")),
       "/commands/m/weave",
       Code::kConflict,
       {"weave"}},
      {"{" + kUp + R"(, "base_to": {"by_m": 1}})", "/base_to/by_m", Code::kWrongType, {"1", "3"}},
  };
}

std::vector<BrokenRule> following() {
  const auto valve = [](const std::string& keys) {
    return tree(first("v", R"("do": "set", "output": "valve", )" + keys));
  };
  const std::string felt = R"("value": {"sensor": "wrist"}, "factor": 0.1)";
  return {
      {valve(R"("value": {})"), "/commands/v/value", Code::kMissing, {"sensor"}},
      {valve(R"("value": {"sensor": "wirst"})"), "/commands/v/value/sensor", Code::kUnknownName, {"wirst", "wrist"}},
      {valve(R"("value": {"speed": "amr"})"), "/commands/v/value/speed", Code::kUnknownName, {"amr"}},
      {valve(R"("value": {"input": "button"})"), "/commands/v/value/input", Code::kInvalidValue, {"button"}},
      {valve(R"("value": {"channel": "enable"}, "factor": 1)"),
       "/commands/v/value/channel",
       Code::kInvalidValue,
       {"enable"}},
      {valve(R"("value": {"progress": "b"}, "factor": 1)"),
       "/commands/v/value/progress",
       Code::kUnknownName,
       {"b", "transaction", "C6"}},
      {valve(felt + R"(, "seconds": -1)"), "/commands/v/seconds", Code::kOutOfRange, {"-1", "0", "3600"}},
      {valve(felt + R"(, "offset": "much")"), "/commands/v/offset", Code::kOutOfRange, {"much"}},
      {valve(felt + R"(, "until": {"input": "buton"})"),
       "/commands/v/until/input",
       Code::kUnknownName,
       {"buton", "button"}},
      {valve(R"("value": 1, "factor": 2)"), "/commands/v/factor", Code::kConflict, {"factor", "value"}},
      {tree(first("d", R"("do": "set", "output": "driver", "value": {"input": "button"})")), "/commands/d/value",
       Code::kWrongType},
  };
}

std::vector<BrokenRule> online() {
  const std::string held = R"("while": {"channel": "enable"})";
  return {
      {R"({"do": "jog", )" + held + "}", "", Code::kMissing, {"channel", "linear_m_s", "angular_deg_s"}},
      {R"({"do": "jog", "channel": "stick"})", "", Code::kMissing, {"while"}},
      {R"({"do": "jog", "channel": "stcik", )" + held + "}", "/channel", Code::kUnknownName, {"stcik", "stick"}},
      {R"({"do": "jog", "channel": "speed", )" + held + "}", "/channel", Code::kTypeMismatch, {"speed"}},
      {R"({"do": "jog", "channel": "stick", "while": {"channel": "enabel"}})",
       "/while/channel",
       Code::kUnknownName,
       {"enabel", "enable"}},
      {R"({"do": "jog", "channel": "stick", "linear_max_m_s": 0, )" + held + "}",
       "/linear_max_m_s",
       Code::kOutOfRange,
       {"0"}},
      {R"({"do": "jog", "channel": "stick", "linear_m_s": [0, 0, 0.1], )" + held + "}", "/linear_m_s", Code::kConflict},
      {R"({"do": "follow"})", "/in", Code::kMissing, {"in", "channel"}},
      {R"({"do": "follow", "in": "world", "until": {"input": "buton"}})",
       "/until/input",
       Code::kUnknownName,
       {"buton", "button"}},
      {R"({"do": "hold", "seconds": -1})", "/seconds", Code::kOutOfRange, {"-1", "0", "3600"}},
  };
}

/// Two lines that are blended, with keys of each.
std::string blended(const std::string& a, const std::string& b) {
  return R"({"do": "sequence", "steps": [{"do": "lin", "name": "a", "to": {"by_m": [0, 0, 0.05]}, "blend_m": 0.01)" +
         a + R"(}, {"do": "lin", "name": "b", "to": {"by_m": [0.05, 0, 0]})" + b + "}]}";
}
const std::string kOffset5 = R"(, "force_offset": {"sensor": "wrist", "force_N": 5})";

std::vector<BrokenRule> overlays() {
  const auto over = [](const std::string& keys) { return "{" + kUp + ", " + keys + "}"; };
  const std::string weave = R"("weave": {"amplitude_m": 0.002, "frequency_Hz": 2)";
  const std::string offset = R"("force_offset": {"sensor": "wrist", "force_N": 5)";
  return {
      {over(R"("weave": 5)"), "/weave", Code::kWrongType, {"5"}},
      {over(R"("weave": {"frequency_Hz": 2})"), "/weave", Code::kMissing, {"amplitude_m", "0"}},
      {over(weave + R"(, "direction": [0, 0, 0]})"), "/weave/direction", Code::kOutOfRange},
      {over(weave + "}, " + offset + "}"), "/force_offset", Code::kConflict},
      {R"({"do": "ptp", "to": "home", "weave": {"amplitude_m": 0.002, "frequency_Hz": 2}})",
       "/weave",
       Code::kConflict,
       {"C8"}},
      {over(R"("force_offset": {"sensor": "foot", "force_N": 5})"),
       "/force_offset/sensor",
       Code::kConflict,
       {"foot", "arm"}},
      {over(R"("force_offset": {"sensor": "wrist", "force_N": 0})"),
       "/force_offset/force_N",
       Code::kOutOfRange,
       {"0", "0.1", "1000"}},
  };
}

const std::string kSprings = R"("compliance": {"mode": "joint_impedance")";
const std::string kPress = R"("do": "press", "sensor": "wrist", "direction": [0, 0, 1], "in": "world")";
/// A stiffness along all axes is to follow.
const std::string kSoft = R"("compliance": {"mode": "cartesian_impedance", "stiffness_N_m": )";
std::string in_springs_of_the_tool(const std::string& step) {
  return R"({"do": "sequence", "steps": [{"do": "control_mode", "mode": "cartesian_impedance"}, )" + step + "]}";
}

std::vector<BrokenRule> compliances() {
  const auto soft = [](const std::string& compliance) { return "{" + kUp + R"(, "compliance": )" + compliance + "}"; };
  return {
      {soft("5"), "/compliance", Code::kWrongType, {"5"}},
      {soft("{}"), "/compliance", Code::kMissing, {"mode", "joint_impedance"}},
      {soft(R"({"mode": "impedance"})"), "/compliance/mode", Code::kUnknownName, {"impedance", "joint_impedance"}},
      {soft(R"({"mode": "position", "stiffness_Nm_rad": 100})"),
       "/compliance/stiffness_Nm_rad",
       Code::kUnknownKey,
       {"stiffness_Nm_rad"}},
      {"{" + kUp + ", " + kSprings + R"(, "stiffness_N_m": 300}})",
       "/compliance/stiffness_N_m",
       Code::kUnknownKey,
       {"stiffness_N_m", "stiffness_Nm_rad"}},
      {soft(R"({"mode": "cartesian_impedance", "stiffness_N_m": [1, 2]})"),
       "/compliance/stiffness_N_m",
       Code::kWrongType,
       {"1", "2", "3"}},
      {soft(R"({"mode": "cartesian_impedance", "axes": "world"})"), "/compliance/axes", Code::kUnknownName, {"world"}},
      {tree(first(
           "m", R"("do": "motions", "steps": [{)" + kUp + R"(, "blend_m": 0.01}, {)" + kUp + ", " + kSprings + "}}]")),
       "/commands/m/steps/1/compliance",
       Code::kConflict,
       {"steps"}},
  };
}

std::vector<BrokenRule> freedrive() {
  return {
      {R"({"do": "freedrive"})", "", Code::kMissing, {"until", "seconds"}},
      {R"({"do": "freedrive", "seconds": 1, "enabled": {"input": "buton"}})",
       "/enabled/input",
       Code::kUnknownName,
       {"buton", "button"}},
      {R"({"do": "freedrive", "seconds": 1, "velocity_m_s": 0})", "/velocity_m_s", Code::kOutOfRange, {"0"}},
  };
}

}  // namespace

std::vector<BrokenRule> broken_transactions() {
  std::vector<BrokenRule> all;
  for (const auto& some :
       {commands(), events(), motions(), following(), online(), overlays(), compliances(), freedrive()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

std::vector<BrokenRule> broken_transaction_plans() {
  const std::string wait = R"("do": "wait", "seconds": 1)";
  return {
      {tree(""), "", Code::kNeverFires, {"transaction", "start", "C9"}},
      {tree(first("a", wait) + ", " + later("b", kDriver)), "/commands/b", Code::kNeverFires, {"b", "start", "C9"}},
      {tree(first("a", wait), R"(, "on": [{"entered": {"action": "a", "is": "error"}, "cancel": "a"}])"),
       "/on/0",
       Code::kInvalidValue,
       {"a", "error", "C8"}},
      {tree(first("a", wait), R"(, "capture": {"x": {"value": {"progress": "a"}}})"),
       "/capture/x",
       Code::kInvalidValue,
       {"a", "C8"}},
      {tree(first("press", kUp + R"(, "until": )" + kHard) + ", " + later("on", kUp),
            R"(, "on": [{"entered": {"completed": "press"}, "start": "on"}])"),
       "/commands/on",
       Code::kUnknownPosition,
       {"arm", "on"}},
      {tree(first("m", kUp + R"(, "blend_m": 0.01)") + ", " + first("w", wait)), "/commands/m", Code::kConflict, {"m"}},
      {tree(first("g", R"("do": "grip", "width_m": 0.3)")),
       "/commands/g/width_m",
       Code::kOutOfRange,
       {"gripper", "0.3", "0", "0.11"}},
      {tree(first("v", R"("do": "set", "output": "valve", "value": 11)")),
       "/commands/v/value",
       Code::kOutOfRange,
       {"valve", "11", "0", "10"}},
      {tree(first("v", R"("do": "set", "output": "valve", "value": {"sensor": "wrist"})")),
       "/commands/v/value",
       Code::kUnitMismatch,
       {"valve", "factor"}},
      {R"({"do": "set", "output": "valve", "value": {"speed": "arm"}, "seconds": 1})",
       "/value",
       Code::kUnitMismatch,
       {"valve", "factor"}},
      {tree(first("w", wait) + ", " +
            first("v", R"("do": "set", "output": "valve", "value": {"progress": "w"}, "factor": 10)")),
       "/commands/v",
       Code::kInvalidValue,
       {"w", "C8"}},
      {tree(first("w", kDriver) + ", " +
            first("v", R"("do": "set", "output": "valve", "value": {"progress": "w"}, "factor": 10)")),
       "/commands/v",
       Code::kUnknownName,
       {"progress", "C8"}},
      {tree(first("m", kUp + R"(, "base_to": "home")")), "/commands/m/arm", Code::kRequires, {"arm", "on"}},
      {R"({"do": "jog", "channel": "stick", "in": "nowhere", "while": {"channel": "enable"}})",
       "",
       Code::kUnknownName,
       {"nowhere"}},
      {blended(kOffset5, R"(, "force_offset": {"sensor": "wrist", "force_N": 6})"),
       "/steps/0/force_offset",
       Code::kConflict,
       {"b", "force_offset"}},
      {blended(R"(, "weave": {"amplitude_m": 0.001, "frequency_Hz": 2})", kOffset5),
       "/steps/0/weave",
       Code::kConflict,
       {"a"}},
      {"{" + kUp + R"(, "weave": {"amplitude_m": 0.1, "frequency_Hz": 50}})", "", Code::kOutOfRange},
      {"{" + kUp + R"(, "weave": {"amplitude_m": 0.002, "frequency_Hz": 2, "ramp_s": 0.02}})",
       "/weave/ramp_s",
       Code::kLimitExceeded,
       {"0.02"}},
      {"{" + kUp + ", " + kSprings + "}}",
       "/compliance",
       Code::kNotPossibleNow,
       {"arm", "control_mode", "joint_impedance"}},
      {"{" + kUp + R"(, "until": )" + kHard + ", " + kSprings + R"(, "stiffness_Nm_rad": 2500}})",
       "/compliance/stiffness_Nm_rad/6",
       Code::kOutOfRange,
       {"arm", "2500", "0", "2000"}},
      {"{" + kUp + ", " + kSprings + R"(, "damping_ratio": [1, 1]}})",
       "/compliance/damping_ratio",
       Code::kWrongSize,
       {"arm", "2", "7"}},
      {R"({"do": "hold", "seconds": 1, "compliance": {"mode": "cartesian_impedance", "torque_Nm": [0, 0, 20]}})",
       "/compliance/torque_Nm/2",
       Code::kOutOfRange,
       {"arm", "20", "-10", "10"}},
      {tree(first("h", R"("do": "hold", "seconds": 1, )" + kSprings + "}")),
       "/commands/h/compliance",
       Code::kNotPossibleNow,
       {"arm", "control_mode", "joint_impedance"}},
      {"{" + kPress + ", " + kSprings + "}}",
       "/compliance",
       Code::kNotPossibleNow,
       {"arm", "control_mode", "joint_impedance"}},
      {"{" + kPress + ", " + kSprings + R"(, "stiffness_Nm_rad": 2500}})",
       "/compliance/stiffness_Nm_rad/6",
       Code::kOutOfRange,
       {"arm", "2500", "0", "2000"}},
      {tree(first("p", kPress + ", " + kSprings + R"(, "damping_ratio": [1, 1]})")),
       "/commands/p/compliance/damping_ratio",
       Code::kWrongSize,
       {"arm", "2", "7"}},
      {in_springs_of_the_tool("{" + kPress + ", " + kSoft + "0}}"), "/steps/1/force_N", Code::kRequires, {"0"}},
      {in_springs_of_the_tool("{" + kPress + ", " + kSoft + "100}}"),
       "/steps/1/travel_m",
       Code::kLimitExceeded,
       {"10", "0.1", "0.05"}},
      {in_springs_of_the_tool(tree(first("p", kPress + ", " + kSoft + "100}"))),
       "/steps/1/commands/p/travel_m",
       Code::kLimitExceeded,
       {"10", "0.1"}},
      {"{" + kUp + R"(, "force_offset": {"sensor": "wrist", "force_N": 5, "acceleration_max_m_s2": 10}})",
       "",
       Code::kLimitExceeded,
       {"10"}},
  };
}

std::vector<BrokenRun> broken_transaction_runs() {
  const auto silent = [](int cycle, ActivityCell& cell) { cell.sensor->silent = cycle >= 300; };
  const auto pushed = [](int cycle, ActivityCell& cell) { cell.extra.force.x() = cycle >= 300 ? 1000.0 : 0.0; };
  const std::string press = kPress + R"(, "approach_m_s": 0.01)";
  const std::string wait = R"("do": "wait", "until": )" + kHard;
  return {
      {tree(first("w", wait + R"(, "timeout_s": 0.02)")), "/commands/w/until", Code::kTimeout, {"timeout_s", "0.02"}},
      {tree(first("w", wait + R"(, "timeout_s": 0.5)")), "/commands/w/until", Code::kSensorSilent, {}, silent},
      {tree(first("g", R"("do": "grip")")),
       "/commands/g",
       Code::kConditionNotMet,
       {"expect", "any", "40.0"},
       [](int cycle, ActivityCell& cell) {
         if (cycle >= 10) cell.fingers->answer(device::GripperState::kIdle, 0.04);
       }},
      {tree(first("m", kUp + R"(, "until": )" + kHard)),
       "/commands/m/until",
       Code::kConditionNotMet,
       {"on_end", "continue"},
       {},
       true},
      {tree(first("m", kUp + R"(, "until": )" + kHard)), "/commands/m/until", Code::kSensorSilent, {}, silent, true},
      {tree(first("m", kUp + R"(, "abort_if": )" + kHard)),
       "/commands/m/abort_if",
       Code::kAbortCondition,
       {"abort_if"},
       pushed,
       true},
      {tree(first("m", kUp + R"(, "abort_if": )" + kHard)),
       "/commands/m/abort_if",
       Code::kSensorSilent,
       {},
       silent,
       true},
      {"{" + kUp + R"(, "abort_if": )" + kHard + R"(, "weave": {"amplitude_m": 0.001, "frequency_Hz": 2}})",
       "/abort_if",
       Code::kAbortCondition,
       {"abort_if"},
       pushed,
       true},
      {R"({"do": "sequence", "steps": [{"do": "tare", "sensor": "wrist", "cycles": 20}, )" +
           tree(first("p", press + R"(, "travel_m": 0.005)")) + "]}",
       "/steps/1/commands/p/travel_m",
       Code::kConditionNotMet,
       {},
       {},
       true},
      {tree(first("p", press + R"(, "travel_m": 0.005)")),  // what hangs there is taken for a touch
       "/commands/p/travel_m",
       Code::kConditionNotMet,
       {},
       {},
       true},
      {tree(first("m", kUp)),
       "",
       Code::kStopped,
       {"try"},
       [](int cycle, ActivityCell& cell) { cell.backend->silent = cycle >= 200; },
       true},
      {tree(first("p", press)), "/commands/p/sensor", Code::kSensorSilent, {"wrist"}, silent, true},
      {"{" + kUp + R"(, "force_offset": {"sensor": "wrist", "force_N": 5, "approach_m_s": 0}})",
       "/force_offset/sensor",
       Code::kSensorSilent,
       {"wrist"},
       silent,
       true},
      {tree(first("v", R"("do": "set", "output": "valve", "value": {"sensor": "wrist"}, "factor": 0.1)")),
       "/commands/v/value",
       Code::kSensorSilent,
       {},
       silent},
      {R"({"do": "freedrive", "seconds": 1})",
       "",
       Code::kNotPossibleNow,
       {},
       [](int, ActivityCell& cell) { cell.backend->state().ready = false; }},
  };
}

}  // namespace takt::test
