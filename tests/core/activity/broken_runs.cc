// What only the run can tell: values that are not there, what the world does not do.
#include "tests/core/activity/broken_rules.h"

namespace takt::test {
namespace {

std::string declared(const std::string& variables, const std::string& steps) {
  return R"({"do": "sequence", "variables": {)" + variables + R"(}, "steps": [)" + steps + "]}";
}
std::string steps(const std::string& all) { return R"({"do": "sequence", "steps": [)" + all + "]}"; }
std::string log(const std::string& text) { return R"({"do": "log", "text": ")" + text + "\"}"; }

constexpr const char* kUnknown = R"("x": {"unit": "s", "nominal": 0.1})";
constexpr const char* kUnknownList = R"("all": {"type": "list of number", "nominal": [1]})";
constexpr const char* kSlowlyUp = R"({"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "velocity_m_s": 0.05, "until": )";

std::vector<BrokenRun> values() {
  return {
      {declared(kUnknown, R"({"do": "wait", "seconds": "$x"})"), "/steps/0", Code::kNotKnownYet, {"x"}},
      {declared(R"("n": {"type": "number", "nominal": 2})", R"({"do": "repeat", "times": "$n", "steps": []})"),
       "/steps/0/times", Code::kNotKnownYet},
      {declared(R"("n": {"type": "number", "nominal": 2})",
                R"_({"do": "let", "values": {"n": "$floor(time() / 1[s]) - 3"}},
                    {"do": "repeat", "times": "$n", "steps": []})_"),
       "/steps/1/times",
       Code::kOutOfRange,
       {"-3", "0"}},
      {declared(kUnknownList, R"({"do": "for_each", "as": "e", "in": "$all", "steps": []})"), "/steps/0/in",
       Code::kNotKnownYet},
      {declared(kUnknown, R"({"do": "branch", "cases": [{"when": "$x > 1[s]", "steps": []}]})"),
       "/steps/0/cases/0/when", Code::kConditionNotMet},
      {R"({"do": "repeat", "while": "$true", "at_most": 3, "steps": [{"do": "wait", "seconds": 0.001}]})",
       "",
       Code::kConditionNotMet,
       {"3", "at_most"}},
      {R"({"do": "repeat", "times": 20000, "steps": [{"do": "wait", "seconds": 0}]})",
       "/steps/0",
       Code::kTooLarge,
       {"10000"}},
      {declared(R"("t": "red")",
                R"_({"do": "net", "net": "counting"},
                   {"do": "let", "values": {"t": "$monitor('counting', 'counted')"}})_"),
       "/steps/1/values/t",
       Code::kTypeMismatch,
       {"t"}},
      {log("$text([1, 2][2])"), "/text", Code::kOutOfRange, {"2", "0"}},
      {log("$text(mean([]))"), "/text", Code::kTypeMismatch},
      {R"({"do": "wait", "until": "$false", "timeout_s": 0.02})", "/until", Code::kTimeout, {"timeout_s", "0.02"}},
  };
}

std::vector<BrokenRun> devices() {
  const auto silent = [](int cycle, ActivityCell& cell) { cell.sensor->silent = cycle >= 5; };
  return {
      {R"({"do": "wait", "until": {"sensor": "wrist", "above_N": 900}, "timeout_s": 0.02})",
       "/until",
       Code::kTimeout,
       {"timeout_s", "0.02"}},
      {R"({"do": "wait", "until": {"sensor": "wrist", "above_N": 900}, "timeout_s": 1})",
       "/until",
       Code::kSensorSilent,
       {},
       silent},
      {R"({"do": "tare", "sensor": "wrist", "cycles": 50})",
       "/sensor",
       Code::kSensorSilent,
       {"wrist", "retry"},
       silent},
      {R"({"do": "net", "net": "patient", "within_s": 0.02})", "/within_s", Code::kTimeout, {"patient", "0.02"}},
      {R"({"do": "grip"})",
       "",
       Code::kConditionNotMet,
       {"expect", "any", "40.0"},
       [](int cycle, ActivityCell& cell) {
         if (cycle >= 10) cell.fingers->answer(device::GripperState::kIdle, 0.04);
       }},
      {R"({"do": "grip", "expect": "nothing"})",
       "",
       Code::kConditionNotMet,
       {"expect", "any", "40.0"},
       [](int cycle, ActivityCell& cell) {
         if (cycle >= 10) cell.fingers->answer(device::GripperState::kHolding, 0.04);
       }},
      {R"({"do": "grip", "timeout_s": 0.1})",
       "",
       Code::kTimeout,
       {"gripper", "0.1", "close to 0.0 mm", "110.0 mm", "timeout_s"},
       [](int, ActivityCell& cell) {
         cell.fingers->sample.stamp = cell.core.time();
         cell.fingers->sample.width = 0.11;
       }},
      {R"({"do": "release", "width_m": 0.08, "timeout_s": 0.1})",
       "",
       Code::kTimeout,
       {"gripper", "0.1", "open to 80.0 mm", "60.0 mm", "timeout_s"},
       [](int, ActivityCell& cell) {
         cell.fingers->sample.stamp = cell.core.time();
         cell.fingers->answer(device::GripperState::kMoving, 0.06);
       }},
      {R"({"do": "set", "output": "lamp", "value": true})",
       "",
       Code::kNotPossibleNow,
       {"set", "try"},
       [](int, ActivityCell& cell) { cell.lamp_terminal->is_ready = false; }},
      {R"({"do": "control_mode", "mode": "joint_impedance"})",
       "/mode",
       Code::kNotPossibleNow,
       {},
       [](int, ActivityCell& cell) { cell.backend->state().ready = false; }},
      {steps(R"({"do": "branch", "cases": [{"when": "$time() > 1000[s]", "steps": [)" + std::string(kSlowlyUp) +
             R"({"sensor": "wrist", "above_N": 900}, "on_end": "continue"}, {"do": "record_contact", "as": "c"}]}]},
          {"do": "fit_pose", "object": "block", "contacts": ["c"], "as": "f", "free": ["z"]})"),
       "/steps/1/contacts",
       Code::kNoContact,
       {"c"}},
  };
}

std::vector<BrokenRun> motions() {
  const std::string up = kSlowlyUp;
  const std::string above_the_block =
      R"({"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.034], "rpy_deg": [180, 0, 0]}},
         {"do": "tare", "sensor": "wrist", "cycles": 20}, )";
  const auto sinking = [](int cycle, ActivityCell& cell) {
    if (cycle > 4000) cell.X_WO_true.translation().z() -= 2e-6;
  };
  const auto silent = [](int cycle, ActivityCell& cell) { cell.sensor->silent = cycle >= 300; };
  const auto pushed = [](int cycle, ActivityCell& cell) { cell.extra.force.x() = cycle >= 300 ? 1000.0 : 0.0; };
  const auto aside = [](int cycle, ActivityCell& cell) { cell.extra.force.x() = cycle >= 4000 ? 50.0 : 0.0; };
  return {
      {up + R"({"sensor": "wrist", "above_N": 900}})",
       "/until",
       Code::kConditionNotMet,
       {"on_end", "continue"},
       {},
       true},
      {up + R"({"sensor": "wrist", "above_N": 900}})", "/until", Code::kSensorSilent, {}, silent, true},
      {R"({"do": "lin", "to": {"by_m": [0, 0, 0.05]}, "velocity_m_s": 0.05,
          "abort_if": {"sensor": "wrist", "above_N": 900}})",
       "/abort_if",
       Code::kAbortCondition,
       {"abort_if"},
       pushed,
       true},
      {R"({"do": "lin", "to": {"by_m": [0, 0, 0.05]}, "velocity_m_s": 0.05,
          "abort_if": {"sensor": "wrist", "above_N": 900}})",
       "/abort_if",
       Code::kSensorSilent,
       {},
       silent,
       true},
      {up + R"({"sensor": "wrist", "above_N": 900}})",
       "",
       Code::kStopped,
       {"lin", "try"},
       [](int cycle, ActivityCell& cell) { cell.backend->silent = cycle >= 200; },
       true},
      {steps(up + R"({"sensor": "wrist", "above_N": 900}, "on_end": "continue"}, {"do": "record_contact", "as": "c"})"),
       "/steps/1",
       Code::kNoContact,
       {"arm", "..."},
       {},
       true},
      {steps(R"({"do": "tare", "sensor": "wrist", "cycles": 20}, {"do": "press", "sensor": "wrist",
          "direction": [0, 0, 1], "in": "world", "travel_m": 0.005, "approach_m_s": 0.01})"),
       "/steps/1/travel_m",
       Code::kConditionNotMet,
       {},
       {},
       true},
      {R"({"do": "press", "sensor": "wrist", "direction": [0, 0, 1], "in": "world", "approach_m_s": 0.01})",
       "/sensor",
       Code::kSensorSilent,
       {"wrist"},
       silent,
       true},
      {steps(above_the_block + R"({"do": "search", "sensor": "wrist", "direction": [0, 0, -1], "in": "block",
          "approach_m_s": 0.01, "radius_m": 0.006, "pitch_m": 0.003, "velocity_m_s": 0.03, "drop_m": 0.002})"),
       "/steps/2",
       Code::kConditionNotMet,
       {},
       {},
       true},
      {steps(above_the_block + R"({"do": "press", "sensor": "wrist", "direction": [0, 0, -1], "in": "block",
          "approach_m_s": 0.005, "travel_m": 0.02, "seconds": 60})"),
       "/steps/2/travel_m",
       Code::kConditionNotMet,
       {},
       sinking,
       true},
      {steps(above_the_block + R"({"do": "press", "sensor": "wrist", "direction": [0, 0, -1], "in": "block",
          "approach_m_s": 0.005, "depth_max_m": 0.001, "seconds": 60})"),
       "/steps/2/depth_max_m",
       Code::kConditionNotMet,
       {"0.001"},
       sinking,
       true},
      {steps(above_the_block + R"({"do": "press", "sensor": "wrist", "direction": [0, 0, -1], "in": "block",
          "approach_m_s": 0.005, "lateral_max_N": 20, "seconds": 60})"),
       "/steps/2/lateral_max_N",
       Code::kConditionNotMet,
       {"20"},
       aside,
       true},
  };
}

}  // namespace

std::vector<BrokenRun> broken_runs() {
  std::vector<BrokenRun> all;
  for (const auto& some : {values(), devices(), motions()}) all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace takt::test
