// The schema of scenario files and the code that reads them agree: what one refuses, so does the other; and every
// scenario, and the example of the documentation, is accepted by both.
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cell/build/cell_builder.h"
#include "cell/file/description.h"
#include "cell/judge/expectations.h"
#include "cell/run/session.h"
#include "core/program/tree/program.h"
#include "tests/cell/scenario_schema.h"

namespace takt::cell::schema_test {
namespace {

using Json = nlohmann::json;
using test::Mistake;
using test::models;
using test::schema;
using test::text_of;

/// Uses every key there is at least once.
constexpr const char* kEverything = R"json({
  "$schema": "x", "comment": ["any", 1], "title": "t", "description": "d", "seed": 7, "time_limit_s": 10,
  "program_latency_cycles": 0, "plant_mass_scale": 1.1,
  "frames": {"a": {"in": "b", "position_m": [1, 0, 0], "rpy_deg": [0, 0, 90]}, "b": {"quaternion": [1, 0, 0, 0]}},
  "devices": {
    "arm": {"model": "lwr4plus", "at": {"comment": "here", "in": "world"}, "payload_error_kg": -0.1, "tool": "probe",
            "material": "steel", "friction": 0.3,
            "start_deg": [0, -30, 0, 90, 0, -60, 0]},
    "wrist": {"model": "ft_gamma", "on": "arm"},
    "probe": {"model": "probe_ball", "on": "wrist"},
    "gripper": {"model": "wsg50", "on": "arm", "settings": {"start_width_m": 0.05},
                "tcp": "tip", "tcps": {"tip": {"position_m": [0, 0, 0.2], "quaternion": [1, 0, 0, 0]}}},
    "barrier": {"model": "light_barrier", "at": {"position_m": [0, 1, 0]}, "settings": {"distance_m": 1}},
    "finder": {"model": "range_finder", "at": {"position_m": [0, 2, 0]}},
    "io": {"model": "io_block", "at": {"position_m": [0, 3, 0]},
           "settings": {"do1": {"name": "lamp"}, "di1": {"from": "barrier"},
                        "di2": {"script": [{"at_s": 1, "value": true}]}}}
  },
  "objects": {
    "table": {"model": "table", "at": {"position_m": [0.8, 0, -0.75]}, "fixed": true},
    "stack": {"parts": [
        {"shape": "cylinder", "radius_m": 0.02, "length_m": 0.05, "position_m": [0, 0, 0.1]},
        {"shape": "capsule", "radius_m": 0.02, "length_m": 0.05, "rpy_deg": [90, 0, 0]},
        {"shape": "sphere", "radius_m": 0.03, "quaternion": [1, 0, 0, 0]}],
      "at": {"in": "a"}, "rgba": [1, 0, 0.5, 1], "friction": 0},
    "block": {"shape": "box", "size_m": [0.1, 0.06, 0.05], "at": {"in": "world", "position_m": [0.56, 0, 0.3]},
      "vary": {"radius_m": 0.01, "position_m": [0, 0, 0.01], "rpy_deg": [0, 0, 5]}, "fixed": false, "mass_kg": 2,
      "grasps": {"top": {"position_m": [0, 0, 0.02], "rpy_deg": [0, 180, 0]}}}
  },
  "composed": {"robot": ["arm", "gripper"], "cell": ["robot", "io/lamp"]},
  "cameras": {
    "c": {"at": {"position_m": [2, 0, 1]}, "look_at": {"in": "block"}, "fovy_deg": 30},
    "down": {"at": {"in": "block", "position_m": [0, 0, 1]}}
  },
  "film": {"camera": "c", "inset": "down", "force_sensor": "wrist", "force_limit_N": 20,
           "show": ["traces", "commanded"], "trace_s": 2, "cuts": [{"step": "touch", "camera": "down"}]},
  "channels": {"felt": {"type": "Wrench", "writer": "net", "unit": "N,N*m", "frame": "flange", "timeout_s": 0.01,
                        "initial": {"force": [0, 0, 1], "torque": [0, 0, 0]}}, "go": {"type": "Boolean"},
               "level": {"type": "Real"}, "stick": {"type": "Twist", "unit": "m/s,rad/s"}, "target": {"type": "Frame"}},
  "nets": {"by hand": {"primitives": [{"id": "end", "type": "Termination", "parameters": {"condition": true}},
                                      {"id": "shown", "type": "MonitorReal", "parameters": {"value": 1}}]}},
  "programs": {"twice": {"description": "d", "parameters": {"x": {"unit": "m", "value": 0.1}, "y": 2},
                         "variables": {"z": {"type": "list of number", "value": []}},
                         "steps": [{"do": "wait", "seconds": "$y"}], "result": "$x * 2"}},
  "program": {"do": "sequence", "name": "all", "times": 2,
    "variables": {"n": 0, "h": {"type": "number", "unit": "m", "nominal": 0.1}, "t": "a", "b": true, "l": [1, 2],
                  "p": {"in": "block", "position_m": [0, 0, "$0.1"], "rpy_deg": [0, 0, 0]}}, "steps": [
    {"do": "ptp", "to": "home", "arm": "arm", "speed": 0.5, "acceleration": 1},
    {"do": "ptp", "to": {"joints_deg": [0, -30, 0, 90, 0, -60, 0]}},
    {"do": "ptp", "to": {"in": "block", "position_m": [0, 0, 0.1], "rpy_deg": [180, 0, 0]},
     "until": {"any": [{"not": {"sensor": "wrist", "below_N": 5}},
                       {"all": [{"sensor": "wrist", "quantity": "torque_x", "above_Nm": 1}]}]}, "on_end": "continue"},
    {"do": "tare", "sensor": "wrist", "cycles": 100},
    {"do": "lin", "name": "touch", "tool": "probe", "tcp": "tcp",
     "to": {"by_m": [0, 0, -0.05], "in": "tcp", "by_rpy_deg": [0, 0, 1]},
     "velocity_m_s": 0.01, "until": {"sensor": "wrist", "quantity": "force_z", "above_N": 5}},
    {"do": "record_contact", "arm": "arm", "as": "top"},
    {"do": "fit_pose", "object": "block", "as": "found", "contacts": ["top"], "free": ["z"], "max_residual_m": 0.01},
    {"do": "net", "net": "by hand", "cancel_after_s": 1, "within_s": 2},
    {"do": "wait", "name": "pause", "seconds": 0},
    {"do": "grip", "gripper": "gripper", "width_m": 0.01, "speed_m_s": 0.1, "force_N": 20, "expect": "any",
     "part": "block", "part_mass_kg": 2},
    {"do": "release", "gripper": "gripper", "width_m": 0.1, "speed_m_s": 0.1, "force_N": 20, "onto": "table"},
    {"do": "set", "output": "io/lamp", "value": true},
    {"do": "set", "output": "io/ao1", "value": 2.5},
    {"do": "wait", "until": {"all": [{"input": "io/di1", "is": false}, {"input": "finder", "below_m": 1},
                                     {"gripper": "gripper", "is": "holding"}]}, "timeout_s": 1},
    {"do": "parallel", "name": "both", "end": "first", "branches": [{"do": "wait", "seconds": 1}, {"do": "stop"}]},
    {"do": "branch", "cases": [{"when": "$n > 1", "steps": []}, {"when": true, "steps": []},
                               {"when": {"sensor": "wrist", "above_N": "$n"}, "steps": []}], "else": []},
    {"do": "repeat", "until": "$b", "at_most": 5, "as": "i", "steps": [{"do": "log", "text": "$text(i) + t"}]},
    {"do": "for_each", "as": "q", "index": "k", "steps": [],
     "grid": {"in": "block", "position_m": [0, 0, 0], "count": [2, 1, 1], "step_m": [0.1, 0, 0]}},
    {"do": "call", "program": "twice", "with": {"x": "$h"}, "as": "h"},
    {"do": "try", "retry": 2, "steps": [{"do": "fail", "text": "x"}], "recover": [],
     "on_error": {"as": "why", "steps": []}, "finally": []},
    {"do": "let", "values": {"n": "$n + 1", "p": {"in": "world"}, "b": false, "l": [3]}},
    {"do": "repeat", "times": "$n", "steps": []},
    {"do": "wait", "until": "$b", "timeout_s": 1},
    {"do": "lin", "to": {"in": "$p", "position_m": ["$h", 0, 0]}, "velocity_m_s": "$h / 1[s]", "on_end": "continue",
     "until": {"sensor": "wrist", "quantity": "force_x", "above_N": "$2[N]"}},
    {"do": "ptp", "to": "$p", "speed": "$n"},
    {"do": "for_each", "as": "v", "in": "$l", "steps": []},
    {"do": "press", "arm": "arm", "sensor": "wrist", "direction": [0, 0, -1], "in": "world", "force_N": 5,
     "approach_m_s": 0.01, "travel_m": 0.02, "seconds": 1, "until": {"sensor": "wrist", "above_N": 5},
     "compliance": {"mode": "joint_impedance", "stiffness_Nm_rad": 500, "torque_Nm": [0, 0, 0, 0, 0, 1, 0]}},
    {"do": "search", "pattern": "zigzag", "radius_m": 0.01, "pitch_m": 0.002, "velocity_m_s": 0.02, "drop_m": 0.001,
     "on_end": "continue", "force_N": "$n",
     "compliance": {"mode": "cartesian_impedance", "stiffness_N_m": [1000, 500, "$n"], "axes": "tool"}},
    {"do": "freedrive", "arm": "arm", "enabled": {"input": "io/di1"}, "until": {"sensor": "wrist", "above_N": 50},
     "seconds": 5, "velocity_m_s": 0.1, "turn_deg_s": 30},
    {"do": "lin", "arm": "arm", "to": {"by_m": [0.1, 0, 0]}, "base_to": {"by_m": [0.2, 0, 0]}, "speed": 0.5},
    {"do": "transaction", "name": "tree", "raised": ["lost"], "on_cancel": ["a", "b"],
     "commands": {
       "a": {"do": "lin", "start": true, "to": {"by_m": [0, 0, "$h"]}, "velocity_m_s": 0.1,
             "on": [{"entered": {"sensor": "wrist", "above_N": 5, "held_for_s": 0.1}, "cancel": "a"}],
             "weave": {"amplitude_m": 0.001, "frequency_Hz": 2, "direction": [1, 0, 0], "ramp_s": 0.3}},
       "b": {"do": "press", "force_N": 5}, "c": {"do": "set", "output": "io/lamp", "value": true},
       "d": {"do": "wait", "until": {"channel": "level", "above": 1}, "timeout_s": 1},
       "e": {"do": "motions", "steps": [{"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "blend_m": 0.01,
             "weave": {"amplitude_m": 0.001, "frequency_Hz": 2}}, {"do": "ptp", "to": "home"}]},
       "f": {"do": "transaction", "on_cancel": "ignore",
             "commands": {"g": {"do": "grip", "start": true, "expect": "any"}}},
       "h": {"do": "hold", "arm": "arm", "seconds": 1},
       "i": {"do": "lin", "arm": "arm", "to": {"by_m": [0.1, 0, 0]}, "base_to": {"by_m": [0.2, 0, 0]}},
       "j": {"do": "set", "output": "io/ao1", "value": {"progress": "a"}, "factor": "$n", "offset": 1, "seconds": 1,
             "until": {"input": "io/di1"}}},
     "on": [{"entered": {"all": [{"completed": "a"}, {"not": {"cancelled": "a"}}]}, "start": ["b", "c"],
             "after_s": 0.1},
            {"left": {"any": [{"action": "b", "is": "in_contact"}, {"channel": "go", "is": false}]}, "raise": "lost"},
            {"entered": {"raised": "lost"}, "stop": "b", "tell": "lost", "first_only": true},
            {"entered": {"action": "a", "at_path": 0.5}, "tell": "half"},
            {"entered": {"action": "e", "via_passed": 0}, "tell": "via"},
            {"entered": {"actuator": "arm", "is": "emergency_stop"}, "cancel": "tree"}],
     "capture": {"force": {"value": {"sensor": "wrist", "quantity": "force_z"}, "when": {"started": "b"}},
                 "way": {"value": {"progress": "a"}}, "wide": {"value": {"gripper": "gripper"}},
                 "fast": {"value": {"speed": "arm"}},
                 "go": {"value": {"channel": "go"}}, "di": {"value": {"input": "io/di1"}}}},
    {"do": "jog", "arm": "arm", "channel": "stick", "in": "tcp", "while": {"channel": "go"}, "linear_max_m_s": 0.1,
     "angular_max_deg_s": 10, "seconds": 1, "until": {"channel": "level", "below": 0}},
    {"do": "jog", "linear_m_s": [0, 0, "$0.1[m/s]"], "angular_deg_s": [0, 0, 1], "while": {"input": "io/di1"}},
    {"do": "follow", "channel": "target", "in": "block", "until": {"channel": "go"}},
    {"do": "lin", "to": {"by_m": [0, 0, 0.1]}, "velocity_m_s": 0.05, "force_offset": {"sensor": "wrist", "force_N": 8,
     "direction": [0, 0, 1], "reach_m": 0.01, "retreat_m": 0.002, "approach_m_s": 0.01, "velocity_max_m_s": 0.02,
     "acceleration_max_m_s2": 0.3, "jerk_max_m_s3": 10, "gain_m_s_per_N": "$0.001[m/s/N]"}},
    {"do": "set", "output": "io/ao1", "value": {"sensor": "wrist", "quantity": "force_z"}, "factor": 0.1, "seconds": 1},
    {"do": "wipe", "in": "block", "centre_m": [0, 0, 0.05], "length_m": 0.05, "width_m": 0.04, "pitch_m": "$n",
     "velocity_m_s": 0.02, "until": {"sensor": "wrist", "above_N": 50}},
    {"do": "set_frame", "as": "here", "in": "table", "of": "gripper/tip", "position_m": [0, 0, 0.1],
     "rpy_deg": [0, 0, 5]}
  ]},
  "operator": [{"at_s": 1, "do": "pause"}, {"at_step": "touch", "after_s": 0.5, "do": "resume"},
               {"at_s": 2, "do": "override", "value": 0.5}, {"at_s": 3, "do": "write", "channel": "go", "value": true},
               {"at_s": 4, "do": "cancel"}, {"at_s": 5, "do": "abort"}],
  "golden": {"tolerances": [{"topic": "/arm/*", "column": "*.position", "kind": "tube", "dv": 0.001, "dt_s": 0.01},
                            {"column": "*.effort", "kind": "report_only"}, {"dv": 1, "kind": "features"}]},
  "expectations": [
    {"name": "n", "kind": "estimate", "estimate": "found", "of": "block", "position_within_m": 1,
     "angle_within_deg": 1},
    {"kind": "object_pose", "object": "block", "in": "world", "position_m": [0, 0, 0], "rpy_deg": [0, 0, 0],
     "position_within_m": 5, "angle_within_deg": 5},
    {"kind": "contact_force", "between": ["probe", "block"], "below_N": 15, "at_least_N": 0, "during": "touch"},
    {"kind": "peak_force", "sensor": "wrist", "below_N": 100},
    {"kind": "limits", "arm": "arm"}, {"kind": "duration", "below_s": 60}, {"kind": "step", "step": "touch"},
    {"kind": "monitor", "net": "by hand", "monitor": "shown", "at_least": 0, "at_most": 2, "is": 1},
    {"kind": "repeats"},
    {"kind": "gripper", "gripper": "gripper", "is": "idle"},
    {"kind": "signal", "signal": "io/lamp", "is": true, "rises": 1},
    {"kind": "signal", "signal": "finder", "at_least": 0, "at_most": 5},
    {"kind": "tool_pose", "arm": "arm", "in": "world", "position_m": [0, 0, 0], "quaternion": [1, 0, 0, 0],
     "position_within_m": 5, "angle_within_deg": 5},
    {"kind": "mean_force", "between": ["probe", "block"], "at_least_N": 1, "below_N": 20},
    {"kind": "belief", "frame": "block/top", "position_within_m": 0.01, "angle_within_deg": 5},
    {"kind": "value", "value": "$force('wrist')", "during": "touch", "at_least": 0, "at_most": 9, "share": 0.9,
     "mean_at_least": 0, "mean_at_most": 5},
    {"kind": "event", "source": "arm", "event": "touch", "text": "m", "during": "touch", "at_least": 1, "at_most": 2,
     "from_s": 1, "to_s": 20},
    {"kind": "event", "event": "log", "times": 1},
    {"kind": "order", "events": [{"source": "program", "event": "begin", "text": "touch", "during": "touch"},
                                 {"text": "m", "within_s": 2}]},
    {"kind": "contacts", "only": [["probe", "block"], ["floor", "arm"]]}
  ]
})json";

/// What takt's own readers say of a file. Program and expectations are read against a cell, that of kEverything.
Diagnostics diagnostics_of(const Json& json) {
  const auto description = parse_description(json.dump());
  if (!description) return description.error();
  static Diagnostics warnings;
  static auto built = build_cell(*parse_description(kEverything), models(), false, warnings);
  if (!built) return built.error();
  const auto program = program::Program::parse(description->program, "/program", built->cell, &description->programs);
  if (!program) return program.error();
  if (const auto faults = make_faults(description->faults, *built); !faults) return faults.error();
  const auto expectations = make_expectations(description->expectations, *built, program->names());
  return expectations ? Diagnostics{} : expectations.error();
}

TEST(ScenarioSchema, EveryKeyThereIsIsKnownToBoth) {
  const Json everything = Json::parse(kEverything);
  EXPECT_TRUE(schema().accepts(everything));
  EXPECT_EQ(diagnostics_of(everything).to_string(), "");
}

TEST(ScenarioSchema, TheLeastIsEnough) {
  const Json least = Json::parse(R"({"program": {"do": "wait", "seconds": 1}})");
  EXPECT_TRUE(schema().accepts(least));
  EXPECT_EQ(diagnostics_of(least).to_string(), "");
}

class ScenarioMistake : public testing::TestWithParam<Mistake> {};

TEST_P(ScenarioMistake, IsRefusedByBoth) {
  const Json json = with_mistake(Json::parse(kEverything), GetParam());
  EXPECT_FALSE(schema().accepts(json)) << "by the schema";
  EXPECT_TRUE(diagnostics_of(json).has_errors()) << "by takt";
}

constexpr Mistake kMistakes[] = {
    // The whole.
    {"/program", nullptr},
    {"/program", "[]"},
    {"/progam", "{}"},
    {"/title", "3"},
    {"/seed", "-1"},
    {"/seed", "1.5"},
    {"/seed", "\"1\""},
    {"/time_limit_s", "0"},
    {"/time_limit_s", "3601"},
    {"/program_latency_cycles", "1001"},
    {"/plant_mass_scale", "0.4"},
    {"/plant_mass_scale", "2.1"},
    {"/devices", "[]"},
    {"/expectations", "{}"},
    // Names and places.
    {"/frames/world", "{}"},
    {"/frames/x~1y", "{}"},
    {"/frames/", "{}"},
    {"/frames/a/position_m", "[1, 2]"},
    {"/frames/a/position_m", "[1, 2, \"3\"]"},
    {"/frames/a/quaternion", "[1, 0, 0, 0]"},
    {"/frames/b/quaternion", "[1, 0, 0]"},
    {"/frames/b/quaternion", "[2, 0, 0, 0]"},
    {"/frames/a/xyz", "[0, 0, 0]"},
    {"/frames/a/in", "null"},
    // Channels.
    {"/channels/felt/type", nullptr},
    {"/channels/felt/type", "\"Reel\""},
    {"/channels/felt/writer", "\"me\""},
    {"/channels/felt/timeout_s", "-1"},
    {"/channels/felt/unit", "3"},
    {"/channels/felt/rate", "1"},
    {"/channels/x~1y", "{\"type\": \"Real\"}"},
    // Devices.
    {"/devices/arm/model", nullptr},
    {"/devices/arm/model", "true"},
    {"/devices/wrist/at", "{}"},
    {"/devices/arm/start_deg", "90"},
    {"/devices/arm/start_rad", "[0]"},
    {"/devices/arm/payload_error_kg", "\"1\""},
    {"/devices/arm/at/position", "[0, 0, 0]"},
    // Objects.
    {"/objects/block/at", nullptr},
    {"/objects/block/shape", nullptr},
    {"/objects/block/shape", "\"cube\""},
    {"/objects/block/size_m", "[0, 1, 1]"},
    {"/objects/block/size_m", "[1e-9, 1, 1]"},
    {"/objects/block/size_m", nullptr},
    {"/objects/stack/parts/1/radius_m", "2000"},
    {"/devices/arm/friction", "-0.1"},
    {"/devices/arm/material", "1"},
    {"/objects/block/radius_m", "1"},
    {"/objects/table/shape", "\"box\""},
    {"/objects/table/size_m", "[1, 1, 1]"},
    {"/objects/stack/shape", "\"sphere\""},
    {"/objects/stack/parts", "[]"},
    {"/objects/stack/parts/0/length_m", nullptr},
    {"/objects/stack/parts/1/radius_m", "-1"},
    {"/objects/stack/parts/2/length_m", "1"},
    {"/objects/stack/parts/2/rpy_deg", "[0, 0, 0]"},
    {"/objects/stack/rgba", "[1, 0, 0]"},
    {"/objects/stack/rgba", "[1, 0, 0, 2]"},
    {"/objects/stack/friction", "-0.1"},
    {"/objects/block/mass_kg", "0"},
    {"/objects/block/fixed", "1"},
    {"/objects/block/vary/radius_m", "-0.01"},
    {"/objects/block/vary/position_m", "[0, 0, -1]"},
    {"/objects/block/vary/rpy_deg", "[0, 0, 181]"},
    {"/objects/block/vary/yaw_deg", "5"},
    // Cameras and film.
    {"/cameras/c/at", nullptr},
    {"/cameras/c/fovy_deg", "4"},
    {"/cameras/c/fovy_deg", "121"},
    {"/cameras/c/lookat", "{}"},
    {"/film/camera", "1"},
    {"/film/force_limit_N", "0"},
    {"/film/cuts", "{}"},
    {"/film/cuts/0/camera", nullptr},
    {"/film/cuts/0/at", "1"},
    {"/film/fps", "25"},
    // Steps.
    {"/program/do", nullptr},
    {"/program/do", "\"parallel\""},
    {"/program/steps", nullptr},
    {"/program/times", "-1"},
    {"/program/times", "0.5"},
    {"/program/speed", "1"},
    {"/program/steps/0", "\"home\""},
    {"/program/steps/0/do", "\"jump\""},
    {"/program/steps/0/name", "1"},
    {"/program/steps/0/speed", "0"},
    {"/program/steps/0/speed", "1.1"},
    {"/program/steps/0/acceleration", "-1"},
    {"/program/steps/0/velocity_m_s", "0.1"},
    {"/program/steps/0/on_end", "\"continue\""},
    {"/program/steps/2/on_end", "\"stop\""},
    {"/program/steps/4/velocity_m_s", "0"},
    {"/program/steps/4/until", "[]"},
    // Goals.
    {"/program/steps/0/to", nullptr},
    {"/program/steps/0/to", "\"away\""},
    {"/program/steps/0/to", "{}"},
    {"/program/steps/0/to", "[0, 0, 0]"},
    {"/program/steps/1/to/in", "\"world\""},
    {"/program/steps/1/to/joints_deg", "[0, \"-30\"]"},
    {"/program/steps/2/to/in", nullptr},
    {"/program/steps/2/to/position_m", nullptr},
    {"/program/steps/2/to/quaternion", "[1, 0, 0, 0]"},
    {"/program/steps/4/to/by_m", "[0, 0]"},
    {"/program/steps/4/to/rpy_deg", "[0, 0, 0]"},
    // Conditions.
    {"/program/steps/4/until/sensor", nullptr},
    {"/program/steps/4/until/above_N", nullptr},
    {"/program/steps/4/until/above_N", "\"5\""},
    {"/program/steps/4/until/below_N", "5"},
    {"/program/steps/4/until/above_Nm", "5"},
    {"/program/steps/4/until/quantity", "\"torque_z\""},
    {"/program/steps/4/until/quantity", "\"pressure\""},
    {"/program/steps/2/until/any", "[]"},
    {"/program/steps/2/until/all", "[]"},
    {"/program/steps/2/until/any/0/not", "true"},
    {"/program/steps/2/until/any/1/all/0/above_N", "1"},
    // The other steps.
    {"/program/steps/3/cycles", "0"},
    {"/program/steps/3/cycles", "100001"},
    {"/program/steps/3/arm", "\"arm\""},
    {"/program/steps/5/as", nullptr},
    {"/program/steps/5/as", "1"},
    {"/program/steps/6/object", nullptr},
    {"/program/steps/6/as", nullptr},
    {"/program/steps/6/contacts", nullptr},
    {"/program/steps/6/contacts", "[1]"},
    {"/program/steps/6/free", nullptr},
    {"/program/steps/6/free", "[\"w\"]"},
    {"/program/steps/6/max_residual_m", "0"},
    {"/program/steps/8/seconds", nullptr},
    {"/program/steps/8/seconds", "-1"},
    {"/program/steps/8/seconds", "3601"},
    // Operator.
    {"/operator", "{}"},
    {"/operator/0/at_s", nullptr},
    {"/operator/0/at_s", "-1"},
    {"/operator/0/at_step", "\"touch\""},
    {"/operator/0/do", "\"jump\""},
    {"/operator/0/value", "1"},
    {"/operator/0/after_s", "1"},
    {"/operator/1/after_s", "-1"},
    {"/operator/1/at_step", "\"\""},
    {"/operator/2/value", nullptr},
    {"/operator/2/value", "2"},
    {"/operator/3/channel", nullptr},
    {"/operator/3/value", nullptr},
    // Inner nodes, variables, expressions.
    {"/programs", "[]"},
    {"/programs/twice/steps", nullptr},
    {"/programs/twice/stesp", "[]"},
    {"/programs/twice/parameters/2x", "1"},
    {"/program/variables", "[]"},
    {"/program/variables/and", "1"},
    {"/program/variables/h/type", "\"nubmer\""},
    {"/program/variables/h/init", "1"},
    {"/program/variables/p/postion_m", "[0, 0, 0]"},
    {"/program/steps/14/branches", "[]"},
    {"/program/steps/14/end", "\"frist\""},
    {"/program/steps/15/cases", "[]"},
    {"/program/steps/15/cases/0/when", nullptr},
    {"/program/steps/15/cases/0/when", "\"n > 1\""},
    {"/program/steps/15/cases/0/step", "[]"},
    {"/program/steps/15/else", "{}"},
    {"/program/steps/16/until", nullptr},
    {"/program/steps/16/while", "true"},
    {"/program/steps/16/at_most", "0"},
    {"/program/steps/16/as", "\"1\""},
    {"/program/steps/17/as", nullptr},
    {"/program/steps/17/in", "[1]"},
    {"/program/steps/17/grid/count", "[1, 1]"},
    {"/program/steps/17/grid/step", "[1, 1, 1]"},
    {"/program/steps/18/program", nullptr},
    {"/program/steps/18/with", "[]"},
    {"/program/steps/19/retry", "0"},
    {"/program/steps/19/retry", nullptr},
    {"/program/steps/19/on_error/steps", nullptr},
    {"/program/steps/19/on_error/as", "\"not\""},
    {"/program/steps/20/values", nullptr},
    {"/program/steps/20/values", "[]"},
    {"/program/steps/21/times", "-1"},
    {"/program/steps/21/at_most", "1"},
    {"/program/steps/22/until", "\"b\""},
    {"/program/steps/23/velocity_m_s", "\"h\""},
    {"/program/steps/24/speed", "\"fast\""},
    {"/program/steps/25/in", "5"},
    // Forces.
    {"/program/steps/26/direction", "[0, 0]"},
    {"/program/steps/26/force_N", "0"},
    {"/program/steps/26/approach_m_s", "0.2"},
    {"/program/steps/26/travel_m", "0"},
    {"/program/steps/26/seconds", "-1"},
    {"/program/steps/26/drop_m", "0.1"},
    {"/program/steps/26/compliance/mode", nullptr},
    {"/program/steps/26/compliance/mode", "\"soft\""},
    {"/program/steps/26/compliance/stiffness_N_m", "500"},
    {"/program/steps/27/pattern", "\"star\""},
    {"/program/steps/27/compliance", "5"},
    {"/program/steps/27/compliance/axes", "\"world\""},
    {"/program/steps/27/radius_m", nullptr},
    {"/program/steps/27/pitch_m", "0"},
    {"/program/steps/27/drop_m", nullptr},
    {"/program/steps/27/on_end", "\"stop\""},
    // Transactions, manual control, what is laid over a motion.
    {"/program/steps/28/enabled", "true"},
    {"/program/steps/28/velocity_m_s", "2"},
    {"/program/steps/28/turn_deg_s", "0"},
    {"/program/steps/30/commands", nullptr},
    {"/program/steps/30/comands", "{}"},
    {"/program/steps/30/commands/a/do", "\"fly\""},
    {"/program/steps/30/commands/a/name", "\"x\""},
    {"/program/steps/30/commands/a/start", "1"},
    {"/program/steps/30/commands/x~1y", "{\"do\": \"hold\"}"},
    {"/program/steps/30/commands/a/weave/amplitude_m", nullptr},
    {"/program/steps/30/commands/e/steps", "[]"},
    {"/program/steps/30/commands/e/steps/0/weave/frequency_Hz", "0"},
    {"/program/steps/29/weave", R"({"amplitude_m": 0.001, "frequency_Hz": 2})"},
    {"/program/steps/29/force_offset", R"({"sensor": "wrist", "force_N": 5})"},
    {"/program/steps/30/on", "{}"},
    {"/program/steps/30/on/0/entered", nullptr},
    {"/program/steps/30/on/0/after_s", "-1"},
    {"/program/steps/30/on/0/start", nullptr},
    {"/program/steps/30/on/3/tell", "\"\""},
    {"/program/steps/30/on/3/entered/at_path", "2"},
    {"/program/steps/30/on/5/entered/is", "\"tired\""},
    {"/program/steps/30/on/5/entered", "{}"},
    {"/program/steps/30/on_cancel", "\"never\""},
    {"/program/steps/30/capture/way/value", "{}"},
    {"/program/steps/30/raised", "\"lost\""},
    {"/program/steps/31/while", nullptr},
    {"/program/steps/31/linear_max_m_s", "2"},
    {"/program/steps/32/linear_m_s", "[0, 0]"},
    {"/program/steps/33/until/channel", nullptr},
    {"/program/steps/34/force_offset/force_N", nullptr},
    {"/program/steps/34/force_offset/direction", "[0, 1]"},
    {"/program/steps/34/force_offset/reach", "0.01"},
    {"/program/steps/30/commands/i/weave", "{\"amplitude_m\": 0.001, \"frequency_Hz\": 2}"},
    {"/program/steps/30/commands/j/value", "{}"},
    {"/program/steps/30/commands/j/value", "1"},
    {"/program/steps/30/commands/j/value/speed", "\"arm\""},
    {"/program/steps/30/commands/j/seconds", "-1"},
    {"/program/steps/30/commands/j/factor", "\"10\""},
    {"/program/steps/35/value/quantity", "\"pressure\""},
    {"/program/steps/35/value", "2.5"},
    // Expectations.
    {"/expectations/0", "1"},
    {"/expectations/0/kind", nullptr},
    {"/expectations/0/kind", "\"hope\""},
    {"/expectations/0/of", nullptr},
    {"/expectations/0/estimate", nullptr},
    {"/expectations/0/position_within_m", nullptr},
    {"/expectations/0/angle_within_deg", "0"},
    {"/expectations/1/quaternion", "[1, 0, 0, 0]"},
    {"/expectations/1/object", nullptr},
    {"/expectations/2/between", "[\"probe\"]"},
    {"/expectations/2/below_N", nullptr},
    {"/expectations/2/at_least_N", "-1"},
    {"/expectations/3/sensor", nullptr},
    {"/expectations/3/above_N", "1"},
    {"/expectations/4/sensor", "\"wrist\""},
    {"/expectations/5/below_s", "0"},
    {"/expectations/6/step", nullptr},
    {"/expectations/7/net", nullptr},
    {"/expectations/7/at_least", "\"0\""},
    {"/program/steps/7/net", nullptr},
    {"/program/steps/7/within_s", "-1"},
    {"/nets/by hand", "1"},
    {"/expectations/8/times", "2"},
    // Wholes.
    {"/composed", "[]"},
    {"/composed/robot", "[]"},
    {"/composed/robot", "\"arm\""},
    {"/composed/robot", "[1]"},
    // Grippers and signals.
    {"/devices/io/settings", "1"},
    {"/program/steps/9/force_N", "0"},
    {"/program/steps/9/expect", "\"luck\""},
    {"/program/steps/9/part_mass_kg", "-1"},
    {"/program/steps/10/part", "\"block\""},
    {"/program/steps/11/value", nullptr},
    {"/program/steps/11/value", "\"on\""},
    {"/program/steps/13/until", nullptr},
    {"/program/steps/13/seconds", "1"},
    {"/program/steps/13/timeout_s", "-1"},
    {"/program/steps/13/until/all/0/is", "1"},
    {"/program/steps/13/until/all/1/below_m", "\"1\""},
    {"/program/steps/13/until/all/2/is", nullptr},
    {"/program/steps/13/until/all/2/is", "\"happy\""},
    {"/expectations/9/is", nullptr},
    {"/expectations/10/rises", "-1"},
    {"/expectations/11/at_most", "\"5\""},
    {"/golden/tolerances", nullptr},
    {"/golden/tolerances/0/dv", nullptr},
    {"/golden/tolerances/0/dv", "-1"},
    {"/golden/tolerances/0/kind", "\"loose\""},
    {"/golden/tolerances/0/dt_s", "11"},
    {"/golden/tolerances/1/dv", "1"},
    {"/expectations/15/value", nullptr},
    {"/expectations/15/value", "\"force('wrist')\""},
    {"/expectations/15/share", "0"},
    {"/expectations/15/share", "1.1"},
    {"/expectations/15/during", "\"\""},
    {"/expectations/15/mean_at_most", "\"5\""},
    {"/expectations/16/times", "1"},
    {"/expectations/16/at_least", "-1"},
    {"/expectations/16/to_s", "4000"},
    {"/expectations/17/event", nullptr},
    {"/expectations/18/events", "[]"},
    {"/expectations/18/events/1/within_s", "-1"},
    {"/expectations/18/events/1/text", nullptr},
    {"/expectations/19/only", nullptr},
    {"/expectations/19/only/0", "[\"probe\"]"},
};
INSTANTIATE_TEST_SUITE_P(Each, ScenarioMistake, testing::ValuesIn(kMistakes));

TEST(ScenarioSchema, EveryScenarioFits) {
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator("scenarios")) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(".json") || name.ends_with(".golden.json") || name.ends_with(".map.json")) continue;
    const Json json = Json::parse(text_of(entry.path()));
    if (json.contains("primitives")) continue;  // a net
    EXPECT_TRUE(schema().accepts(json)) << entry.path();
    EXPECT_TRUE(read_description(entry.path()).has_value()) << entry.path();
    ++count;
  }
  EXPECT_GT(count, 0);
}

/// The complete file of the tutorial: form, models, and a rehearsal of its program.
TEST(ScenarioSchema, TheFileOfTheTutorialIsReadyToRun) {
  const std::string page = text_of("docs/tutorial.md");
  const std::size_t fence = page.rfind("```json\n");
  ASSERT_NE(fence, std::string::npos);
  const std::size_t begin = fence + 8;
  const std::string example = page.substr(begin, page.find("```", begin) - begin);
  EXPECT_TRUE(schema().accepts(Json::parse(example)));
  auto description = parse_description(example);
  ASSERT_TRUE(description.has_value()) << description.error().to_string();
  const auto session = Session::create(std::move(*description), models());
  ASSERT_TRUE(session.has_value()) << session.error().to_string();
  EXPECT_EQ((*session)->warnings().to_string(), "");
}

}  // namespace
}  // namespace takt::cell::schema_test
