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
      {R"({"do": "transaction"})", "", "key 'commands' is missing", "an object {...}"},
      {tree(R"("a": 3)"), "/commands/a", "unexpected value 3", "an object {...}"},
      {tree(R"("a": {"seconds": 1})"), "/commands/a/do", "'do' is missing", "allowed: circ, follow"},
      {tree(first("a", R"("do": "prses")")), "/commands/a/do", "there is no command 'prses'", "did you mean 'press'?"},
      {tree(first("a/b", R"("do": "wait", "seconds": 1)")), "/commands/a~1b", "a command named 'a/b'", "has no '/'"},
      {tree(first("a", kDriver + R"(, "name": "b")")), "/commands/a/name", "a second name: \"b\"", "'a' is its name"},
      {tree(R"("a": {"start": 1, )" + kDriver + "}"), "/commands/a/start", "unexpected value 1", "true or false"},
      {R"({"do": "hold", "seconds": 1, "start": true})", "/start", "a step of its own has no 'start'",
       "inside of a transaction"},
      {tree(first("a", kDriver), R"(, "capture": {"x": {}})"), "/capture/x", "key 'value' is missing",
       "an object {...}"},
      {tree(first("a", kDriver), R"(, "capture": {"x": {"value": {"speed": "arm"}, "when": {"started": "a"},
                                                        "rate_Hz": 10}})"),
       "/capture/x/rate_Hz", "a rate for a value that is captured once", "'rate_Hz', or 'when'"},
      {tree(first("a", kDriver), R"(, "capture": {"x": {"value": {"progress": "b"}}})"), "/capture/x/value/progress",
       "C6: there is no command 'b' in 'transaction'", "allowed: transaction, a"},
      {tree(first("a", kDriver), R"(, "on_cancel": "never")"), "/on_cancel", "unknown value 'never'",
       "allowed: forward, ignore"},
      {tree(first("a", kDriver), R"(, "on_cancel": ["b"])"), "/on_cancel/0", "C6: there is no command 'b'",
       "allowed: transaction, a"},
  };
}

std::vector<BrokenRule> events() {
  const std::string none = R"("cancel": "a")";
  return {
      {tree(first("a", kDriver), R"(, "on": 5)"), "/on", "unexpected value 5", "an array of event handlers"},
      {on("{" + none + "}"), "/on/0", "exactly one event is needed", "'entered' or 'left' with a state"},
      {on(R"({"entered": {"completed": "a"}, "left": {"completed": "a"}, )" + none + "}"), "/on/0",
       "exactly one event is needed", "'entered' or 'left' with a state"},
      {on(R"({"entered": {"completed": "a"}})"), "/on/0", "the event handler has no effect",
       "start, stop, cancel, raise, tell"},
      {then(R"("cancel": {})"), "/on/0/cancel", "unexpected value {}", "a name, or several"},
      {then(R"("stop": [5])"), "/on/0/stop/0", "unexpected value 5", "a name"},
      {then(R"("start": "b")"), "/on/0/start", "C6: there is no command 'b' in 'transaction'", "allowed:"},
      {then(R"("raise": "lost")"), "/on/0/raise", "C10: no transaction has the raised state 'lost'",
       "'raised' of a transaction"},
      {then(R"("tell": 5)"), "/on/0/tell", "unexpected value 5", "a text"},
      {then(R"("tell": "")"), "/on/0/tell", "an empty text", "what is told"},
      {then(R"("tell": "it is done", "after_s": -1)"), "/on/0/after_s", "unexpected value -1",
       "a number from 0 to 3600"},
      {when("{}"), "/on/0/entered", "no state is given", "a condition over sensors"},
      {when(R"({"any": []})"), "/on/0/entered/any", "no state is given", "at least one"},
      {when(R"({"completed": "b"})"), "/on/0/entered/completed", "C6: there is no command 'b'", "allowed:"},
      {when(R"({"raised": "lost"})"), "/on/0/entered/raised", "C10: no transaction has the raised state 'lost'",
       "'raised' of a transaction"},
      {when(R"({"action": "a", "at_path": 2})"), "/on/0/entered/at_path", "unexpected value 2", "a number from 0 to 1"},
      {when(R"({"actuator": "amr", "is": "completed"})"), "/on/0/entered/actuator", "unknown value 'amr'",
       "did you mean 'arm'?"},
      {when(R"({"channel": "speed"})"), "/on/0/entered/channel", "'speed' carries Real", "a Boolean channel with 'is'"},
  };
}

std::vector<BrokenRule> motions() {
  const std::string to_home = R"("do": "ptp", "to": "home")";
  const auto several = [](const std::string& steps) {
    return tree(first("m", R"("do": "motions", "steps": [)" + steps + "]"));
  };
  const std::string blended = "{" + kUp + R"(, "blend_m": 0.01})";
  return {
      {several(""), "/commands/m/steps", "no motion is given", "one at least"},
      {several(blended + R"(, {"do": "hold", "seconds": 1})"), "/commands/m/steps/1/do",
       "\"hold\" is not a planned motion", "ptp, lin, circ or spline"},
      {several("{" + kUp + R"(, "blend_m": 0.01, "until": )" + kHard + "}, {" + to_home + "}"),
       "/commands/m/steps/0/until", "only the last of them may be guarded", "on the last"},
      {several("{" + kUp + "}, {" + to_home + "}"), "/commands/m/steps/0", "a motion that is not blended into the next",
       "on all but the last"},
      {several("{" + kUp + R"(, "blend_m": 0.01, "base_to": "home"}, {)" + to_home + "}"),
       "/commands/m/steps/0/base_to", "a motion with a base is not blended", "a 'lin' of its own"},
      {tree(first("m", kUp + R"(, "base_to": "home", "force_offset": {"force_N": 5})")), "/commands/m/force_offset",
       "a motion with a base has no 'force_offset'", "two motions"},
      {tree(first("m", kUp + R"(, "base_to": "home", "weave": {"amplitude_m": 0.002, "frequency_Hz": 2})")),
       "/commands/m/weave", "a motion with a base has no 'weave'", "two motions"},
      {"{" + kUp + R"(, "base_to": {"by_m": 1}})", "/base_to/by_m", "unexpected value 1", "3 numbers"},
  };
}

std::vector<BrokenRule> following() {
  const auto valve = [](const std::string& keys) {
    return tree(first("v", R"("do": "set", "output": "valve", )" + keys));
  };
  const std::string felt = R"("value": {"sensor": "wrist"}, "factor": 0.1)";
  return {
      {valve(R"("value": {})"), "/commands/v/value", "key 'sensor' is missing", "allowed: foot, wrist"},
      {valve(R"("value": {"sensor": "wirst"})"), "/commands/v/value/sensor", "unknown value 'wirst'",
       "did you mean 'wrist'?"},
      {valve(R"("value": {"speed": "amr"})"), "/commands/v/value/speed", "unknown value 'amr'", "allowed: arm"},
      {valve(R"("value": {"input": "button"})"), "/commands/v/value/input", "'button' is true or false",
       "an analog input"},
      {valve(R"("value": {"channel": "enable"}, "factor": 1)"), "/commands/v/value/channel",
       "'enable' is a channel of Boolean", "a channel of Real"},
      {valve(R"("value": {"progress": "b"}, "factor": 1)"), "/commands/v/value/progress",
       "C6: there is no command 'b' in 'transaction'", "allowed: transaction, v"},
      {valve(felt + R"(, "seconds": -1)"), "/commands/v/seconds", "unexpected value -1", "a number from 0 to 3600"},
      {valve(felt + R"(, "offset": "much")"), "/commands/v/offset", "unexpected value \"much\"", "a number"},
      {valve(felt + R"(, "until": {"input": "buton"})"), "/commands/v/until/input", "there is no input 'buton'",
       "did you mean 'button'?"},
      {valve(R"("value": 1, "factor": 2)"), "/commands/v/factor", "'factor' without a value to follow",
       "an analog output whose 'value' is an object"},
      {tree(first("d", R"("do": "set", "output": "driver", "value": {"input": "button"})")), "/commands/d/value",
       "unexpected value", "true or false"},
  };
}

std::vector<BrokenRule> online() {
  const std::string held = R"("while": {"channel": "enable"})";
  return {
      {R"({"do": "jog", )" + held + "}", "", "no velocity is given", "'channel', 'linear_m_s' or 'angular_deg_s'"},
      {R"({"do": "jog", "channel": "stick"})", "", "key 'while' is missing", "an object {...}"},
      {R"({"do": "jog", "channel": "stcik", )" + held + "}", "/channel", "there is no channel 'stcik'",
       "did you mean 'stick'?"},
      {R"({"do": "jog", "channel": "speed", )" + held + "}", "/channel", "'speed' carries Real",
       "a channel of type Twist"},
      {R"({"do": "jog", "channel": "stick", "while": {"channel": "enabel"}})", "/while/channel",
       "there is no channel 'enabel'", "did you mean 'enable'?"},
      {R"({"do": "jog", "channel": "stick", "linear_max_m_s": 0, )" + held + "}", "/linear_max_m_s",
       "unexpected value 0", "a number above 0"},
      {R"({"do": "jog", "channel": "stick", "linear_m_s": [0, 0, 0.1], )" + held + "}", "/linear_m_s",
       "a velocity from a channel and a velocity", "one of them"},
      {R"({"do": "follow"})", "/in", "nothing to follow is given", "'in' (a frame), or 'channel'"},
      {R"({"do": "follow", "in": "world", "until": {"input": "buton"}})", "/until/input", "there is no input 'buton'",
       "did you mean 'button'?"},
      {R"({"do": "hold", "seconds": -1})", "/seconds", "unexpected value -1", "a number from 0 to 3600"},
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
      {over(R"("weave": 5)"), "/weave", "unexpected value 5", "an object {...}"},
      {over(R"("weave": {"frequency_Hz": 2})"), "/weave", "key 'amplitude_m' is missing", "a number above 0"},
      {over(weave + R"(, "direction": [0, 0, 0]})"), "/weave/direction", "a direction of no length",
       "a vector that is not zero"},
      {over(weave + "}, " + offset + "}"), "/force_offset", "a weave and a force offset", "one of them"},
      {R"({"do": "ptp", "to": "home", "weave": {"amplitude_m": 0.002, "frequency_Hz": 2}})", "/weave",
       "C8: PTP moves joints, so there is no Cartesian path to weave about", "a Cartesian motion"},
      {over(R"("force_offset": {"sensor": "foot", "force_N": 5})"), "/force_offset/sensor", "'foot' is not on 'arm'",
       "a sensor on this arm"},
      {over(R"("force_offset": {"sensor": "wrist", "force_N": 0})"), "/force_offset/force_N", "unexpected value 0",
       "a number from 0.1 to 1000"},
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
      {soft("5"), "/compliance", "unexpected value 5", "an object {...}"},
      {soft("{}"), "/compliance", "key 'mode' is missing", "joint_impedance"},
      {soft(R"({"mode": "impedance"})"), "/compliance/mode", "unknown value 'impedance'", "joint_impedance"},
      {soft(R"({"mode": "position", "stiffness_Nm_rad": 100})"), "/compliance/stiffness_Nm_rad",
       "unknown key 'stiffness_Nm_rad'", ""},
      {"{" + kUp + ", " + kSprings + R"(, "stiffness_N_m": 300}})", "/compliance/stiffness_N_m",
       "unknown key 'stiffness_N_m'", "stiffness_Nm_rad"},
      {soft(R"({"mode": "cartesian_impedance", "stiffness_N_m": [1, 2]})"), "/compliance/stiffness_N_m", "[1,2]",
       "3 numbers"},
      {soft(R"({"mode": "cartesian_impedance", "axes": "world"})"), "/compliance/axes", "unknown value 'world'",
       "allowed: base, tool"},
      {tree(first(
           "m", R"("do": "motions", "steps": [{)" + kUp + R"(, "blend_m": 0.01}, {)" + kUp + ", " + kSprings + "}}]")),
       "/commands/m/steps/1/compliance", "one motion of several has another compliance", "beside 'steps'"},
  };
}

std::vector<BrokenRule> freedrive() {
  return {
      {R"({"do": "freedrive"})", "", "no end condition is given", "'until' or 'seconds'"},
      {R"({"do": "freedrive", "seconds": 1, "enabled": {"input": "buton"}})", "/enabled/input",
       "there is no input 'buton'", "did you mean 'button'?"},
      {R"({"do": "freedrive", "seconds": 1, "velocity_m_s": 0})", "/velocity_m_s", "unexpected value 0",
       "a number above 0"},
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
      {tree(""), "", "C9: nothing starts in 'transaction'", "\"start\": true"},
      {tree(first("a", wait) + ", " + later("b", kDriver)), "/commands/b", "C9: nothing ever starts 'b'",
       "\"start\": true"},
      {tree(first("a", wait), R"(, "on": [{"entered": {"action": "a", "is": "error"}, "cancel": "a"}])"), "/on/0",
       "C8: 'a' is not an action, so it has no state 'error'", "completed, stopped, cancelled of a command"},
      {tree(first("a", wait), R"(, "capture": {"x": {"value": {"progress": "a"}}})"), "/capture/x",
       "C8: 'a' is not a motion", "a motion"},
      {tree(first("press", kUp + R"(, "until": )" + kHard) + ", " + later("on", kUp),
            R"(, "on": [{"entered": {"completed": "press"}, "start": "on"}])"),
       "/commands/on", "the position of 'arm' when 'on' begins is unknown before the run", "not cancelled"},
      {tree(first("m", kUp + R"(, "blend_m": 0.01)") + ", " + first("w", wait)), "/commands/m",
       "'m' cannot be left for the motion after the transaction", "or no blend"},
      {tree(first("g", R"("do": "grip", "width_m": 0.3)")), "/commands/g/width_m", "0.3 is not for 'gripper'",
       "0 to 0.11"},
      {tree(first("v", R"("do": "set", "output": "valve", "value": 11)")), "/commands/v/value",
       "11 V is not for 'valve'", "0 to 10 V"},
      {tree(first("v", R"("do": "set", "output": "valve", "value": {"sensor": "wrist"})")), "/commands/v/value",
       "a value in N is not for 'valve', which is in V", "'factor', in V for each N"},
      {R"({"do": "set", "output": "valve", "value": {"speed": "arm"}, "seconds": 1})", "/value",
       "a value in m/s is not for 'valve', which is in V", "'factor', in V for each m/s"},
      {tree(first("w", wait) + ", " +
            first("v", R"("do": "set", "output": "valve", "value": {"progress": "w"}, "factor": 10)")),
       "/commands/v", "C8: 'w' is not a motion", "a motion"},
      {tree(first("w", kDriver) + ", " +
            first("v", R"("do": "set", "output": "valve", "value": {"progress": "w"}, "factor": 10)")),
       "/commands/v", "C8: set value has no state 'progress'", "it offers"},
      {tree(first("m", kUp + R"(, "base_to": "home")")), "/commands/m/arm", "'arm' stands on no base",
       "an arm that is mounted \"on\" a base"},
      {R"({"do": "jog", "channel": "stick", "in": "nowhere", "while": {"channel": "enable"}})", "",
       "there is no frame 'nowhere'", "allowed: "},
      {blended(kOffset5, R"(, "force_offset": {"sensor": "wrist", "force_N": 6})"), "/steps/0/force_offset",
       "does not go on in 'b'", "the same 'force_offset' at both, or no blend"},
      {blended(R"(, "weave": {"amplitude_m": 0.001, "frequency_Hz": 2})", kOffset5), "/steps/0/weave", "a weave of 'a'",
       "one of them, or no blend"},
      {"{" + kUp + R"(, "weave": {"amplitude_m": 0.1, "frequency_Hz": 50}})", "", "a weave with an acceleration of",
       "a smaller amplitude or frequency"},
      {"{" + kUp + R"(, "weave": {"amplitude_m": 0.002, "frequency_Hz": 2, "ramp_s": 0.02}})", "/weave/ramp_s",
       "a weave that grows or fades in 0.02 s", "a ramp of 0."},
      {"{" + kUp + ", " + kSprings + "}}", "/compliance",
       "'arm' will be in mode position, and this needs joint_impedance", "the step \"control_mode\""},
      {"{" + kUp + R"(, "until": )" + kHard + ", " + kSprings + R"(, "stiffness_Nm_rad": 2500}})",
       "/compliance/stiffness_Nm_rad/6", "2500 Nm/rad for 'arm'", "0 to 2000 Nm/rad"},
      {"{" + kUp + ", " + kSprings + R"(, "damping_ratio": [1, 1]}})", "/compliance/damping_ratio",
       "2 values for 'arm'", "7 values"},
      {R"({"do": "hold", "seconds": 1, "compliance": {"mode": "cartesian_impedance", "torque_Nm": [0, 0, 20]}})",
       "/compliance/torque_Nm/2", "20 N, Nm for 'arm'", "-10 to 10"},
      {tree(first("h", R"("do": "hold", "seconds": 1, )" + kSprings + "}")), "/commands/h/compliance",
       "'arm' will be in mode position, and this needs joint_impedance", "the step \"control_mode\""},
      {"{" + kPress + ", " + kSprings + "}}", "/compliance",
       "'arm' will be in mode position, and this needs joint_impedance", "the step \"control_mode\""},
      {"{" + kPress + ", " + kSprings + R"(, "stiffness_Nm_rad": 2500}})", "/compliance/stiffness_Nm_rad/6",
       "2500 Nm/rad for 'arm'", "0 to 2000 Nm/rad"},
      {tree(first("p", kPress + ", " + kSprings + R"(, "damping_ratio": [1, 1]})")),
       "/commands/p/compliance/damping_ratio", "2 values for 'arm'", "7 values"},
      {in_springs_of_the_tool("{" + kPress + ", " + kSoft + "0}}"), "/steps/1/force_N",
       "the tool has no stiffness along the direction", "a stiffness above 0"},
      {in_springs_of_the_tool("{" + kPress + ", " + kSoft + "100}}"), "/steps/1/travel_m",
       "10 N bend the springs by 0.1 m, and the tool is sent by 0.05 m at most", "a longer travel, stiffer springs"},
      {in_springs_of_the_tool(tree(first("p", kPress + ", " + kSoft + "100}"))), "/steps/1/commands/p/travel_m",
       "10 N bend the springs by 0.1 m", "a part of the force beside them"},
      {"{" + kUp + R"(, "force_offset": {"sensor": "wrist", "force_N": 5, "acceleration_max_m_s2": 10}})", "",
       "the offset may need 10 of the acceleration of the tool", "smaller bounds of the offset"},
  };
}

std::vector<BrokenRun> broken_transaction_runs() {
  const auto silent = [](int cycle, ActivityCell& cell) { cell.sensor->silent = cycle >= 300; };
  const auto pushed = [](int cycle, ActivityCell& cell) { cell.extra.force.x() = cycle >= 300 ? 1000.0 : 0.0; };
  const std::string press = kPress + R"(, "approach_m_s": 0.01)";
  const std::string wait = R"("do": "wait", "until": )" + kHard;
  return {
      {tree(first("w", wait + R"(, "timeout_s": 0.02)")), "/commands/w/until",
       "the condition did not hold within 0.02 s", "a longer \"timeout_s\""},
      {tree(first("w", wait + R"(, "timeout_s": 0.5)")), "/commands/w/until",
       "a sensor of the condition did not answer", "its power", silent},
      {tree(first("g", R"("do": "grip")")), "/commands/g", "no part was found; the fingers stand 40.0 mm apart",
       "\"expect\": \"any\"",
       [](int cycle, ActivityCell& cell) {
         if (cycle >= 10) cell.fingers->answer(device::GripperState::kIdle, 0.04);
       }},
      {tree(first("m", kUp + R"(, "until": )" + kHard)),
       "/commands/m/until",
       "the motion reached its end and the condition never held",
       "\"on_end\": \"continue\"",
       {},
       true},
      {tree(first("m", kUp + R"(, "until": )" + kHard)), "/commands/m/until",
       "a sensor of the condition did not answer, so the arm stopped on its path", "its power", silent, true},
      {tree(first("m", kUp + R"(, "abort_if": )" + kHard)), "/commands/m/abort_if",
       "'abort_if' became true, so the arm stopped on its path", "what made it hold", pushed, true},
      {tree(first("m", kUp + R"(, "abort_if": )" + kHard)), "/commands/m/abort_if",
       "a sensor of the condition did not answer, so the arm stopped on its path", "its power", silent, true},
      {"{" + kUp + R"(, "abort_if": )" + kHard + R"(, "weave": {"amplitude_m": 0.001, "frequency_Hz": 2}})",
       "/abort_if", "'abort_if' became true, so the arm stopped on its path", "what made it hold", pushed, true},
      {R"({"do": "sequence", "steps": [{"do": "tare", "sensor": "wrist", "cycles": 20}, )" +
           tree(first("p", press + R"(, "travel_m": 0.005)")) + "]}",
       "/steps/1/commands/p/travel_m",
       "nothing was touched",
       "a longer travel",
       {},
       true},
      {tree(first("p", press + R"(, "travel_m": 0.005)")),  // what hangs there is taken for a touch
       "/commands/p/travel_m",
       "the travel was used up after the touch",
       "a longer travel",
       {},
       true},
      {tree(first("m", kUp)), "", "was stopped in cycle", "\"try\" around the step",
       [](int cycle, ActivityCell& cell) { cell.backend->silent = cycle >= 200; }, true},
      {tree(first("p", press)), "/commands/p/sensor", "'wrist' did not answer, so the arm stopped", "its power", silent,
       true},
      {"{" + kUp + R"(, "force_offset": {"sensor": "wrist", "force_N": 5, "approach_m_s": 0}})", "/force_offset/sensor",
       "'wrist' did not answer, so the arm stopped on its path", "its power", silent, true},
      {tree(first("v", R"("do": "set", "output": "valve", "value": {"sensor": "wrist"}, "factor": 0.1)")),
       "/commands/v/value", "what the output follows did not answer, so it stayed where it was", "its power", silent},
      {R"({"do": "freedrive", "seconds": 1})", "", "the mode was not changed: ", "an arm that stands",
       [](int, ActivityCell& cell) { cell.backend->state().ready = false; }},
  };
}

}  // namespace takt::test
