// Each kind of expectation in each world in which it may be wrong about a run. A new kind without rows fails the test.
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cell/judge/expectations.h"
#include "cell/run/session.h"
#include "tests/cell/runs.h"

namespace takt::cell::verdict_matrix_test {
namespace {

using test::models;
using test::parsed;

/// What the run is like that an expectation judges.
enum class World { kHolds, kViolated, kSensorDead, kWindowEmpty, kNeverRan };
constexpr World kWorlds[] = {World::kHolds, World::kViolated, World::kSensorDead, World::kWindowEmpty,
                             World::kNeverRan};
const char* name_of(World world) {
  const char* names[] = {"holds", "violated", "sensor dead", "window empty", "step never ran"};
  return names[static_cast<std::size_t>(world)];
}

/// The scenario in which it does.
enum class Bench { kStands, kTouches, kPushed, kNudged, kWelds };

struct Row {
  std::string_view kind;
  World world;
  const char* keys;  ///< of the expectation, without its kind
  bool holds;
  Bench bench = Bench::kStands;
};

/// A world that a kind cannot meet: it has no such keys.
struct Without {
  std::string_view kind;
  World world;
};

// What is judged by the truth of the simulation holds with dead sensors as well: that is what it is for.
constexpr Row kRows[] = {
    {"belief", World::kHolds, R"("frame": "ball", "position_within_m": 0.03)", true},
    {"belief", World::kViolated, R"("frame": "ball", "position_within_m": 0.001)", false},
    {"belief", World::kSensorDead, R"("frame": "ball", "position_within_m": 0.03)", true},

    {"contact_force", World::kHolds, R"("between": ["ball", "plate"], "below_N": 5000, "at_least_N": 1)", true},
    {"contact_force", World::kViolated, R"("between": ["ball", "plate"], "below_N": 1)", false},
    {"contact_force", World::kSensorDead, R"("between": ["ball", "plate"], "below_N": 1)", false},
    {"contact_force", World::kWindowEmpty, R"("between": ["ball", "plate"], "below_N": 5000, "during": "blink")",
     false},
    {"contact_force", World::kNeverRan, R"("between": ["ball", "plate"], "below_N": 5000, "during": "never")", false},

    {"contacts", World::kHolds, R"("only": [["ball", "plate"], ["screw", "floor"]])", true},
    {"contacts", World::kViolated, R"("only": [["screw", "floor"]])", false},
    {"contacts", World::kSensorDead, R"("only": [["screw", "floor"]])", false},

    {"duration", World::kHolds, R"("below_s": 10)", true},
    {"duration", World::kViolated, R"("below_s": 0.1)", false},
    {"duration", World::kWindowEmpty, R"("below_s": 10, "during": "blink")", false},
    {"duration", World::kNeverRan, R"("below_s": 10, "during": "never")", false},
    {"duration", World::kSensorDead, R"("below_s": 10)", true},

    {"estimate", World::kHolds, R"("estimate": "found", "of": "block", "position_within_m": 0.002)", true,
     Bench::kTouches},
    {"estimate", World::kViolated, R"("estimate": "found", "of": "block", "position_within_m": 1e-9)", false,
     Bench::kTouches},
    {"estimate", World::kSensorDead, R"("estimate": "found", "of": "block", "position_within_m": 1)", false,
     Bench::kTouches},

    {"event", World::kHolds, R"("event": "log", "times": 1)", true},
    {"event", World::kViolated, R"("event": "log", "at_most": 0)", false},
    {"event", World::kSensorDead, R"("event": "log", "times": 1)", true},
    {"event", World::kWindowEmpty, R"("event": "log", "at_most": 0, "from_s": 5, "to_s": 6)", false},
    {"event", World::kNeverRan, R"("event": "touch", "at_most": 0, "during": "never")", false},

    {"gripper", World::kHolds, R"("gripper": "hand", "is": "idle")", true},
    {"gripper", World::kViolated, R"("gripper": "hand", "is": "holding")", false},
    {"gripper", World::kSensorDead, R"("gripper": "hand", "is": "idle")", false},

    {"limits", World::kHolds, R"("arm": "arm")", true},
    {"limits", World::kViolated, R"("arm": "arm")", false, Bench::kPushed},
    {"limits", World::kSensorDead, R"("arm": "arm")", true},

    {"mean_force", World::kHolds, R"("between": ["ball", "plate"], "at_least_N": 0.1, "below_N": 500)", true},
    {"mean_force", World::kViolated, R"("between": ["ball", "plate"], "at_least_N": 500, "below_N": 600)", false},
    {"mean_force", World::kSensorDead, R"("between": ["ball", "plate"], "at_least_N": 0.1, "below_N": 500)", true},
    {"mean_force", World::kWindowEmpty, R"("between": ["hand", "plate"], "at_least_N": 0, "below_N": 500)", false},

    {"monitor", World::kHolds, R"("net": "feel", "monitor": "pressed", "is": false)", true},
    {"monitor", World::kViolated, R"("net": "feel", "monitor": "pressed", "is": true)", false},
    {"monitor", World::kSensorDead, R"("net": "feel", "monitor": "pressed", "is": false)", false},
    {"monitor", World::kNeverRan, R"("net": "idle", "monitor": "pressed", "is": false)", false},

    {"object_pose", World::kHolds, R"("object": "plate", "position_m": [0, 2, 0.01], "position_within_m": 1e-4)", true},
    {"object_pose", World::kViolated, R"("object": "plate", "position_m": [0, 2, 0], "position_within_m": 1e-4)",
     false},
    {"object_pose", World::kSensorDead, R"("object": "plate", "position_m": [0, 2, 0.01], "position_within_m": 1e-4)",
     true},
    {"object_pose", World::kWindowEmpty, R"("object": "plate", "position_within_m": 9, "during": "blink")", false},
    {"object_pose", World::kNeverRan, R"("object": "plate", "position_within_m": 9, "during": "never")", false},

    {"order", World::kHolds, R"("events": [{"event": "begin", "text": "first"}, {"event": "begin", "text": "second"}])",
     true},
    {"order", World::kViolated,
     R"("events": [{"event": "begin", "text": "second"}, {"event": "begin", "text": "first"}])", false},
    {"order", World::kSensorDead,
     R"("events": [{"event": "begin", "text": "first"}, {"event": "begin", "text": "second"}])", true},
    {"order", World::kWindowEmpty,
     R"("events": [{"event": "begin", "text": "first"}, {"event": "begin", "text": "second", "within_s": 0}])", false},
    {"order", World::kNeverRan,
     R"("events": [{"event": "begin", "text": "first"}, {"event": "begin", "during": "never"}])", false},

    {"peak_force", World::kHolds, R"("sensor": "wrist", "below_N": 100)", true},
    {"peak_force", World::kViolated, R"("sensor": "wrist", "below_N": 0.1)", false},
    {"peak_force", World::kSensorDead, R"("sensor": "wrist", "below_N": 100)", false},

    {"relative_pose", World::kHolds,
     R"("arms": ["arm", "other"], "from": "first", "to": "second", "position_within_m": 0.01)", true},
    {"relative_pose", World::kViolated,
     R"("arms": ["arm", "other"], "from": "turn", "to": "last", "position_within_m": 0.001)", false},
    {"relative_pose", World::kSensorDead,
     R"("arms": ["arm", "other"], "from": "first", "to": "second", "position_within_m": 0.01)", true},
    {"relative_pose", World::kWindowEmpty,
     R"("arms": ["arm", "other"], "from": "second", "to": "first", "position_within_m": 9)", false},
    {"relative_pose", World::kNeverRan,
     R"("arms": ["arm", "other"], "from": "never", "to": "second", "position_within_m": 9)", false},

    {"repeats", World::kHolds, "", true},
    {"repeats", World::kViolated, "", false, Bench::kNudged},
    {"repeats", World::kSensorDead, "", true},

    {"screw", World::kHolds, R"("screw": "screw", "is": "free")", true},
    {"screw", World::kViolated, R"("screw": "screw", "is": "seated")", false},
    {"screw", World::kSensorDead, R"("screw": "screw", "is": "free")", true},

    {"seam", World::kHolds, R"("object": "part", "line": "edge")", true, Bench::kWelds},
    {"seam", World::kViolated, R"("object": "part", "line": "edge", "length_m": 0.09)", false, Bench::kWelds},
    {"seam", World::kSensorDead, R"("object": "part", "line": "edge")", false, Bench::kWelds},

    {"signal", World::kHolds, R"("signal": "io/button", "is": true, "rises": 1)", true},
    {"signal", World::kViolated, R"("signal": "io/button", "is": false)", false},
    {"signal", World::kSensorDead, R"("signal": "io/button", "rises": 0)", false},

    {"step", World::kHolds, R"("step": "first")", true},
    {"step", World::kViolated, R"("step": "never")", false},
    {"step", World::kSensorDead, R"("step": "first")", true},
    {"step", World::kNeverRan, R"("step": "never")", false},

    {"tool_pose", World::kHolds, R"("arm": "other", "position_within_m": 9)", true},
    {"tool_pose", World::kViolated, R"("arm": "other", "position_within_m": 0.1)", false},
    {"tool_pose", World::kSensorDead, R"("arm": "other", "position_within_m": 9)", true},
    {"tool_pose", World::kWindowEmpty, R"("arm": "other", "position_within_m": 9, "during": "blink")", false},
    {"tool_pose", World::kNeverRan, R"("arm": "other", "position_within_m": 9, "during": "never")", false},

    {"value", World::kHolds, R"json("value": "$force('wrist')", "at_most": 100, "mean_at_most": 100,
      "during": "second")json",
     true},
    {"value", World::kViolated, R"json("value": "$force('wrist')", "at_most": 0.1, "during": "second")json", false},
    {"value", World::kSensorDead, R"json("value": "$force('wrist')", "mean_at_most": 100)json", false},
    {"value", World::kWindowEmpty, R"json("value": "$time()", "at_least": 0, "during": "first", "from_s": 3)json",
     false},
    {"value", World::kNeverRan, R"json("value": "$time()", "at_least": 0, "during": "never")json", false},
};

constexpr Without kWithout[] = {
    {"belief", World::kWindowEmpty},     {"belief", World::kNeverRan},      {"contacts", World::kWindowEmpty},
    {"contacts", World::kNeverRan},      {"estimate", World::kWindowEmpty}, {"estimate", World::kNeverRan},
    {"gripper", World::kWindowEmpty},    {"gripper", World::kNeverRan},     {"limits", World::kWindowEmpty},
    {"limits", World::kNeverRan},        {"mean_force", World::kNeverRan},  {"monitor", World::kWindowEmpty},
    {"peak_force", World::kWindowEmpty}, {"peak_force", World::kNeverRan},  {"repeats", World::kWindowEmpty},
    {"repeats", World::kNeverRan},       {"screw", World::kWindowEmpty},    {"screw", World::kNeverRan},
    {"signal", World::kWindowEmpty},     {"signal", World::kNeverRan},      {"step", World::kWindowEmpty},
    {"seam", World::kWindowEmpty},       {"seam", World::kNeverRan},
};

std::string expectation(const Row& row) {
  const std::string keys = row.keys;
  return R"({"kind": ")" + std::string(row.kind) + "\"" + (keys.empty() ? "" : ", ") + keys + "}";
}

constexpr const char* kDead = R"(
    {"do": "sensor", "at_s": 0, "sensor": "wrist", "fault": "silent"},
    {"do": "sensor", "at_s": 0, "sensor": "io/button", "fault": "silent"},
    {"do": "device", "at_s": 0.3, "device": "hand", "fault": "gone"})";

/// A ball falls on a plate and a screw lies on the floor, while one of two arms turns a little.
std::string standing(const std::string& expectations, const std::string& faults, double time_limit) {
  return R"({"time_limit_s": )" + std::to_string(time_limit) + R"json(, "devices": {
      "arm": {"model": "lwr4plus", "start_deg": [0, -30, 0, 90, 0, -60, 0]},
      "wrist": {"model": "ft_gamma", "on": "arm"}, "hand": {"model": "wsg50", "on": "wrist"},
      "other": {"model": "lwr4plus", "at": {"position_m": [3, 0, 0]}},
      "io": {"model": "io_block", "settings": {"di1": {"name": "button", "script": [{"at_s": 0.6, "value": true}]}}}},
    "objects": {
      "plate": {"shape": "box", "size_m": [0.2, 0.2, 0.02], "at": {"position_m": [0, 2, 0.01]}},
      "ball": {"shape": "sphere", "radius_m": 0.02, "fixed": false, "mass_kg": 0.2,
               "at": {"position_m": [0, 2, 0.06]}},
      "screw": {"screw": {"thread": "M6", "length_m": 0.012},
                "at": {"position_m": [1, 2, 0.05], "rpy_deg": [90, 0, 0]}}},
    "nets": {
      "feel": {"primitives": [
          {"id": "button", "type": "DigitalInput", "parameters": {"device": "io/button"}},
          {"id": "pressed", "type": "MonitorBoolean"},
          {"id": "end", "type": "Termination", "parameters": {"condition": true}}],
        "links": [{"from": "button.value", "to": "pressed.value"}]},
      "idle": {"primitives": [
          {"id": "button", "type": "DigitalInput", "parameters": {"device": "io/button"}},
          {"id": "pressed", "type": "MonitorBoolean"},
          {"id": "end", "type": "Termination", "parameters": {"condition": true}}],
        "links": [{"from": "button.value", "to": "pressed.value"}]}},
    "program": {"do": "sequence", "steps": [
      {"do": "wait", "name": "first", "seconds": 0.2},
      {"do": "net", "name": "feel", "net": "feel"},
      {"do": "branch", "cases": [{"when": "$time() < 0[s]", "steps": [
        {"do": "wait", "name": "never", "seconds": 0.1}, {"do": "net", "net": "idle"}]}]},
      {"do": "log", "name": "blink", "text": "here"},
      {"do": "wait", "name": "second", "seconds": 0.2},
      {"do": "ptp", "name": "turn", "arm": "arm", "to": {"joints_deg": [3, -30, 0, 90, 0, -60, 0]}},
      {"do": "wait", "name": "last", "seconds": 0.2}]},
    "faults": [)json" +
         faults + R"(], "expectations": [)" + expectations + "]}";
}

/// A probe finds the height of a block.
std::string touching(const std::string& expectations, const std::string& faults, double time_limit) {
  return R"({"time_limit_s": )" + std::to_string(time_limit) + R"json(, "devices": {
      "arm": {"model": "lwr4plus", "start_deg": [0, -30, 0, 90, 0, -60, 0]},
      "wrist": {"model": "ft_gamma", "on": "arm"}, "probe": {"model": "probe_ball", "on": "wrist"}},
    "objects": {"block": {"shape": "box", "size_m": [0.4, 0.4, 0.2], "at": {"position_m": [0.55, 0, 0.1]}}},
    "program": {"do": "sequence", "steps": [
      {"do": "ptp", "name": "above", "to": {"in": "block", "position_m": [0, 0, 0.12], "rpy_deg": [180, 0, 0]}},
      {"do": "tare"},
      {"do": "lin", "name": "touch", "to": {"by_m": [0, 0, -0.03]}, "velocity_m_s": 0.02,
       "until": {"sensor": "wrist", "above_N": 5}},
      {"do": "record_contact", "as": "top"},
      {"do": "fit_pose", "object": "block", "as": "found", "contacts": ["top"], "free": ["z"]}]},
    "faults": [)json" +
         faults + R"(], "expectations": [)" + expectations + "]}";
}

/// A torch welds a line of 40 mm; where its input is silent it does not.
std::string welding(const std::string& expectations, const std::string& faults, double time_limit) {
  return R"({"time_limit_s": )" + std::to_string(time_limit) + R"json(, "devices": {
      "arm": {"model": "ur5"}, "torch": {"model": "torch_mig", "on": "arm"}},
    "objects": {"part": {"shape": "box", "size_m": [0.2, 0.2, 0.02], "at": {"position_m": [0.55, 0, 0.02]},
      "lines": {"edge": {"points": [{"position_m": [0, -0.02, 0.01]}, {"position_m": [0, 0.02, 0.01]}]}}}},
    "program": {"do": "sequence", "steps": [
      {"do": "ptp", "to": {"in": "part/edge/1", "position_m": [0, 0, -0.1], "rpy_deg": [0, 0, 0]}},
      {"do": "try", "steps": [{"do": "weld", "workpiece": "part", "line": "edge", "travel_m_s": 0.02}],
       "on_error": {"steps": []}}]},
    "faults": [)json" +
         faults + R"(], "expectations": [)" + expectations + "]}";
}

/// An arm that stands, and is pushed as options_of() says.
std::string pushed(const std::string& expectations, const std::string&, double time_limit) {
  return R"({"time_limit_s": )" + std::to_string(time_limit) + R"json(, "devices": {"arm": {"model": "lwr4plus"}},
    "program": {"do": "wait", "name": "first", "seconds": 0.3}, "expectations": [)json" +
         expectations + "]}";
}

Description bench_of(Bench bench, const std::string& expectations, const std::string& faults, double time_limit = 30) {
  const auto make = bench == Bench::kTouches  ? touching
                    : bench == Bench::kStands ? standing
                    : bench == Bench::kWelds  ? welding
                                              : pushed;
  const char* const dead = bench == Bench::kWelds
                               ? R"({"do": "sensor", "at_s": 0, "sensor": "torch/established", "fault": "silent"})"
                               : R"({"do": "sensor", "at_s": 0, "sensor": "wrist", "fault": "silent"})";
  const bool of_its_own = (bench == Bench::kTouches || bench == Bench::kWelds) && !faults.empty();
  Description description = parsed(make(expectations, of_its_own ? dead : faults, time_limit));
  return description;
}

/// A blow that no motor withstands, or a touch; a second run gets neither.
RunOptions options_of(Bench bench) {
  RunOptions options;
  if (bench != Bench::kPushed && bench != Bench::kNudged) return options;
  options.after_cycle = [force = bench == Bench::kPushed ? 4000.0 : 1.0](BuiltCell& built) {
    const bool now = built.core->cycle() > 100 && built.core->cycle() < 120;
    built.world->push(built.world->body("arm/link7"), {0.0, now ? force : 0.0, 0.0});
    return true;
  };
  return options;
}

std::vector<Row> rows_of(World world, Bench bench) {
  std::vector<Row> rows;
  for (const Row& row : kRows)
    if (row.world == world && row.bench == bench) rows.push_back(row);
  return rows;
}

std::string list_of(const std::vector<Row>& rows) {
  std::string list;
  for (const Row& row : rows) list += (list.empty() ? "" : ",\n") + expectation(row);
  return list;
}

bool has_row(std::string_view kind, World world) {
  return std::ranges::any_of(kRows, [=](const Row& row) { return row.kind == kind && row.world == world; });
}

bool is_without(std::string_view kind, World world) {
  return std::ranges::any_of(kWithout, [=](const Without& one) { return one.kind == kind && one.world == world; });
}

TEST(VerdictMatrix, EachKindHasARowForEachWorld) {
  for (const ExpectationKind& kind : ExpectationKind::registry().all())
    for (const World world : kWorlds)
      EXPECT_NE(has_row(kind.name, world), is_without(kind.name, world)) << kind.name << ", " << name_of(world);
}

/// A kind that may look at a part of a run has to say what an empty part is.
TEST(VerdictMatrix, OnlyKindsWithoutAWindowAreWithoutItsRows) {
  for (const ExpectationKind& kind : ExpectationKind::registry().all()) {
    const bool windowed =
        std::ranges::any_of(kind.form.keys, [](const Key& key) { return key.name == "during" || key.name == "from"; });
    if (!windowed) continue;
    EXPECT_TRUE(has_row(kind.name, World::kWindowEmpty)) << kind.name;
    EXPECT_TRUE(has_row(kind.name, World::kNeverRan)) << kind.name;
  }
}

class VerdictMatrix : public testing::TestWithParam<World> {};

TEST_P(VerdictMatrix, JudgesRightly) {
  for (const Bench bench : {Bench::kStands, Bench::kTouches, Bench::kPushed, Bench::kNudged, Bench::kWelds}) {
    const std::vector<Row> rows = rows_of(GetParam(), bench);
    if (rows.empty()) continue;
    const std::string faults = GetParam() == World::kSensorDead ? kDead : "";
    const RunReport report = test::run(bench_of(bench, list_of(rows), faults), options_of(bench));
    ASSERT_EQ(report.expectations.size(), rows.size()) << report.diagnostics.to_string();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const ExpectationResult& result = report.expectations[i];
      EXPECT_EQ(result.passed, rows[i].holds)
          << name_of(GetParam()) << ": " << expectation(rows[i]) << ": " << result.measured;
      EXPECT_TRUE(result.judged) << expectation(rows[i]) << ": " << result.measured;
    }
    if (report.diagnostics.has_errors()) continue;
    const bool all = std::ranges::all_of(rows, &Row::holds);
    EXPECT_EQ(report.verdict, all ? Verdict::kPassed : Verdict::kFailed);
  }
}

INSTANTIATE_TEST_SUITE_P(Each, VerdictMatrix, testing::ValuesIn(kWorlds));

/// Of a run that was cut off no expectation has held, and none that held so far has failed.
TEST(VerdictMatrix, NothingHoldsInARunThatWasCutOff) {
  const std::vector<Row> rows = rows_of(World::kHolds, Bench::kStands);
  const std::atomic<int> stop = 2;
  for (const bool interrupted : {false, true}) {
    RunOptions options;
    if (interrupted) options.interrupt = &stop;
    const RunReport report = test::run(bench_of(Bench::kStands, list_of(rows), "", 0.55), options);
    EXPECT_EQ(report.verdict, interrupted ? Verdict::kInterrupted : Verdict::kError);
    ASSERT_EQ(report.expectations.size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
      EXPECT_FALSE(report.expectations[i].passed) << expectation(rows[i]) << ": " << report.expectations[i].measured;
    const auto duration = std::ranges::find(report.expectations, "duration", &ExpectationResult::kind);
    EXPECT_FALSE(duration->judged) << "it held so far";
  }
}

}  // namespace
}  // namespace takt::cell::verdict_matrix_test
