// Steps and their keys, conditions: what is wrong with their form; and what only planning them shows.
#include "tests/core/activity/broken_rules.h"

namespace takt::test {
namespace {

std::string motion(const std::string& kind, const std::string& keys) {
  return R"({"do": ")" + kind + R"(", )" + keys + "}";
}
std::string home(const std::string& keys) { return motion("ptp", R"("to": "home", )" + keys); }
std::string wait_until(const std::string& condition) { return R"({"do": "wait", "until": )" + condition + "}"; }
std::string press(const std::string& keys) { return R"({"do": "press", "sensor": "wrist", )" + keys + "}"; }
std::string search(const std::string& keys) { return R"({"do": "search", "sensor": "wrist", )" + keys + "}"; }
std::string fit(const std::string& as, const std::string& free) {
  return R"({"do": "fit_pose", "object": "block", "contacts": [], "as": ")" + as + R"(", "free": )" + free + "}";
}
constexpr const char* kTouch = R"({"sensor": "wrist", "above_N": 5})";

std::vector<BrokenRule> motions() {
  const std::string guarded = std::string(R"("until": )") + kTouch;
  return {
      {R"({"do": "ptp"})", "", "key 'to' is missing", "\"home\" or an object"},
      {motion("ptp", R"("to": "hoem")"), "/to", "unexpected value \"hoem\"", "\"home\" or an object"},
      {motion("ptp", R"("to": {"in": "block"})"), "/to", "key 'position_m' is missing", "an array of 3 numbers"},
      {motion("ptp", R"("to": {"joints_deg": [0, 0]})"), "/to/joints_deg", "unexpected value [0,0]",
       "an array of 7 numbers"},
      {motion("lin", R"("to": {"by_m": [0, "up", 0]})"), "/to/by_m/1", "unexpected value \"up\"", "a number"},
      {motion("ptp",
              R"("to": {"in": "block", "position_m": [0, 0, 0], "rpy_deg": [0, 0, 0], "quaternion": [1, 0, 0, 0]})"),
       "/to", "both 'quaternion' and 'rpy_deg' are given", "one of the two"},
      {motion("ptp", R"("to": {"in": "block", "position_m": [0, 0, 0], "quaternion": [1, 1, 0, 0]})"), "/to/quaternion",
       "the norm is 1.41421", "a unit quaternion"},
      {home(R"("arm": "amr")"), "/arm", "unknown value 'amr'", "did you mean 'arm'?"},
      {home(R"("speed": 2)"), "/speed", "unexpected value 2", "a number above 0, at most 1"},
      {home(R"("velocity_m_s": 0.1)"), "/velocity_m_s", "unknown key 'velocity_m_s'", "allowed: "},
      {home(R"("blend_m": 0.1, "blend_fraction": 0.2)"), "/blend_fraction", "a blend by distance and by fraction",
       "one of them"},
      {home(R"("blend_m": 0.1, )" + guarded), "/blend_m", "a guarded motion is not blended", "without 'until'"},
      {home(R"("blend_m": 1e-9)"), "/blend_m", "unexpected value 1e-09", "a number of at least 1e-05"},
      {home(R"("name": "")"), "/name", "unexpected value \"\"", "a text that is not empty"},
      {home(R"("blend_fraction": 0.7)"), "/blend_fraction", "unexpected value 0.7", "a number from 0.0001 to 0.5"},
      {home(guarded + R"(, "on_end": "stop")"), "/on_end", "unknown value 'stop'", "allowed: fail, continue"},
      {home(R"("until": 5)"), "/until", "unexpected value 5", "an object {...}"},
      {motion("circ", R"("to": "home")"), "", "key 'via' is missing", "\"home\" or an object"},
      {motion("circ", R"("about": {"position_m": [0, 0, 0], "axis": [0, 0, 0], "angle_deg": 90})"), "/about/axis",
       "a direction of no length", "a vector that is not zero"},
      {motion("circ", R"("about": {"position_m": [0, 0, 0], "angle_deg": 90}, "orientation": "goal")"), "/orientation",
       "unknown value 'goal'", "allowed: fixed, tangential"},
      {motion("spline", R"("through": ["home"])"), "/through", "1 points", "from 2 to 200"},
      {motion("spline", R"("through": ["home", {"by_m": [0, 0, 0.1]}])"), "/through",
       "joint positions and poses in one spline", "points of one kind"},
      {motion("circ", R"("to": "home", "about": {"position_m": [0, 0, 0], "angle_deg": 90})"), "/to",
       "'to' and 'about'", "one of them"},
      {motion("lin", R"("to": "home", "on_end": "continue")"), "/on_end", "'on_end' without 'until'",
       "a guarded motion"},
      {motion("lin", R"("to": "home", "base_to": "home", "force_offset": {"force_N": 5})"), "/force_offset",
       "a motion with a base has no 'force_offset'", "two motions"},
      {R"({"do": "control_mode", "mode": "postion"})", "/mode", "unknown value 'postion'", "did you mean 'position'?"},
  };
}

std::vector<BrokenRule> forces() {
  return {
      {R"({"do": "press", "sensor": "foot"})", "/sensor", "'foot' is not on 'arm'", "a sensor on this arm"},
      {R"({"do": "press"})", "", "key 'sensor' is missing", "allowed: foot, wrist"},
      {press(R"("name": "")"), "/name", "unexpected value \"\"", "a text that is not empty"},
      {press(R"("direction": [0, 0, 1e300])"), "/direction", "a direction of length 1e+300", "at most 1e+09"},
      {press(R"("direction": [0, 0, 0])"), "/direction", "a direction of no length", "a vector that is not zero"},
      {press(R"("force_N": 5000)"), "/force_N", "unexpected value 5000", "a number from 0.1 to 1000"},
      {search(R"("radius_m": 0.01, "drop_m": 0.001)"), "", "key 'pitch_m' is missing", "a number from 1e-05 to 1"},
      {search(R"("radius_m": 0.1, "pitch_m": 0.0001, "drop_m": 0.001)"), "/pitch_m", "points for this radius",
       "a wider pitch: at most 199 points"},
      {search(R"("radius_m": 0.01, "pitch_m": 0.002)"), "", "no end condition is given", "'drop_m' or 'until'"},
      {R"({"do": "wipe", "sensor": "wrist", "in": "world", "width_m": 2, "pitch_m": 0.001})", "/pitch_m",
       "2001 lanes for this width", "a wider pitch: at most 100 lanes"},
      {R"({"do": "ptp", "to": "home", "unless": {"input": "button", "is": true}})", "/unless",
       "'unless' is called 'abort_if' now", "'abort_if'"},
      {R"({"do": "tare", "sensor": "writs"})", "/sensor", "unknown value 'writs'", "did you mean 'wrist'?"},
      {R"({"do": "tare", "sensor": "wrist", "cycles": 0.5})", "/cycles", "unexpected value 0.5",
       "a number from 1 to 100000, whole"},
      {R"({"do": "record_contact", "as": ""})", "/as", "unexpected value \"\"", "a text that is not empty"},
      {R"({"do": "record_contact", "as": 7})", "/as", "unexpected value 7", "a text"},
      {fit("arm", R"(["x"])"), "/as", "'arm' cannot be the name of an estimate", "a new name, or 'block'"},
      {fit("found", R"(["x", "w"])"), "/free/1", "unknown coordinate 'w'", "allowed: x, y, z, roll, pitch, yaw"},
      {fit("found", R"("x")"), "/free", "unexpected value \"x\"", "an array of texts"},
      {fit("found", R"(["x", 5])"), "/free/1", "unexpected value 5", "a text"},
  };
}

std::vector<BrokenRule> signals() {
  return {
      {R"({"do": "grip", "gripper": "grapper"})", "/gripper", "unknown value 'grapper'", "did you mean 'gripper'?"},
      {R"({"do": "grip", "part": "blok"})", "/part", "unknown value 'blok'", "did you mean 'block'?"},
      {R"({"do": "release", "force_N": 0})", "/force_N", "unexpected value 0", "a number above 0"},
      {R"({"do": "set", "value": true})", "", "key 'output' is missing", "allowed: driver, lamp, valve"},
      {R"({"do": "set", "output": "lamp", "value": 1})", "/value", "unexpected value 1", "true or false"},
      {R"({"do": "set", "output": "valve", "value": true})", "/value", "unexpected value true", "a number"},
      {R"({"do": "net", "net": "patinet"})", "/net", "unknown value 'patinet'", "did you mean 'patient'?"},
      {R"({"do": "wait"})", "", "neither a duration nor a condition is given", "'seconds' or 'until'"},
      {R"({"do": "wait", "until": {"input": "button"}, "seconds": 1})", "/seconds", "a time and a condition",
       "'timeout_s'"},
      {R"({"do": "wait", "seconds": 1, "timeout_s": 2})", "/timeout_s", "a timeout without a condition", "'until'"},
      {R"({"do": "wait", "until": "$true", "timeout_s": -1})", "/timeout_s", "unexpected value -1",
       "a number from 0 to 3600"},
      {wait_until(R"({"sensor": "wrist"})"), "/until", "exactly one threshold is needed", "'above_N' or 'below_N'"},
      {wait_until(R"({"sensor": "wrist", "above_N": 5, "below_N": 3})"), "/until", "exactly one threshold is needed",
       "'above_N' or 'below_N'"},
      {wait_until(R"({"sensor": "writs", "above_N": 5})"), "/until/sensor", "there is no force/torque sensor 'writs'",
       "did you mean 'wrist'?"},
      {wait_until(R"({"sensor": "wrist", "quantity": "weight", "above_N": 5})"), "/until/quantity",
       "unknown value 'weight'", "allowed: force, force_x"},
      {wait_until(R"({"input": "buton"})"), "/until/input", "there is no input 'buton'", "did you mean 'button'?"},
      {wait_until(R"({"gripper": "gripper", "is": "shut"})"), "/until/is", "unknown value 'shut'",
       "allowed: holding, lost"},
      {wait_until(R"({"all": []})"), "/until/all", "no condition is given", "at least one"},
      {wait_until(R"({"not": 5})"), "/until/not", "unexpected value 5", "an object {...}"},
  };
}

}  // namespace

std::vector<BrokenRule> broken_steps() {
  std::vector<BrokenRule> all;
  for (const auto& some : {motions(), forces(), signals()}) all.insert(all.end(), some.begin(), some.end());
  return all;
}

std::vector<BrokenRule> broken_plans() {
  return {
      {motion("ptp", R"("to": {"in": "block", "position_m": [0, 0, 3]})"), "/to", "the goal is out of reach: flange at",
       "a pose that some joint configuration inside the limits reaches"},
      {motion("ptp", R"("to": {"joints_deg": [0, 0, 0, 170, 0, 0, 0]})"), "/to",
       "joint 'a3': 2.96706 is outside its range", "from -2.0944 to 2.0944"},
      {motion("lin", R"("to": {"in": "nowhere", "position_m": [0, 0, 0]})"), "/to", "there is no frame 'nowhere'",
       "allowed: world"},
      {motion("lin", R"("to": {"by_m": [0, 0, 0.1]}, "base_to": "home")"), "/arm", "'arm' stands on no base",
       "an arm that is mounted \"on\" a base"},
      {R"_({"do": "log", "text": "$text(pose('nowhere'))"})_", "/text", "there is no frame 'nowhere'", "pose('frame')"},
      {R"({"do": "sequence", "steps": [{"do": "ptp", "to": "home"}, {"do": "record_contact", "as": "c"}]})", "/steps/1",
       "the last motion of 'arm' was not guarded, so there is no contact", "a motion with \"until\""},
      {R"({"do": "fit_pose", "object": "block", "contacts": ["tpo"], "as": "found 1", "free": ["x"]})", "/contacts/0",
       "no contact 'tpo' is recorded before this", "there are none"},
      {R"({"do": "fit_pose", "object": "block", "contacts": ["c"], "as": "found 2", "free": ["x", "y"]})", "/contacts",
       "1 contacts for 2 free coordinates", "at least one contact a coordinate"},
      {R"({"do": "grip", "width_m": 0.5})", "/width_m", "0.5 is not for 'gripper'", "0 to 0.11"},
      {R"({"do": "set", "output": "valve", "value": 11})", "/value", "11 V is not for 'valve'", "0 to 10 V"},
      {R"({"do": "parallel", "branches": [{"do": "ptp", "to": "home"}, {"do": "tare", "sensor": "wrist", "cycles": 1},
          {"do": "lin", "to": {"by_m": [0, 0, 0.01]}}]})",
       "/branches/2", "'arm' is driven here and in branch 0 at the same time", "a device in one branch only"},
      {R"({"do": "net", "net": "no such arm"})", "/net", "in the net of this step, /primitives/", "arm"},
  };
}

}  // namespace takt::test
