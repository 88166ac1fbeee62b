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
      {declared(kUnknown, R"({"do": "wait", "seconds": "$x"})"), "/steps/0",
       "'x' is not known yet when this step begins", "a value before"},
      {declared(R"("n": {"type": "number", "nominal": 2})", R"({"do": "repeat", "times": "$n", "steps": []})"),
       "/steps/0/times", "the number of rounds is not known", "a value before"},
      {declared(R"("n": {"type": "number", "nominal": 2})",
                R"_({"do": "let", "values": {"n": "$floor(time() / 1[s]) - 3"}},
                    {"do": "repeat", "times": "$n", "steps": []})_"),
       "/steps/1/times", "-3 rounds", "a whole number from 0"},
      {declared(kUnknownList, R"({"do": "for_each", "as": "e", "in": "$all", "steps": []})"), "/steps/0/in",
       "the list is not known yet", "a value before"},
      {declared(kUnknown, R"({"do": "branch", "cases": [{"when": "$x > 1[s]", "steps": []}]})"),
       "/steps/0/cases/0/when", "this cannot be decided", "known(x)"},
      {R"({"do": "repeat", "while": "$true", "at_most": 3, "steps": [{"do": "wait", "seconds": 0.001}]})", "",
       "after 3 rounds there is no end", "a larger \"at_most\""},
      {R"({"do": "repeat", "times": 20000, "steps": [{"do": "wait", "seconds": 0}]})", "/steps/0",
       "10000 steps without a single cycle between them", "a wait or a motion"},
      {declared(R"("t": "red")",
                R"_({"do": "net", "net": "counting"},
                   {"do": "let", "values": {"t": "$monitor('counting', 'counted')"}})_"),
       "/steps/1/values/t", "'t' is a text, here is a number", "a text"},
      {log("$text([1, 2][2])"), "/text", "element 2 of 2", "whole numbers from 0"},
      {log("$text(mean([]))"), "/text", "an empty list has no such number", "mean(list)"},
      {R"({"do": "wait", "until": "$false", "timeout_s": 0.02})", "/until", "this did not hold within 0.02 s",
       "a longer \"timeout_s\""},
  };
}

std::vector<BrokenRun> devices() {
  const auto silent = [](int cycle, ActivityCell& cell) { cell.sensor->silent = cycle >= 5; };
  return {
      {R"({"do": "wait", "until": {"sensor": "wrist", "above_N": 900}, "timeout_s": 0.02})", "/until",
       "the condition did not hold within 0.02 s", "a longer \"timeout_s\""},
      {R"({"do": "wait", "until": {"sensor": "wrist", "above_N": 900}, "timeout_s": 1})", "/until",
       "a sensor of the condition did not answer", "its power", silent},
      {R"({"do": "tare", "sensor": "wrist", "cycles": 50})", "/sensor", "'wrist' did not answer while it was tared",
       "\"retry\"", silent},
      {R"({"do": "net", "net": "patient", "within_s": 0.02})", "/within_s", "the net 'patient' still runs after 0.02 s",
       "a longer time"},
      {R"({"do": "grip"})", "", "no part was found; the fingers stand 40.0 mm apart", "\"expect\": \"any\"",
       [](int cycle, ActivityCell& cell) {
         if (cycle >= 10) cell.fingers->answer(device::GripperState::kIdle, 0.04);
       }},
      {R"({"do": "grip", "expect": "nothing"})", "", "something stopped the fingers at 40.0 mm", "\"expect\": \"any\"",
       [](int cycle, ActivityCell& cell) {
         if (cycle >= 10) cell.fingers->answer(device::GripperState::kHolding, 0.04);
       }},
      {R"({"do": "set", "output": "lamp", "value": true})", "", "'set' was not started: ", "\"try\" around the step",
       [](int, ActivityCell& cell) { cell.lamp_terminal->is_ready = false; }},
      {R"({"do": "control_mode", "mode": "joint_impedance"})", "/mode", "the mode was not changed: ",
       "an arm that stands", [](int, ActivityCell& cell) { cell.backend->state().ready = false; }},
      {steps(R"({"do": "branch", "cases": [{"when": "$time() > 1000[s]", "steps": [)" + std::string(kSlowlyUp) +
             R"({"sensor": "wrist", "above_N": 900}, "on_end": "continue"}, {"do": "record_contact", "as": "c"}]}]},
          {"do": "fit_pose", "object": "block", "contacts": ["c"], "as": "f", "free": ["z"]})"),
       "/steps/1/contacts", "contact 'c' was not recorded", "there are none"},
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
       "the motion reached its end and the condition never held",
       "\"on_end\": \"continue\"",
       {},
       true},
      {up + R"({"sensor": "wrist", "above_N": 900}})", "/until", "a sensor of the condition did not answer",
       "its power", silent, true},
      {R"({"do": "lin", "to": {"by_m": [0, 0, 0.05]}, "velocity_m_s": 0.05,
          "abort_if": {"sensor": "wrist", "above_N": 900}})",
       "/abort_if", "'abort_if' became true, so the arm stopped on its path", "what made it hold", pushed, true},
      {R"({"do": "lin", "to": {"by_m": [0, 0, 0.05]}, "velocity_m_s": 0.05,
          "abort_if": {"sensor": "wrist", "above_N": 900}})",
       "/abort_if", "a sensor of the condition did not answer, so the arm stopped", "its power", silent, true},
      {up + R"({"sensor": "wrist", "above_N": 900}})", "", "'lin' was stopped in cycle", "\"try\" around the step",
       [](int cycle, ActivityCell& cell) { cell.backend->silent = cycle >= 200; }, true},
      {steps(up + R"({"sensor": "wrist", "above_N": 900}, "on_end": "continue"}, {"do": "record_contact", "as": "c"})"),
       "/steps/1",
       "the last motion of 'arm' ended without a contact",
       "known(touch('...'))",
       {},
       true},
      {steps(R"({"do": "tare", "sensor": "wrist", "cycles": 20}, {"do": "press", "sensor": "wrist",
          "direction": [0, 0, 1], "in": "world", "travel_m": 0.005, "approach_m_s": 0.01})"),
       "/steps/1/travel_m",
       "nothing was touched",
       "a longer travel",
       {},
       true},
      {R"({"do": "press", "sensor": "wrist", "direction": [0, 0, 1], "in": "world", "approach_m_s": 0.01})", "/sensor",
       "'wrist' did not answer, so the arm stopped", "its power", silent, true},
      {steps(above_the_block + R"({"do": "search", "sensor": "wrist", "direction": [0, 0, -1], "in": "block",
          "approach_m_s": 0.01, "radius_m": 0.006, "pitch_m": 0.003, "velocity_m_s": 0.03, "drop_m": 0.002})"),
       "/steps/2",
       "the pattern has come to its end and nothing was found",
       "a larger radius",
       {},
       true},
      {steps(above_the_block + R"({"do": "press", "sensor": "wrist", "direction": [0, 0, -1], "in": "block",
          "approach_m_s": 0.005, "travel_m": 0.02, "seconds": 60})"),
       "/steps/2/travel_m", "the travel was used up after the touch", "a longer travel", sinking, true},
      {steps(above_the_block + R"({"do": "press", "sensor": "wrist", "direction": [0, 0, -1], "in": "block",
          "approach_m_s": 0.005, "depth_max_m": 0.001, "seconds": 60})"),
       "/steps/2/depth_max_m", "the tool went more than 0.001 m beyond the touch", "check what was touched", sinking,
       true},
      {steps(above_the_block + R"({"do": "press", "sensor": "wrist", "direction": [0, 0, -1], "in": "block",
          "approach_m_s": 0.005, "lateral_max_N": 20, "seconds": 60})"),
       "/steps/2/lateral_max_N", "the force across the direction was more than 20 N", "another pose", aside, true},
  };
}

}  // namespace

std::vector<BrokenRun> broken_runs() {
  std::vector<BrokenRun> all;
  for (const auto& some : {values(), devices(), motions()}) all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace takt::test
