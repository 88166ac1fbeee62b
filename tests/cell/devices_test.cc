// Grippers, signals and beams in whole scenarios.
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/build/cell_builder.h"
#include "cell/run/session.h"
#include "core/kinematics/chain.h"
#include "tests/cell/runs.h"
#include "tests/support/reports.h"
#include "tests/support/scratch_folder.h"

namespace takt::cell::devices_test {
namespace {

using takt::test::Expected;
using takt::test::Reports;
using test::expect_passed;
using test::models;
using test::parsed;
using test::refusal;
using test::run;

Description pick(const std::vector<Override>& overrides = {}) {
  auto description = read_description("scenarios/pick.json", overrides);
  if (!description) {
    ADD_FAILURE() << description.error().to_string();
    return {};
  }
  std::erase_if(description->expectations, [](const auto& one) { return one.kind == "repeats"; });
  return std::move(*description);
}

TEST(Pick, ThePartStandsOnTheBox) { expect_passed(run(pick())); }

TEST(Pick, TooWeakAGripIsSeen) {
  const RunReport report = run(pick({{"/program/steps/2/force_N", "8"}}));
  EXPECT_EQ(report.verdict, Verdict::kFailed) << report.diagnostics.to_string();
  EXPECT_FALSE(report.expectations[0].passed) << report.expectations[0].measured;
}

TEST(Pick, AGripOfNothingFailsTheStep) {
  const RunReport report = run(pick({{"/objects/part/at/position_m", "[0.56, -0.15, 0.78]"},
                                     {"/objects/part/vary", R"({"position_m": [0, 0.2, 0]})"}}));
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.diagnostics, Reports(Code::kConditionNotMet, "/program/steps/2", {"mm"}));
}

TEST(Pick, FiguresBeyondTheGripperAreFoundBeforeTheRun) {
  EXPECT_THAT(refusal(pick({{"/program/steps/2/force_N", "81"}})),
              Reports(Code::kOutOfRange, "/program/steps/2/force_N", {"81"}));
  EXPECT_THAT(refusal(pick({{"/program/steps/7/width_m", "0.2"}})),
              Reports(Code::kOutOfRange, "/program/steps/7/width_m"));
  EXPECT_THAT(refusal(pick({{"/program/steps/2/part", "\"prat\""}})),
              Reports(Code::kUnknownName, "/program/steps/2/part", {"prat", "part"}));
}

/// A motion that watches the grip stops where the part is lost; one that never loses it says so.
TEST(Pick, AMotionMayWatchTheGrip) {
  const Override watch{"/program/steps/4/until", R"({"gripper": "gripper", "is": "lost"})"};
  EXPECT_EQ(run(pick({watch, {"/program/steps/2/force_N", "8"}})).verdict, Verdict::kFailed);
  const RunReport held = run(pick({watch}));
  EXPECT_EQ(held.verdict, Verdict::kError);
  EXPECT_THAT(held.diagnostics, Reports(Code::kConditionNotMet, "/program/steps/4/until"));
}

/// A button pressed by a script, a valve that is read back, a lamp wired to a terminal.
constexpr const char* kTerminals = R"({
  "time_limit_s": 20,
  "devices": {
    "io": {"model": "io_block", "settings": {
      "do1": {"name": "lamp"}, "ao1": {"name": "valve"},
      "di1": {"name": "button", "script": [{"at_s": 0.1, "value": true}, {"at_s": 0.2, "value": false}]},
      "di2": {"name": "lamp seen", "from": "io/lamp"}, "ai1": {"name": "valve seen", "from": "io/valve"}}}
  },
  "program": {"do": "sequence", "steps": [
    {"do": "wait", "until": {"input": "io/button"}, "timeout_s": 1},
    {"do": "set", "output": "io/lamp", "value": true},
    {"do": "wait", "until": {"input": "io/lamp seen"}, "timeout_s": 0.01},
    {"do": "set", "output": "io/valve", "value": 7.5},
    {"do": "wait", "until": {"input": "io/valve seen", "above_V": 7.4}, "timeout_s": 0.01},
    {"do": "wait", "until": {"all": [{"input": "io/button", "is": false}, {"input": "io/valve seen", "below_V": 7.6}]},
     "timeout_s": 1}
  ]},
  "expectations": [
    {"kind": "signal", "signal": "io/lamp seen", "is": true, "rises": 1},
    {"kind": "signal", "signal": "io/button", "is": false, "rises": 1},
    {"kind": "signal", "signal": "io/valve", "at_least": 7.5, "at_most": 7.5},
    {"kind": "duration", "below_s": 0.4}
  ]
})";

TEST(Terminals, ProgramsSetAndWait) {
  const RunReport report = run(parsed(kTerminals));
  expect_passed(report);
  // 7.5 V at 100 V/s: 75 ms that the valve takes; the button is released before.
  EXPECT_GT(report.sim_time, 0.175);
}

TEST(Terminals, AWaitThatEndsInVainFails) {
  Description description = parsed(kTerminals);
  description.program["steps"][0]["timeout_s"] = 0.05;
  const RunReport report = run(std::move(description));
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.diagnostics, Reports(Code::kTimeout, "/program/steps/0/until", {"0.05 s"}));
}

TEST(Terminals, MistakesAreReportedWithTheirLocation) {
  const std::string at = "/devices/io/settings";
  const std::pair<const char*, Expected> mistakes[] = {
      {R"({"do9": {}})", {Code::kUnknownName, at + "/do9", {"do9"}}},
      {R"({"di1": {"from": "nothing"}})", {Code::kUnknownName, at + "/di1", {"nothing"}}},
      {R"({"di1": {"from": "io/ao1"}})", {Code::kUnknownName, at + "/di1", {"io/ao1"}}},
      {R"({"do1": {"from": "io/do2"}})", {Code::kUnknownKey, at + "/do1/from", {"from"}}},
      {R"({"do1": {"name": "do2"}})", {Code::kDuplicate, at + "/do2", {"do2"}}},
      {R"({"di1": {"script": [{"at_s": 1, "value": true}, {"at_s": 0.5, "value": false}]}})",
       {Code::kOutOfRange, at + "/di1/script/1/at_s"}},
      {R"({"di1": {"from": "io/do1", "script": []}})", {Code::kConflict, at + "/di1/from"}}};
  for (const auto& [settings, expected] : mistakes) {
    Description description = parsed(R"({"devices": {"io": {"model": "io_block"}},
                                        "program": {"do": "wait", "seconds": 0}})");
    description.devices[0].settings = nlohmann::ordered_json::parse(settings);
    EXPECT_THAT(refusal(std::move(description)), Reports(expected)) << settings;
  }
}

TEST(Terminals, MistakesOfAProgramAreFindings) {
  const std::pair<const char*, Expected> mistakes[] = {
      {R"({"do": "set", "output": "io/lmap", "value": true})",
       {Code::kUnknownName, "/program/output", {"io/lmap", "io/lamp"}}},
      {R"({"do": "set", "output": "io/valve", "value": true})", {Code::kOutOfRange, "/program/value", {"true"}}},
      {R"({"do": "set", "output": "io/valve", "value": 11})", {Code::kOutOfRange, "/program/value", {"0", "10 V"}}},
      {R"({"do": "wait", "until": {"input": "io/valve seen", "above_m": 1}})",
       {Code::kUnknownKey, "/program/until/above_m", {"above_V"}}},
      {R"({"do": "wait", "until": {"input": "io/buton"}})",
       {Code::kUnknownName, "/program/until/input", {"io/buton", "io/button"}}},
      {R"({"do": "grip"})", {Code::kMissing, "/program", {"gripper"}}}};
  for (const auto& [program, expected] : mistakes) {
    Description description = parsed(kTerminals);
    description.expectations.clear();
    description.program = nlohmann::ordered_json::parse(program);
    EXPECT_THAT(refusal(std::move(description)), Reports(expected)) << program;
  }
}

/// A range finder below looks up at the flange, which comes down until it is 0.6 m away.
TEST(Beams, AMotionStopsWhereTheRangeFinderSays) {
  const RunReport report = run(parsed(R"({
    "devices": {
      "arm": {"model": "lwr4plus", "at": {"position_m": [0, 0, 0.75]}},
      "finder": {"model": "range_finder", "at": {"position_m": [0.56, 0, 0.45], "rpy_deg": [0, -90, 0]}}
    },
    "program": {"do": "sequence", "steps": [
      {"do": "lin", "name": "down", "to": {"by_m": [0, 0, -0.1]}, "velocity_m_s": 0.05,
       "until": {"input": "finder", "below_m": 0.6}}
    ]},
    "expectations": [{"kind": "signal", "signal": "finder", "at_least": 0.59, "at_most": 0.601}]
  })"));
  expect_passed(report);
}

/// The same finder on the flange: face on face its beam leaves across the flange; turned by a quarter it looks along
/// the flange and sees the plate below.
std::string finder_on_flange(const std::string& mount, double at_least, double at_most) {
  return R"({
    "devices": {
      "arm": {"model": "lwr4plus", "at": {"position_m": [0, 0, 0.75]}},
      "finder": {"model": "range_finder", "on": "arm", "mount": )" +
         mount + R"(}
    },
    "objects": {"plate": {"shape": "box", "size_m": [0.4, 0.4, 0.02], "at": {"position_m": [0.54, 0, 0.5]}}},
    "program": {"do": "wait", "seconds": 0.1},
    "expectations": [{"kind": "signal", "signal": "finder", "at_least": )" +
         std::to_string(at_least) + R"(, "at_most": )" + std::to_string(at_most) + "}]}";
}

TEST(Mounting, ARangeFinderLooksWhereItIsTurnedTo) {
  // Across the flange: away from the arm there is nothing, towards it the arm itself.
  expect_passed(run(parsed(finder_on_flange(R"({"rpy_deg": [0, 0, 180]})", 4.9, 5.1))));
  expect_passed(run(parsed(finder_on_flange("{}", 0.3, 0.6))));
  // Flange at 1.134 m, plate at 0.51; the beam begins 27 mm in front of the base's origin.
  expect_passed(run(parsed(finder_on_flange(R"({"rpy_deg": [0, -90, 0]})", 0.585, 0.605))));
  expect_passed(run(parsed(finder_on_flange(R"({"position_m": [0, 0, 0.1], "rpy_deg": [0, -90, 0]})", 0.485, 0.505))));
}

/// What hangs on a turned sensor is turned with it, for the tool centre point, for the sensor's axes and for its
/// weight.
TEST(Mounting, WhatHangsOnWhatIsTurnedIsTurned) {
  const auto built = [](const std::string& wrist, const std::string& probe) {
    Diagnostics warnings;
    auto cell = build_cell(parsed(R"({"devices": {"arm": {"model": "lwr4plus"},
        "wrist": {"model": "ft_gamma", "on": "arm", "mount": )" +
                                  wrist + R"(}, "probe": {"model": "probe_ball", "on": "wrist", "mount": )" + probe +
                                  R"(}}, "program": {"do": "wait", "seconds": 0}})"),
                           models(), false, warnings);
    EXPECT_TRUE(cell) << cell.error().to_string();
    return std::move(*cell);
  };
  const BuiltCell straight = built("{}", "{}");
  const BuiltCell turned =
      built(R"({"rpy_deg": [0, 0, 90]})", R"({"position_m": [0.02, 0, 0], "rpy_deg": [0, 90, 0]})");
  const Eigen::Isometry3d X_FT = straight.cell.arms.at("arm").X_FT, X_FT_turned = turned.cell.arms.at("arm").X_FT;
  const auto quarter = Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ());
  const auto tilt = Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitY());
  EXPECT_TRUE(X_FT_turned.linear().isApprox((quarter * tilt).toRotationMatrix() * X_FT.linear(), 1e-9));
  EXPECT_TRUE(turned.cell.sensors.at("wrist").X_FS.linear().isApprox(
      quarter.toRotationMatrix() * straight.cell.sensors.at("wrist").X_FS.linear(), 1e-9));
  EXPECT_EQ(turned.cell.sensors.at("wrist").tool_mass, straight.cell.sensors.at("wrist").tool_mass);
  // The simulation agrees: its tool centre point is where the kinematics say.
  for (const BuiltCell* cell : {&straight, &turned}) {
    const auto& arm = *cell->cell.arms.at("arm").device;
    const Eigen::Isometry3d X_WT =
        arm.description().chain->forward(arm.description().home) * cell->cell.arms.at("arm").X_FT;
    const Eigen::Isometry3d X_true = cell->world->body_pose(cell->world->body("probe/tcp"));
    EXPECT_TRUE(X_WT.isApprox(X_true, 1e-6)) << X_WT.matrix() << "\n\n" << X_true.matrix();
    EXPECT_NEAR(arm.tool().payload.mass, straight.cell.arms.at("arm").device->tool().payload.mass, 1e-12);
  }
  // The same weight, seen from the flange, in another place.
  EXPECT_GT((turned.cell.arms.at("arm").device->tool().payload.p_FC -
             straight.cell.arms.at("arm").device->tool().payload.p_FC)
                .norm(),
            1e-3);
}

TEST(Mounting, MistakesAreReportedWithTheirLocation) {
  const auto wrong = [](const std::string& finder) {
    const auto description = parse_description(R"({"devices": {"arm": {"model": "lwr4plus"}, "finder": )" + finder +
                                               R"(}, "program": {"do": "wait", "seconds": 0}})");
    return description ? Diagnostics() : description.error();
  };
  EXPECT_THAT(wrong(R"({"model": "range_finder", "mount": {}})"),
              Reports(Code::kMissing, "/devices/finder/mount", {"mount", "on"}));
  EXPECT_THAT(wrong(R"({"model": "range_finder", "on": "arm", "mount": {"rpy": [0, 0, 0]}})"),
              Reports(Code::kUnknownKey, "/devices/finder/mount/rpy"));
  EXPECT_THAT(wrong(R"({"model": "range_finder", "on": "arm", "mount": {"quaternion": [1, 1, 0, 0]}})"),
              Reports(Code::kOutOfRange, "/devices/finder/mount/quaternion"));
}

/// A tool of that mass, made for the test.
class Weight {
 public:
  explicit Weight(double kg) {
    std::filesystem::create_directories(folder_ / "weight");
    std::ofstream(folder_ / "weight/device.json") << R"({"kind": "tool", "name": "weight", "title": "Weight",
        "urdf": "weight.urdf", "base": "base", "tcp": "tcp"})";
    std::ofstream(folder_ / "weight/weight.urdf") << fmt::format(R"(<robot name="weight">
        <link name="base"><inertial><origin xyz="0 0 0.08"/><mass value="{}"/>
          <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <link name="tcp"/>
        <joint name="end" type="fixed"><parent link="base"/><child link="tcp"/><origin xyz="0 0 0.16"/></joint>
        </robot>)",
                                                                 kg);
  }

  /// The session of an arm that carries it and goes from its home to a place, or why there is none.
  [[nodiscard]] Diagnostics refusal(const std::string& arm, const std::string& to) const {
    const device::ModelLibrary library({"models", folder_.path()});
    const auto session = Session::create(parsed(R"({"devices": {"arm": {"model": ")" + arm +
                                                R"("}, "load": {"model": "weight", "on": "arm"}},
        "program": {"do": "ptp", "to": {"joints_deg": )" +
                                                to + "}}}"),
                                         library);
    return session ? Diagnostics() : session.error();
  }

 private:
  takt::test::ScratchFolder folder_{"weight"};
};

TEST(Payload, MoreThanTheArmCarriesIsRefused) {
  const std::string level = "[0, -180, 0, -90, 90, 0]";
  EXPECT_TRUE(Weight(4.9).refusal("ur5", level).empty());
  EXPECT_THAT(Weight(5.1).refusal("ur5", level),
              Reports(Code::kLimitExceeded, "/devices/arm", {"arm", "5.10 kg", "5 kg", "payload_max_kg", "ur5"}));
}

/// Twenty kilograms are within what a TX90 may carry, but not at arm's length: told before anything moves.
TEST(Payload, ALoadThatTheMotorsCannotHoldOnTheWayIsFoundBeforeTheRun) {
  const Weight weight(20.0);
  EXPECT_TRUE(weight.refusal("tx90", "[90, 30, 105, 0, 45, 0]").empty());
  EXPECT_THAT(weight.refusal("tx90", "[0, 90, 0, 0, 0, 0]"),
              Reports(Code::kLimitExceeded, "/program/to", {"20.00 kg", "100 %"}));
}

}  // namespace
}  // namespace takt::cell::devices_test
