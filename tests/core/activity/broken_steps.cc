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
      {R"({"do": "ptp"})", "", Code::kMissing, {"to", "home"}},
      {motion("ptp", R"("to": "hoem")"), "/to", Code::kWrongType, {"hoem", "home"}},
      {motion("ptp", R"("to": {"home": false})"), "/to/home", Code::kInvalidValue},
      {motion("ptp", R"("to": {"in": "block"})"), "/to", Code::kMissing, {"position_m", "3"}},
      {motion("ptp", R"("to": {"joints_deg": [0, 0]})"), "/to/joints_deg", Code::kWrongType, {"0", "7"}},
      {motion("lin", R"("to": {"by_m": [0, "up", 0]})"), "/to/by_m/1", Code::kWrongType, {"up"}},
      {motion("ptp",
              R"("to": {"in": "block", "position_m": [0, 0, 0], "rpy_deg": [0, 0, 0], "quaternion": [1, 0, 0, 0]})"),
       "/to",
       Code::kConflict,
       {"quaternion", "rpy_deg"}},
      {motion("ptp", R"("to": {"in": "block", "position_m": [0, 0, 0], "quaternion": [1, 1, 0, 0]})"),
       "/to/quaternion",
       Code::kOutOfRange,
       {"1.41421"}},
      {home(R"("arm": "amr")"), "/arm", Code::kUnknownName, {"amr", "arm"}},
      {home(R"("speed": 2)"), "/speed", Code::kOutOfRange, {"2", "0", "1"}},
      {home(R"("velocity_m_s": 0.1)"), "/velocity_m_s", Code::kUnknownKey, {"velocity_m_s"}},
      {home(R"("blend_m": 0.1, "blend_fraction": 0.2)"), "/blend_fraction", Code::kConflict},
      {home(R"("blend_m": 0.1, )" + guarded), "/blend_m", Code::kConflict, {"until"}},
      {home(R"("blend_m": 1e-9)"), "/blend_m", Code::kOutOfRange, {"1e-09", "1e-05"}},
      {home(R"("name": "")"), "/name", Code::kWrongType},
      {home(R"("blend_fraction": 0.7)"), "/blend_fraction", Code::kOutOfRange, {"0.7", "0.0001", "0.5"}},
      {home(guarded + R"(, "on_end": "stop")"), "/on_end", Code::kUnknownName, {"stop"}},
      {home(R"("until": 5)"), "/until", Code::kWrongType, {"5"}},
      {motion("circ", R"("to": "home")"), "", Code::kMissing, {"via", "home"}},
      {motion("circ", R"("about": {"position_m": [0, 0, 0], "axis": [0, 0, 0], "angle_deg": 90})"), "/about/axis",
       Code::kOutOfRange},
      {motion("circ", R"("about": {"position_m": [0, 0, 0], "angle_deg": 90}, "orientation": "goal")"),
       "/orientation",
       Code::kUnknownName,
       {"goal"}},
      {motion("spline", R"("through": ["home"])"), "/through", Code::kWrongSize, {"1", "2", "200"}},
      {motion("spline", R"("through": ["home", {"by_m": [0, 0, 0.1]}])"), "/through", Code::kConflict},
      {motion("circ", R"("to": "home", "about": {"position_m": [0, 0, 0], "angle_deg": 90})"),
       "/to",
       Code::kConflict,
       {"to", "about"}},
      {motion("lin", R"("to": "home", "on_end": "continue")"), "/on_end", Code::kConflict, {"on_end", "until"}},
      {motion("lin", R"("to": "home", "base_to": "home", "force_offset": {"force_N": 5})"),
       "/force_offset",
       Code::kConflict,
       {"force_offset"}},
      {R"({"do": "control_mode", "mode": "postion"})", "/mode", Code::kUnknownName, {"postion", "position"}},
  };
}

std::vector<BrokenRule> forces() {
  return {
      {R"({"do": "press", "sensor": "foot"})", "/sensor", Code::kConflict, {"foot", "arm"}},
      {R"({"do": "press"})", "", Code::kMissing, {"sensor"}},
      {press(R"("name": "")"), "/name", Code::kWrongType},
      {press(R"("direction": [0, 0, 1e300])"), "/direction", Code::kOutOfRange},
      {press(R"("direction": [0, 0, 0])"), "/direction", Code::kOutOfRange},
      {press(R"("force_N": 5000)"), "/force_N", Code::kOutOfRange, {"5000", "0.1", "1000"}},
      {search(R"("radius_m": 0.01, "drop_m": 0.001)"), "", Code::kMissing, {"pitch_m", "1e-05", "1"}},
      {search(R"("radius_m": 0.1, "pitch_m": 0.0001, "drop_m": 0.001)"), "/pitch_m", Code::kTooLarge, {"199"}},
      {search(R"("radius_m": 0.01, "pitch_m": 0.002)"), "", Code::kMissing, {"drop_m", "until"}},
      {search(R"("radius_m": 0.01, "pitch_m": 0.002, "drop_m": 0.002, "depth_max_m": 0.001)"),
       "/depth_max_m",
       Code::kConflict,
       {"0.001", "0.002", "drop_m"}},
      {R"({"do": "wipe", "sensor": "wrist", "in": "world", "width_m": 2, "pitch_m": 0.001})",
       "/pitch_m",
       Code::kTooLarge,
       {"2001", "100"}},
      {R"({"do": "ptp", "to": "home", "unless": {"input": "button", "is": true}})",
       "/unless",
       Code::kUnknownKey,
       {"unless", "abort_if"}},
      {R"({"do": "tare", "sensor": "writs"})", "/sensor", Code::kUnknownName, {"writs", "wrist"}},
      {R"({"do": "tare", "sensor": "wrist", "cycles": 0.5})", "/cycles", Code::kOutOfRange, {"0.5", "1", "100000"}},
      {R"({"do": "record_contact", "as": ""})", "/as", Code::kWrongType},
      {R"({"do": "record_contact", "as": 7})", "/as", Code::kWrongType, {"7"}},
      {fit("arm", R"(["x"])"), "/as", Code::kInvalidName, {"arm", "block"}},
      {fit("found", R"(["x", "w"])"), "/free/1", Code::kUnknownName, {"w"}},
      {fit("found", R"("x")"), "/free", Code::kWrongType, {"x"}},
      {fit("found", R"(["x", 5])"), "/free/1", Code::kWrongType, {"5"}},
  };
}

std::vector<BrokenRule> signals() {
  return {
      {R"({"do": "grip", "gripper": "grapper"})", "/gripper", Code::kUnknownName, {"grapper", "gripper"}},
      {R"({"do": "grip", "part": "blok"})", "/part", Code::kUnknownName, {"blok", "block"}},
      {R"({"do": "release", "force_N": 0})", "/force_N", Code::kOutOfRange, {"0"}},
      {R"({"do": "set", "value": true})", "", Code::kMissing, {"output"}},
      {R"({"do": "set", "output": "lamp", "value": 1})", "/value", Code::kWrongType, {"1"}},
      {R"({"do": "set", "output": "valve", "value": true})", "/value", Code::kOutOfRange},
      {R"({"do": "net", "net": "patinet"})", "/net", Code::kUnknownName, {"patinet", "patient"}},
      {R"({"do": "wait"})", "", Code::kMissing, {"seconds", "until"}},
      {R"({"do": "wait", "until": {"input": "button"}, "seconds": 1})", "/seconds", Code::kConflict, {"timeout_s"}},
      {R"({"do": "wait", "seconds": 1, "timeout_s": 2})", "/timeout_s", Code::kConflict, {"until"}},
      {R"({"do": "wait", "until": "$true", "timeout_s": -1})", "/timeout_s", Code::kOutOfRange, {"-1", "0", "3600"}},
      {wait_until(R"({"sensor": "wrist"})"), "/until", Code::kConflict, {"above_N", "below_N"}},
      {wait_until(R"({"sensor": "wrist", "above_N": 5, "below_N": 3})"),
       "/until",
       Code::kConflict,
       {"above_N", "below_N"}},
      {wait_until(R"({"sensor": "writs", "above_N": 5})"), "/until/sensor", Code::kUnknownName, {"writs", "wrist"}},
      {wait_until(R"({"sensor": "wrist", "quantity": "weight", "above_N": 5})"),
       "/until/quantity",
       Code::kUnknownName,
       {"weight", "force_x"}},
      {wait_until(R"({"input": "buton"})"), "/until/input", Code::kUnknownName, {"buton", "button"}},
      {wait_until(R"({"gripper": "gripper", "is": "shut"})"), "/until/is", Code::kUnknownName, {"shut"}},
      {wait_until(R"({"all": []})"), "/until/all", Code::kMissing},
      {wait_until(R"({"not": 5})"), "/until/not", Code::kWrongType, {"5"}},
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
      {motion("ptp", R"("to": {"in": "block", "position_m": [0, 0, 3]})"), "/to", Code::kUnreachable},
      {motion("ptp", R"("to": {"joints_deg": [0, 0, 0, 170, 0, 0, 0]})"),
       "/to",
       Code::kOutOfRange,
       {"a3", "170", "-120", "120"}},
      {motion("lin", R"("to": {"in": "nowhere", "position_m": [0, 0, 0]})"), "/to", Code::kUnknownName, {"nowhere"}},
      {motion("lin", R"("to": {"by_m": [0, 0, 0.1]}, "base_to": "home")"), "/arm", Code::kRequires, {"arm", "on"}},
      {R"_({"do": "log", "text": "$text(pose('nowhere'))"})_", "/text", Code::kTypeMismatch, {"nowhere", "frame"}},
      {R"({"do": "sequence", "steps": [{"do": "ptp", "to": "home"}, {"do": "record_contact", "as": "c"}]})",
       "/steps/1",
       Code::kRequires,
       {"arm", "until"}},
      {R"({"do": "fit_pose", "object": "block", "contacts": ["tpo"], "as": "found 1", "free": ["x"]})",
       "/contacts/0",
       Code::kUnknownName,
       {"tpo"}},
      {R"({"do": "fit_pose", "object": "block", "contacts": ["c"], "as": "found 2", "free": ["x", "y"]})",
       "/contacts",
       Code::kWrongSize,
       {"1", "2"}},
      {R"({"do": "grip", "width_m": 0.5})", "/width_m", Code::kOutOfRange, {"gripper", "0.5", "0", "0.11"}},
      {R"({"do": "set", "output": "valve", "value": 11})", "/value", Code::kOutOfRange, {"valve", "11", "0", "10"}},
      {R"({"do": "parallel", "branches": [{"do": "ptp", "to": "home"}, {"do": "tare", "sensor": "wrist", "cycles": 1},
          {"do": "lin", "to": {"by_m": [0, 0, 0.01]}}]})",
       "/branches/2",
       Code::kResourceConflict,
       {"arm", "0"}},
      {R"({"do": "net", "net": "no such arm"})", "/net", Code::kUnknownName},
  };
}

}  // namespace takt::test
