// KRL programs in a cell: the same commands as the steps that they stand for, the same again, and what is refused.
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cell/file/robot_programs.h"
#include "record/compare.h"
#include "tests/cell/runs.h"
#include "tests/support/scratch_folder.h"

namespace takt::cell::test {
namespace {

using Json = nlohmann::ordered_json;

/// An arm, a lamp and an input, with this program.
Json cell_with(Json program) {
  return {{"title", "KRL"},
          {"time_limit_s", 30},
          {"devices",
           {{"arm", {{"model", "lwr4plus"}, {"at", {{"in", "world"}}}}},
            {"io",
             {{"model", "io_block"},
              {"at", {{"in", "world"}, {"position_m", {-1, 1, 0}}}},
              {"settings", {{"do1", {{"name", "lamp"}}}}}}}}},
          {"program", std::move(program)},
          {"expectations", Json::array()}};
}

Json krl(const std::string& source, const std::string& data = "") {
  return {{"do", "krl"},
          {"program",
           {{"modules", Json::array({{{"name", "MAIN"},
                                      {"file", "main.src"},
                                      {"source", source},
                                      {"data_file", "main.dat"},
                                      {"data", data}}})}}},
          {"map", {{"outputs", {{"1", "io/lamp"}}}}}};
}

constexpr const char* kSource = R"(DEF MAIN()
DECL INT I
FOR I=1 TO 7
  $VEL_AXIS[I]=40
ENDFOR
PTP {A1 20, A2 -30, E1 0, A3 70, A4 0, A5 -60, A6 0}
$VEL.CP=0.2
$APO.CDIS=30
PTP {X 500.0, Y 200.0, Z 500.0, A 0.0, B 180.0, C 0.0}
LIN {X 500.0, Y -100.0, Z 500.0, A 0.0, B 180.0, C 0.0} C_DIS
LIN {X 400.0, Y -100.0, Z 400.0, A 20.0, B 180.0, C 0.0}
$OUT[1]=TRUE
CIRC {X 450.0, Y -50.0, Z 400.0, A 20.0, B 180.0, C 0.0}, {X 500.0, Y -100.0, Z 400.0, A 20.0, B 180.0, C 0.0}
END
)";

const char* const kTwin = R"([
  {"do": "ptp", "to": {"joints_deg": [20, -30, 0, 70, 0, -60, 0]}, "speed": 0.4},
  {"do": "ptp", "to": {"in": "arm", "position_m": [0.5, 0.2, 0.5], "rpy_deg": [0, 180, 0]}, "speed": 0.4},
  {"do": "lin", "to": {"in": "arm", "position_m": [0.5, -0.1, 0.5], "rpy_deg": [0, 180, 0]},
   "velocity_m_s": 0.2, "blend_m": 0.03},
  {"do": "lin", "to": {"in": "arm", "position_m": [0.4, -0.1, 0.4], "rpy_deg": [0, 180, 20]}, "velocity_m_s": 0.2},
  {"do": "set", "output": "io/lamp", "value": true},
  {"do": "circ", "via": {"in": "arm", "position_m": [0.45, -0.05, 0.4], "rpy_deg": [0, 180, 20]},
   "to": {"in": "arm", "position_m": [0.5, -0.1, 0.4], "rpy_deg": [0, 180, 20]}, "velocity_m_s": 0.2}
])";

RunReport recorded(const Json& cell, const std::filesystem::path& file) {
  RunOptions options;
  options.record = file.string();
  return run(parsed(cell.dump()), options);
}

TEST(KrlProgram, CommandsWhatItsTwinInStepsCommands) {
  const takt::test::ScratchFolder folder;
  const RunReport a = recorded(cell_with(krl(kSource)), folder / "krl.mcap");
  const RunReport b = recorded(cell_with({{"do", "sequence"}, {"steps", Json::parse(kTwin)}}), folder / "steps.mcap");
  expect_passed(a);
  expect_passed(b);
  EXPECT_EQ(a.cycles, b.cycles);
  EXPECT_EQ(a.digest, b.digest);
  const auto comparison = record::compare_recordings(folder / "krl.mcap", folder / "steps.mcap");
  ASSERT_TRUE(comparison) << comparison.error().to_string();
  int joints = 0;
  for (const auto& column : comparison->columns) {
    if (column.unit != "rad") continue;
    ++joints;
    EXPECT_LT(column.max_difference, 1e-6) << column.topic << " " << column.column;
  }
  EXPECT_GE(joints, 7);
}

TEST(KrlProgram, RunsTheSameAgain) {
  const Description description = parsed(cell_with(krl(kSource)).dump());
  const RunReport first = run(description), second = run(description);
  expect_passed(first);
  EXPECT_EQ(first.digest, second.digest);
}

TEST(KrlProgram, SaysBeforeTheRunWhatCannotBeReached) {
  const Diagnostics wrong = refusal(parsed(cell_with(krl("DEF MAIN()\n\nLIN {X 5000.0, Y 0.0, Z 0.0}\nEND\n")).dump()));
  ASSERT_TRUE(wrong.has_errors());
  EXPECT_EQ(wrong.list().front().code, Code::kUnreachable);
  EXPECT_EQ(wrong.list().front().file, "main.src");
  EXPECT_EQ(wrong.list().front().line, 3);
}

TEST(KrlProgram, SaysAllThatIsWrongAtOnce) {
  const Diagnostics wrong = refusal(parsed(cell_with(krl("DEF MAIN()\n$OUT[7]=TRUE\nWAIT FOR $IN[9]\nEND\n")).dump()));
  ASSERT_EQ(wrong.list().size(), 2u) << wrong.to_string();
  for (const Diagnostic& one : wrong.list()) EXPECT_EQ(one.code, Code::kUnknownName);
  EXPECT_EQ(wrong.list()[0].line, 2);
  EXPECT_EQ(wrong.list()[1].line, 3);
}

TEST(KrlProgram, SaysThatAnArmHasToBeNamed) {
  Json cell = cell_with(krl("DEF MAIN()\nEND\n"));
  cell["devices"]["other"] = {{"model", "lwr4plus"}, {"at", {{"in", "world"}, {"position_m", {2, 0, 0}}}}};
  const Diagnostics wrong = refusal(parsed(cell.dump()));
  ASSERT_TRUE(wrong.has_errors());
  EXPECT_EQ(wrong.list().front().code, Code::kMissing);
}

TEST(KrlProgram, WritesTheOutputsOfTriggersOnThePath) {
  constexpr const char* kTriggers = R"(DEF MAIN()
PTP {A1 20, A2 -30, E1 0, A3 70, A4 0, A5 -60, A6 0}
$VEL.CP=0.1
PTP {X 500.0, Y 200.0, Z 500.0, A 0.0, B 180.0, C 0.0}
TRIGGER WHEN PATH=-100.0 DELAY=0 DO $OUT[1]=TRUE
TRIGGER WHEN DISTANCE=1 DELAY=0 DO $OUT[1]=FALSE
SLIN {X 500.0, Y -100.0, Z 500.0, A 0.0, B 180.0, C 0.0}
WAIT SEC 0.1
END
)";
  Json cell = cell_with(krl(kTriggers));
  cell["expectations"] =
      Json::parse(R"([{"name": "lamp", "kind": "signal", "signal": "io/lamp", "is": false, "rises": 1}])");
  expect_passed(run(parsed(cell.dump())));
}

TEST(KrlProgram, AnInterruptStopsTheArmAndLeavesTheSearch) {
  constexpr const char* kSearch = R"(DEF MAIN()
INTERRUPT DECL 10 WHEN $OUT[1] DO FOUND()
INTERRUPT ON 10
SEARCH()
END
DEF SEARCH()
PTP {A1 20, A2 -30, E1 0, A3 70, A4 0, A5 -60, A6 0}
CONTINUE
$OUT[1]=TRUE
PTP {A1 -60}
HALT
END
DEF FOUND()
BRAKE
RESUME
END
)";
  const Ran ran = run_kept(parsed(cell_with(krl(kSearch)).dump()));
  expect_passed(ran.report);
  // It did not come to its goal.
  EXPECT_LT(ran.cell().arms.at("arm").set_point()[0], 0.34);
}

TEST(KrlProgram, BeginsAtALine) {
  RunOptions options;
  options.from = "3";
  const Ran ran = run_kept(parsed(cell_with(krl("DEF MAIN()\nPTP {A1 40}\nPTP {A2 -20}\nEND\n")).dump()), options);
  expect_passed(ran.report);
  EXPECT_NEAR(ran.cell().arms.at("arm").set_point()[0], ran.cell().arms.at("arm").start[0], 1e-9);
  EXPECT_NEAR(ran.cell().arms.at("arm").set_point()[1], -20 * M_PI / 180, 1e-6);
}

TEST(RobotProgram, IsReadWithItsDataItsModulesAndItsMap) {
  const takt::test::ScratchFolder folder;
  const auto write = [&](const char* name, const char* text) { std::ofstream(folder / name) << text; };
  write("part.src", "DEF PART()\nHELPER()\nEND\n");
  write("part.dat", "DEFDAT PART\nENDDAT\n");
  write("helper.src", "DEF HELPER()\nEND\n");
  write("$config.dat", "DEFDAT $CONFIG PUBLIC\nDECL INT N=3\nENDDAT\n");
  write("part.map.json", R"({"outputs": {"1": "io/lamp"}})");
  const auto change = to_override({.file = folder / "part.src", .arm = "arm", .map = ""});
  ASSERT_TRUE(change) << change.error().to_string();
  EXPECT_EQ(change->pointer, "/program");
  const Json node = Json::parse(change->value);
  EXPECT_EQ(node["program"]["modules"].size(), 3u);
  EXPECT_EQ(node["map"]["outputs"]["1"], "io/lamp");
  auto refused = to_override({.file = folder / "part.txt", .arm = "", .map = ""});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().list().front().code, Code::kUnsupported);
  refused = to_override({.file = folder / "none.src", .arm = "", .map = ""});
  ASSERT_FALSE(refused);
}

}  // namespace
}  // namespace takt::cell::test
