// URScript programs in a cell: the same commands as the steps that they stand for, the same again, and what is refused.
#include <cmath>
#include <fstream>
#include <numbers>
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

/// An arm with a force/torque sensor over a plate, a lamp, and channels.
Json script_cell(Json program) {
  return {{"title", "URScript"},
          {"time_limit_s", 30},
          {"devices",
           {{"arm", {{"model", "lwr4plus"}, {"at", {{"in", "world"}}}}},
            {"io",
             {{"model", "io_block"},
              {"at", {{"in", "world"}, {"position_m", {-1, 1, 0}}}},
              {"settings", {{"do1", {{"name", "lamp"}}}}}}}}},
          {"channels",
           {{"pose", {{"type", "Frame"}}},
            {"velocity", {{"type", "Twist"}, {"unit", "m/s,rad/s"}}},
            {"enable", {{"type", "Boolean"}}}}},
          {"program", std::move(program)},
          {"expectations", Json::array()}};
}

Json urscript(const std::string& source) {
  return {{"do", "urscript"},
          {"program", {{"file", "main.script"}, {"source", source}}},
          {"map",
           {{"outputs", {{"1", "io/lamp"}}},
            {"channels", {{"pose", "pose"}, {"velocity", "velocity"}, {"enable", "enable"}}}}}};
}

Description described(const std::string& source) { return parsed(script_cell(urscript(source)).dump()); }

/// Where the tool was sent last.
Eigen::Vector3d tool_of(const Ran& ran) {
  const auto& arm = ran.cell().arms.at("arm");
  return expression::tool_pose(arm, arm.set_point()).translation();
}

constexpr const char* kPath = R"(def main():
  movej([0.3, -0.5, 0, 1.2, 0, -1.0, 0], v=0.8)
  movej(p[0.5, 0.2, 0.5, 0, 3.141592653589793, 0], v=0.8)
  movel(p[0.5, -0.1, 0.5, 0, 3.141592653589793, 0], v=0.2, r=0.03)
  x = 0.4
  movel(p[x, -0.1, 0.4, 0, 3.141592653589793, 0], v=0.2)
  set_digital_out(1, True)
  movec(p[0.45, -0.05, 0.4, 0, 3.141592653589793, 0], p[0.5, -0.1, 0.4, 0, 3.141592653589793, 0], v=0.2)
end
)";

/// The same as steps; the fastest joint of the arm has 204 degrees per second.
Json twin_of_path(double fastest) {
  const double degree = 180.0 / std::numbers::pi;
  Json joints = Json::array();
  for (const double q : {0.3, -0.5, 0.0, 1.2, 0.0, -1.0, 0.0}) joints.push_back(q * degree);
  const auto down = [](double x, double y, double z) {
    return Json{{"in", "arm"}, {"position_m", {x, y, z}}, {"rpy_deg", {0, 180, 0}}};
  };
  Json steps = Json::array();
  steps.push_back({{"do", "ptp"}, {"to", {{"joints_deg", joints}}}, {"speed", 0.8 / fastest}});
  steps.push_back({{"do", "ptp"}, {"to", down(0.5, 0.2, 0.5)}, {"speed", 0.8 / fastest}});
  steps.push_back({{"do", "lin"}, {"to", down(0.5, -0.1, 0.5)}, {"velocity_m_s", 0.2}, {"blend_m", 0.03}});
  steps.push_back({{"do", "lin"}, {"to", down(0.4, -0.1, 0.4)}, {"velocity_m_s", 0.2}});
  steps.push_back({{"do", "set"}, {"output", "io/lamp"}, {"value", true}});
  steps.push_back(
      {{"do", "circ"}, {"via", down(0.45, -0.05, 0.4)}, {"to", down(0.5, -0.1, 0.4)}, {"velocity_m_s", 0.2}});
  return {{"do", "sequence"}, {"steps", steps}};
}

TEST(UrscriptProgram, CommandsWhatItsTwinInStepsCommands) {
  const takt::test::ScratchFolder folder;
  RunOptions a_options, b_options;
  a_options.record = (folder / "script.mcap").string();
  b_options.record = (folder / "steps.mcap").string();
  const Ran a = run_kept(described(kPath), a_options);
  expect_passed(a.report);
  const double fastest = a.cell().arms.at("arm").device->description().limits.velocity.maxCoeff();
  const RunReport b = run(parsed(script_cell(twin_of_path(fastest)).dump()), b_options);
  expect_passed(b);
  EXPECT_EQ(a.report.cycles, b.cycles);
  const auto comparison = record::compare_recordings(folder / "script.mcap", folder / "steps.mcap");
  ASSERT_TRUE(comparison) << comparison.error().to_string();
  int joints = 0;
  for (const auto& column : comparison->columns) {
    if (column.unit != "rad") continue;
    ++joints;
    EXPECT_LT(column.max_difference, 1e-6) << column.topic << " " << column.column;
  }
  EXPECT_GE(joints, 7);
}

TEST(UrscriptProgram, RunsTheSameAgain) {
  const Description description = described(kPath);
  const RunReport first = run(description), second = run(description);
  expect_passed(first);
  EXPECT_EQ(first.digest, second.digest);
}

TEST(UrscriptProgram, SaysBeforeTheRunWhatCannotBeReached) {
  const Diagnostics wrong = refusal(described("x = 1\n\n  movel(p[5, 0, 0, 0, 0, 0])\n"));
  ASSERT_TRUE(wrong.has_errors());
  EXPECT_EQ(wrong.list().front().code, Code::kUnreachable) << wrong.to_string();
  EXPECT_EQ(wrong.list().front().file, "main.script");
  EXPECT_EQ(wrong.list().front().line, 3);
  EXPECT_EQ(wrong.list().front().column, 3);
}

TEST(UrscriptProgram, SaysBeforeTheRunWhatNoOperationDoes) {
  const Diagnostics wrong =
      refusal(described("\nforce_mode(p[0,0,0,0,0,0], [1,1,0,0,0,0], [1,1,0,0,0,0], 2, [1,1,1,1,1,1])\n"));
  ASSERT_EQ(wrong.list().size(), 1u) << wrong.to_string();
  EXPECT_EQ(wrong.list().front().code, Code::kNotPossibleNow);
  EXPECT_EQ(wrong.list().front().line, 2);
}

TEST(UrscriptProgram, SaysAllThatIsWrongAtOnce) {
  Json node = urscript(
      "set_digital_out(7, True)\nx = get_digital_in(3)\ny = get_analog_in(0)\n"
      "set_digital_out(7, False)\nspeedl([0,0,0,0,0,0])\n");
  node["map"].erase("channels");
  const Diagnostics wrong = refusal(parsed(script_cell(node).dump()));
  std::vector<std::pair<Code, int>> found;
  for (const Diagnostic& one : wrong.list()) found.emplace_back(one.code, one.line);
  const std::vector<std::pair<Code, int>> wanted{{Code::kUnknownName, 1},
                                                 {Code::kUnknownName, 2},
                                                 {Code::kUnknownName, 3},
                                                 {Code::kMissing, 5},
                                                 {Code::kMissing, 5}};
  EXPECT_EQ(found, wanted) << wrong.to_string();
}

TEST(UrscriptProgram, SaysWhatIsWrongWithItsMap) {
  Json node = urscript("sync()\n");
  node["map"] = {{"inputs", {{"x", "io/lamp"}, {"0", "io/nothing"}}},
                 {"outputs", {{"1", "io/lamp"}, {"2", "io/no lamp"}}},
                 {"frames", {{"home base", "arm"}, {"part", "nowhere"}}},
                 {"tools", {{"part", "hand"}}},
                 {"channels", {{"pose", "velocity"}, {"velocity", "nothing"}}}};
  const Diagnostics wrong = refusal(parsed(script_cell(node).dump()));
  std::map<std::string, Code> found;
  for (const Diagnostic& one : wrong.list()) found[one.pointer] = one.code;
  const std::map<std::string, Code> wanted{
      {"/program/map/inputs/x", Code::kInvalidName},       {"/program/map/inputs/0", Code::kUnknownName},
      {"/program/map/outputs/2", Code::kUnknownName},      {"/program/map/frames/home base", Code::kInvalidName},
      {"/program/map/frames/part", Code::kUnknownName},    {"/program/map/tools/part", Code::kUnknownName},
      {"/program/map/channels/pose", Code::kTypeMismatch}, {"/program/map/channels/velocity", Code::kUnknownName}};
  for (const auto& [pointer, code] : wanted) EXPECT_TRUE(found.contains(pointer) && found[pointer] == code) << pointer;
}

TEST(UrscriptProgram, SaysThatAnArmHasToBeNamed) {
  Json cell = script_cell(urscript("sync()\n"));
  cell["devices"]["other"] = {{"model", "lwr4plus"}, {"at", {{"in", "world"}, {"position_m", {2, 0, 0}}}}};
  const Diagnostics wrong = refusal(parsed(cell.dump()));
  ASSERT_TRUE(wrong.has_errors());
  EXPECT_EQ(wrong.list().front().code, Code::kMissing);
}

TEST(UrscriptProgram, AThreadWritesAnOutputWhileTheArmMoves) {
  Json cell = script_cell(urscript(R"(def main():
  thread lamp():
    sleep(0.2)
    set_digital_out(1, True)
    sleep(0.2)
    set_digital_out(1, False)
  end
  t = run lamp()
  movej([0.8, -0.5, 0, 1.2, 0, -1.0, 0])
end
)"));
  cell["expectations"] =
      Json::parse(R"([{"name": "lamp", "kind": "signal", "signal": "io/lamp", "is": false, "rises": 1}])");
  expect_passed(run(parsed(cell.dump())));
}

TEST(UrscriptProgram, TwoThreadsThatMoveAreAnError) {
  const RunReport report = run(described(R"(def main():
  thread mover():
    movej([0.8, -0.5, 0, 1.2, 0, -1.0, 0])
  end
  run mover()
  sync()
  movej([0.2, -0.5, 0, 1.2, 0, -1.0, 0])
end
)"));
  EXPECT_NE(report.verdict, Verdict::kPassed);
  ASSERT_TRUE(report.diagnostics.has_errors());
  EXPECT_EQ(report.diagnostics.list().front().line, 7);
}

TEST(UrscriptProgram, AMotionTakesTheTimeThatItIsGiven) {
  const RunReport report =
      run(described("movej([0.3, -0.5, 0, 1.2, 0, -1.0, 0])\n"
                    "begun = time()\n"
                    "movej([0.6, -0.5, 0, 1.2, 0, -1.0, 0], t=2.5)\n"
                    "took = time() - begun\n"
                    "if took < 2.49 or took > 2.52:\n  textmsg(took)\n  x = 1 / 0\nend\n"
                    "begun = time()\n"
                    "movel(pose_add(get_target_tcp_pose(), p[0, 0, 0.1, 0, 0, 0]), t=1.5)\n"
                    "took = time() - begun\n"
                    "if took < 1.49 or took > 1.52:\n  textmsg(took)\n  x = 1 / 0\nend\n"));
  expect_passed(report);
}

TEST(UrscriptProgram, AMotionThatCannotTakeSoShortIsRefused) {
  const Diagnostics wrong = refusal(described("movej([1.5, -0.5, 0, 1.2, 0, -1.0, 0], t=0.1)\n"));
  ASSERT_TRUE(wrong.has_errors());
  EXPECT_EQ(wrong.list().front().line, 1);
}

TEST(UrscriptProgram, HaltEndsTheProgramInOrder) {
  const Ran ran = run_kept(described("movej([0.3, -0.5, 0, 1.2, 0, -1.0, 0])\nhalt\nmovej([1, 0, 0, 1, 0, -1, 0])\n"));
  EXPECT_NEAR(ran.cell().arms.at("arm").set_point()[0], 0.3, 1e-6);
}

TEST(UrscriptProgram, BeginsAtALineWithItsVariables) {
  RunOptions options;
  options.from = "4";
  const Ran ran = run_kept(described("a = 0.3\nb = [a, -0.5, 0, 1.2, 0, -1.0, 0]\nmovej([1, 0, 0, 1, 0, -1, 0])\n"
                                     "movej(b)\n"),
                           options);
  expect_passed(ran.report);
  EXPECT_NEAR(ran.cell().arms.at("arm").set_point()[0], 0.3, 1e-6);
  EXPECT_LT(ran.report.cycles, 4000);
}

TEST(UrscriptProgram, MovesTheToolWithAVelocityAndStops) {
  const std::string start = "movej([0.3, -0.5, 0, 1.2, 0, -1.0, 0])\n";
  const Ran before = run_kept(described(start));
  const Ran after = run_kept(described(start + "speedl([0, 0, 0.05, 0, 0, 0], 0.5, 1.0)\nstopl(1)\n"));
  expect_passed(after.report);
  const Eigen::Vector3d way = tool_of(after) - tool_of(before);
  EXPECT_GT(way.z(), 0.03);
  EXPECT_LT(way.z(), 0.06);
  EXPECT_LT(way.head<2>().norm(), 0.001);
}

TEST(UrscriptProgram, TheToolFollowsPoses) {
  const std::string start = "movej([0.3, -0.5, 0, 1.2, 0, -1.0, 0])\n";
  const Ran before = run_kept(described(start));
  const Ran after = run_kept(described(start + R"(begin = get_target_tcp_pose()
i = 0
while i < 200:
  i = i + 1
  servoj(pose_add(begin, p[0, 0, 0.0002 * i, 0, 0, 0]), t=0.008)
end
sleep(0.3)
stopj(2)
)"));
  expect_passed(after.report);
  const Eigen::Vector3d way = tool_of(after) - tool_of(before);
  EXPECT_NEAR(way.z(), 0.04, 0.001);
  EXPECT_LT(way.head<2>().norm(), 0.001);
}

TEST(UrscriptProgram, IsLedByHandForAWhile) {
  expect_passed(
      run(described("freedrive_mode()\nsleep(0.5)\nend_freedrive_mode()\n"
                    "movej([0.3, -0.5, 0, 1.2, 0, -1.0, 0])\n")));
}

/// A probe on a force/torque sensor over a plate.
Json probing_cell(const std::string& source) {
  Json cell = script_cell({{"do", "urscript"},
                           {"program", {{"file", "main.script"}, {"source", source}}},
                           {"map", {{"frames", {{"plate", "plate"}}}, {"force", {{"travel_m", 0.06}}}}}});
  cell["devices"] = {{"arm", {{"model", "lwr4plus"}, {"at", {{"in", "world"}, {"position_m", {0, 0, 0.75}}}}}},
                     {"wrist", {{"model", "ft_gamma"}, {"on", "arm"}}},
                     {"probe", {{"model", "probe_ball"}, {"on", "wrist"}}}};
  cell["objects"] = {
      {"plate",
       {{"shape", "box"}, {"size_m", {0.2, 0.2, 0.03}}, {"at", {{"in", "world"}, {"position_m", {0.56, 0, 0.765}}}}}}};
  cell["collisions"] = {
      {"allow", Json::array({{{"between", {"probe", "plate"}}, {"reason", "the probe presses on the plate"}}})}};
  cell["expectations"] = Json::parse(R"([{"name": "pressed", "kind": "contact_force", "between": ["probe", "plate"],
                                          "below_N": 14, "at_least_N": 7}])");
  return cell;
}

TEST(UrscriptProgram, PressesAlongAnAxisAndHoldsTheForceOnALine) {
  const RunReport report = run(parsed(probing_cell(R"(def main():
  movej(pose_trans(plate, p[0, -0.03, 0.03, 3.141592653589793, 0, 0]), v=1)
  zero_ftsensor()
  force_mode(p[0, 0, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], [0, 0, -8, 0, 0, 0], 2, [1, 1, 0.005, 1, 1, 1])
  sleep(6)
  down = get_target_tcp_pose()
  movel(pose_add(p[0, 0.04, 0, 0, 0, 0], down), v=0.01)
  end_force_mode()
  movel(pose_trans(plate, p[0, 0.01, 0.05, 3.141592653589793, 0, 0]))
end
)")
                                          .dump()));
  expect_passed(report);
}

TEST(UrscriptProgram, LoopsWithoutTimeAndEndlessTextsEndWithAMessage) {
  for (const char* source : {"while True:\n  x = 1\nend\n", "l = [1]\nwhile True:\n  l = [l, l]\nend\n",
                             "def main():\n  def f():\n    return 1 + f()\n  end\n  f()\nend\n"}) {
    const Diagnostics wrong = refusal(described(source));
    ASSERT_TRUE(wrong.has_errors()) << source;
    EXPECT_EQ(wrong.list().front().file, "main.script");
    EXPECT_GT(wrong.list().front().line, 0);
  }
}

TEST(UrscriptRobotProgram, IsReadWithItsMap) {
  const takt::test::ScratchFolder folder;
  const auto write = [&](const char* name, const char* text) { std::ofstream(folder / name) << text; };
  write("part.script", "sync()\n");
  write("part.map.json", R"({"outputs": {"1": "io/lamp"}})");
  const auto change = to_override({.file = folder / "part.script", .arm = "arm", .map = ""});
  ASSERT_TRUE(change) << change.error().to_string();
  EXPECT_EQ(change->pointer, "/program");
  const Json node = Json::parse(change->value);
  EXPECT_EQ(node["do"], "urscript");
  EXPECT_EQ(node["program"]["source"], "sync()\n");
  EXPECT_EQ(node["map"]["outputs"]["1"], "io/lamp");
}

}  // namespace
}  // namespace takt::cell::test
