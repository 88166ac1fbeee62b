// Operations by their names (docs/python.md): the activities of the C++ interfaces, to the bit, and what is refused.
#include "app/interfaces/operation_by_name.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cell.h"
#include "app/takt.h"

namespace takt::app {
namespace {

using Json = nlohmann::ordered_json;

const CellOptions kPlain{.set = {{"/expectations", "[]"}}, .quiet = true};

/// The digest of a program in the cell of a scenario.
std::string digest_of(const std::function<void(Cell&)>& program) {
  Cell cell("scenarios/pick.json", kPlain);
  program(cell);
  const RunReport report = cell.finish();
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
  return report.digest;
}

/// The first error of an attempt: its code and where it is.
std::pair<Code, std::string> refusal(const std::function<void()>& attempt) {
  try {
    attempt();
  } catch (const ActivityError& error) {
    return {error.diagnostics().list().front().code, error.diagnostics().list().front().pointer};
  }
  return {Code::kNote, "accepted"};
}

TEST(OperationByName, IsTheActivityOfTheInterfaces) {
  const std::string by_interfaces = digest_of([](Cell& cell) {
    const Actuator arm = cell.arm();
    const State near_part = is_less(cell.distance({"arm"}, {"part"}), 0.05);
    arm.use<MotionInterface>().lin(arm.above("part", 0.12), {.velocity = 0.5, .blend = 0.7}).begin_execute();
    arm.use<MotionInterface>().lin_by({0.0, 0.0, -0.1}, {.linear_velocity = 0.1, .until = near_part}).execute();
    cell.gripper().use<GrippingInterface>().close({.expect = GripParameters::Expect::kNothing}).execute();
    cell.output("io/lamp").use<OutputInterface>().set(true).execute();
  });
  const std::string by_name = digest_of([](Cell& cell) {
    const Actuator arm = cell.arm();
    activity::Runtime& runtime = cell.runtime();
    ProgramValues above{.goals = {{"to", {{operations::Goal::Pose{.in = "arm", .X = arm.above("part", 0.12)}}}}},
                        .blend_time_share = 0.7};
    ProgramValues guarded{.states = {{"until", is_less(cell.distance({"arm"}, {"part"}), 0.05)}}};
    operation_by_name(runtime, Json::parse(R"({"do": "lin", "arm": "arm", "speed": 0.5})"), above).begin_execute();
    execute_by_name(runtime,
                    Json::parse(R"({"do": "lin", "to": {"by_m": [0, 0, -0.1], "in": "arm"}, "velocity_m_s": 0.1})"),
                    guarded);
    execute_by_name(runtime, Json::parse(R"({"do": "grip", "expect": "nothing"})"));
    execute_by_name(runtime, Json::parse(R"({"do": "set", "output": "io/lamp", "value": true})"));
  });
  EXPECT_EQ(by_interfaces, by_name);
}

TEST(OperationByName, CarriesOutWhatIsAStepOnly) {
  Cell cell("scenarios/pick.json", kPlain);
  const std::int64_t before = cell.core().cycle();
  EXPECT_EQ(execute_by_name(cell.runtime(), Json::parse(R"({"do": "wait", "seconds": 0.01})")), nullptr);
  EXPECT_EQ(cell.core().cycle(), before + 10);
  EXPECT_EQ(cell.finish().verdict, Verdict::kPassed);
}

TEST(OperationByName, RefusesWithTheKeyOfTheCall) {
  Cell cell("scenarios/pick.json", kPlain);
  activity::Runtime& runtime = cell.runtime();
  const auto refused = [&](const char* json, const ProgramValues& values = {}) {
    return refusal([&] { execute_by_name(runtime, Json::parse(json), values); });
  };
  using Refusal = std::pair<Code, std::string>;
  const ProgramValues held{.states = {{"until", cell.gripper_is("holding")}}};
  EXPECT_EQ(refused(R"({"do": "liin"})"), Refusal(Code::kUnknownName, "/do"));
  EXPECT_EQ(refused(R"({"do": "lin", "to": "home", "velocity": 1})"), Refusal(Code::kUnknownKey, "/velocity"));
  EXPECT_EQ(refused(R"({"do": "lin"})").first, Code::kMissing);
  EXPECT_EQ(refused(R"({"do": "grip", "force_N": -1})"), Refusal(Code::kOutOfRange, "/force_N"));
  EXPECT_EQ(refused(R"({"do": "grip"})", held), Refusal(Code::kUnknownKey, "/until"));
  EXPECT_EQ(refused(R"({"do": "wait"})", held), Refusal(Code::kUnsupported, "/until"));
  EXPECT_EQ(refused(R"({"do": "motions", "steps": []})").first, Code::kUnsupported);
  EXPECT_EQ(refusal([&] { (void)operation_by_name(runtime, Json::parse(R"({"do": "wait", "seconds": 1})")); }),
            Refusal(Code::kUnsupported, "/do"));
  EXPECT_EQ(refusal([&] { (void)motion_by_name(cell.model(), Json::parse(R"({"do": "grip"})")); }),
            Refusal(Code::kInvalidValue, "/do"));
  EXPECT_TRUE(is_activity("press") && is_activity("spline") && !is_activity("tare") && !is_activity("nothing"));
  EXPECT_EQ(cell.finish().verdict, Verdict::kPassed);
}

}  // namespace
}  // namespace takt::app
