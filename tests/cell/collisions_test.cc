// Collisions in the rehearsal and in the run, and the distance as a sensor (docs/world.md).
#include <algorithm>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell/run/session.h"
#include "tests/cell/runs.h"
#include "tests/support/reports.h"
#include "tests/support/scenario_names.h"

namespace takt::cell::collisions_test {
namespace {

using takt::test::Reports;
using takt::test::ReportsAnywhere;
using takt::test::Warns;
using test::models;
using test::parsed;
using ::testing::Not;

/// An LWR with a probing ball above a table; a cell is this with more objects, devices and steps.
struct CellText {
  std::string objects = {};     ///< "NAME": {...}, ...
  std::string devices = {};     ///< likewise
  std::string collisions = {};  ///< {...}; empty: the default
  std::string more = {};        ///< "KEY": ..., ...

  [[nodiscard]] std::string with(const std::string& steps) const {
    std::string text = R"({"devices": {
      "arm": {"model": "lwr4plus", "at": {"in": "world"}},
      "wrist": {"model": "ft_gamma", "on": "arm"},
      "probe": {"model": "probe_ball", "on": "wrist"})";
    if (!devices.empty()) text += ", " + devices;
    text += R"(}, "objects": {
      "table": {"shape": "box", "size_m": [0.4, 1.2, 0.05], "at": {"in": "world", "position_m": [0.6, 0, -0.025]}})";
    if (!objects.empty()) text += ", " + objects;
    text += "}";
    if (!collisions.empty()) text += R"(, "collisions": )" + collisions;
    if (!more.empty()) text += ", " + more;
    return text + R"(, "program": {"do": "sequence", "steps": [)" + steps + "]}}";
  }
};

/// What its rehearsal says; empty: all is well.
Diagnostics rehearsed(const std::string& text) {
  auto session = Session::create(parsed(text), models());
  return session ? (*session)->warnings() : session.error();
}

std::string ptp(const std::string& joints_deg, const std::string& more = {}) {
  return fmt::format(R"({{"do": "ptp", "name": "go", "to": {{"joints_deg": [{}]}}{}}})", joints_deg, more);
}

/// The arm, bent over the table, leans forward until its tool is in the table.
const std::string kIntoTable = ptp("0, -75, 0, 75, 0, -30, 0");

// -- In the rehearsal
// --------------------------------------------------------------------------------------------------

TEST(Rehearsal, FindsAnArmThatIsDrivenIntoTheTable) {
  const Diagnostics found = rehearsed(CellText{}.with(kIntoTable));
  EXPECT_THAT(found, Reports(Code::kCollision, "/program/steps/0", {"table", "go", "arm"}));
  // Where in the joints, and how deep.
  EXPECT_THAT(found, Reports(Code::kCollision, "/program/steps/0", {"deg", "mm"}));
}

TEST(Rehearsal, IsSilentWhereThereIsRoom) {
  EXPECT_THAT(rehearsed(CellText{}.with(ptp("30, -30, 0, 90, 0, -60, 0"))), Not(ReportsAnywhere(Code::kCollision)));
}

TEST(Rehearsal, FindsAnArmThatFoldsIntoItself) {
  const auto to = [](const std::string& joints_deg) {
    return rehearsed(R"({"devices": {"arm": {"model": "ur5", "at": {"in": "world"}}}, "program": )" + ptp(joints_deg) +
                     "}");
  };
  EXPECT_THAT(to("0, -90, 170, 0, 0, 0"), Reports(Code::kCollision, "/program", {"arm/link2", "arm/link5", "go"}));
  EXPECT_THAT(to("0, -90, -165, 0, 90, 0"), Reports(Code::kCollision, "/program", {"arm/link1", "arm/link3", "go"}));
  EXPECT_THAT(to("0, -90, 150, -90, -90, 0"), Not(ReportsAnywhere(Code::kCollision)));
}

TEST(Rehearsal, NamesTheMotionOfABlendThatCollides) {
  const std::string away = R"({"do": "ptp", "name": "away", "to": {"joints_deg": [30, -30, 0, 90, 0, -60, 0]},
                               "blend_fraction": 0.2}, )";
  EXPECT_THAT(rehearsed(CellText{}.with(away + kIntoTable)), Reports(Code::kCollision, "/program/steps/1", {"go"}));
}

TEST(Rehearsal, LooksAtCommandsOfATransaction) {
  const std::string steps = R"({"do": "transaction", "name": "both", "commands": {
    "lean": {"do": "ptp", "start": true, "to": {"joints_deg": [0, -75, 0, 75, 0, -30, 0]}}}})";
  EXPECT_THAT(rehearsed(CellText{}.with(steps)),
              Reports(Code::kCollision, "/program/steps/0/commands/lean", {"lean", "table"}));
}

TEST(Rehearsal, WhatOverlapsAtTheStartIsAnError) {
  const CellText cell{
      .objects =
          R"("post": {"shape": "box", "size_m": [0.1, 0.1, 0.4], "at": {"in": "world", "position_m": [0, 0, 0.4]}})"};
  EXPECT_THAT(rehearsed(cell.with(R"({"do": "wait", "seconds": 0.1})")),
              Reports(Code::kCollision, "/objects/post", {"post", "mm"}));
}

TEST(Rehearsal, WhatStandsOnSomethingIsNone) {
  const CellText cell{.objects = R"(
    "block": {"shape": "box", "size_m": [0.05, 0.05, 0.05], "fixed": false, "mass_kg": 0.2,
              "at": {"in": "world", "position_m": [0.6, 0.3, 0.025]}},
    "shelf": {"shape": "box", "size_m": [0.2, 0.2, 0.1], "at": {"in": "world", "position_m": [0.6, -0.4, 0.02]}})"};
  EXPECT_THAT(rehearsed(cell.with(R"({"do": "wait", "seconds": 0.1})")), Not(ReportsAnywhere(Code::kCollision)));
}

// -- Contacts that steps mean
// ------------------------------------------------------------------------------------------

const std::string kAbove = R"({"do": "ptp", "name": "above", "to": {"in": "world", "position_m": [0.55, 0, 0.03],
                               "rpy_deg": [180, 0, 0]}}, )";

TEST(MeantContacts, AGuardedMotionMayTouchAndTheNextOneMayPart) {
  const std::string touch = R"({"do": "lin", "name": "touch", "to": {"by_m": [0, 0, -0.07]}, "velocity_m_s": 0.01,
                                "until": {"sensor": "wrist", "above_N": 5}}, )";
  const std::string up = R"({"do": "lin", "name": "up", "to": {"by_m": [0, 0, 0.09]}})";
  EXPECT_THAT(rehearsed(CellText{}.with(kAbove + touch + up)), Not(ReportsAnywhere(Code::kCollision)));
  // Not guarded, the same motion is none that may touch.
  const std::string hit = R"({"do": "lin", "name": "hit", "to": {"by_m": [0, 0, -0.07]}, "velocity_m_s": 0.01})";
  EXPECT_THAT(rehearsed(CellText{}.with(kAbove + hit)), Reports(Code::kCollision, "/program/steps/1", {"hit"}));
}

TEST(MeantContacts, AGuardedMotionMayNotTouchWithTheArm) {
  // A post beside the wrist: the arm's links meet it while the probe is far from everything.
  const CellText cell{.objects = R"("post": {"shape": "box", "size_m": [0.05, 0.05, 0.9],
                             "at": {"in": "world", "position_m": [0.2, 0.23, 0.45]}})"};
  const std::string swing =
      ptp("90, -30, 0, 90, 0, -60, 0", R"(, "until": {"sensor": "wrist", "above_N": 5}, "on_end": "continue")");
  EXPECT_THAT(rehearsed(cell.with(swing)), Reports(Code::kCollision, "/program/steps/0", {"post"}));
}

TEST(MeantContacts, PairsThatTheFileAllowsAreNotChecked) {
  const std::string allowed = R"({"allow": [{"between": ["table", "probe"], "reason": "a soft table"},
    {"between": ["table", "wrist"], "reason": "likewise"}, {"between": ["table", "arm"], "reason": "likewise"},
    {"between": ["floor", "arm"], "reason": "likewise"}, {"between": ["floor", "wrist"], "reason": "likewise"},
    {"between": ["floor", "probe"], "reason": "likewise"}]})";
  EXPECT_THAT(rehearsed(CellText{.collisions = allowed}.with(kIntoTable)), Not(ReportsAnywhere(Code::kCollision)));
  EXPECT_THAT(rehearsed(CellText{.collisions = R"({"off": "it is an experiment"})"}.with(kIntoTable)),
              Not(ReportsAnywhere(Code::kCollision)));
}

TEST(MeantContacts, TheFileSaysWhyAndNamesWhatThereIs) {
  const auto of = [](const char* collisions) {
    const auto description = parse_description(CellText{.collisions = collisions}.with(""));
    return description ? rehearsed(CellText{.collisions = collisions}.with("")) : description.error();
  };
  EXPECT_THAT(of(R"({"allow": [{"between": ["table", "arm"]}]})"),
              Reports(Code::kMissing, "/collisions/allow/0", {"reason"}));
  EXPECT_THAT(of(R"({"off": ""})"), Reports(Code::kWrongType, "/collisions/off"));
  EXPECT_THAT(of(R"({"allow": [{"between": ["table"], "reason": "?"}]})"),
              Reports(Code::kWrongSize, "/collisions/allow/0/between"));
  EXPECT_THAT(of(R"({"allow": [{"between": ["tabel", "arm"], "reason": "?"}]})"),
              Reports(Code::kUnknownName, "/collisions/allow/0/between/0", {"tabel", "table"}));
  EXPECT_THAT(of(R"({"margin_m": -1})"), Reports(Code::kOutOfRange, "/collisions/margin_m"));
}

// -- Parts, neighbours, bases
// ------------------------------------------------------------------------------------------

/// An arm with a gripper that carries a part over a fence. @param fence  its height, m
std::string carrying(double fence) {
  return fmt::format(R"({{"devices": {{
      "arm": {{"model": "lwr4plus", "at": {{"in": "world"}}}},
      "gripper": {{"model": "wsg50", "on": "arm"}}}},
    "objects": {{
      "table": {{"shape": "box", "size_m": [0.4, 1.2, 0.05],
                "at": {{"in": "world", "position_m": [0.6, 0, -0.025]}}}},
      "part": {{"shape": "box", "size_m": [0.03, 0.03, 0.2], "fixed": false, "mass_kg": 0.3,
               "at": {{"in": "world", "position_m": [0.55, 0, 0.1]}}}},
      "fence": {{"shape": "box", "size_m": [0.3, 0.02, {0}],
                "at": {{"in": "world", "position_m": [0.55, 0.2, {1}]}}}}}},
    "program": {{"do": "sequence", "steps": [
      {{"do": "ptp", "name": "above", "to": {{"in": "part", "position_m": [0, 0, 0.2], "rpy_deg": [0, 180, 0]}}}},
      {{"do": "lin", "name": "down", "to": {{"in": "part", "position_m": [0, 0, 0.08]}}}},
      {{"do": "grip", "name": "grip", "part": "part"}},
      {{"do": "lin", "name": "lift", "to": {{"by_m": [0, 0, 0.02]}}}},
      {{"do": "lin", "name": "over", "to": {{"by_m": [0, 0.4, 0]}}}},
      {{"do": "lin", "name": "set down", "to": {{"by_m": [0, 0, -0.0199]}}}},
      {{"do": "release", "name": "release"}},
      {{"do": "lin", "name": "away", "to": {{"by_m": [0, 0, 0.15]}}}}]}}}})",
                     fence, 0.5 * fence);
}

TEST(HeldParts, ArePartOfTheArm) {
  EXPECT_THAT(rehearsed(carrying(0.12)), Reports(Code::kCollision, "/program/steps/4", {"part", "fence"}));
}

TEST(HeldParts, MayBeLiftedCarriedSetDownAndLeft) {
  EXPECT_THAT(rehearsed(carrying(0.012)), Not(ReportsAnywhere(Code::kCollision)));
}

/// Two arms that look at each other, near enough to meet in the middle.
std::string two_arms(const std::string& steps) {
  return R"({"devices": {
    "left": {"model": "lwr4plus", "at": {"in": "world"}},
    "right": {"model": "lwr4plus", "at": {"in": "world", "position_m": [1.6, 0, 0], "rpy_deg": [0, 0, 180]}}},
    "program": {"do": "sequence", "steps": [)" +
         steps + "]}}";
}
std::string reach(const std::string& arm, const std::string& joints = "0, -70, 0, 40, 0, 0, 0") {
  return fmt::format(R"({{"do": "ptp", "name": "{0} reaches", "arm": "{0}", "to": {{"joints_deg": [{1}]}}}})", arm,
                     joints);
}
std::string home(const std::string& arm) {
  return fmt::format(R"({{"do": "ptp", "name": "{0} home", "arm": "{0}", "to": "home"}})", arm);
}
std::string parallel(const std::string& one, const std::string& other) {
  return fmt::format(
      R"({{"do": "parallel", "branches": [{{"do": "sequence", "steps": [{}]}}, {{"do": "sequence", "steps": [{}]}}]}})",
      one, other);
}

TEST(Neighbours, MeetWhereBothReach) {
  EXPECT_THAT(rehearsed(two_arms(reach("left") + ", " + reach("right"))),
              Reports(Code::kCollision, "/program/steps/1", {"right reaches"}));
  EXPECT_THAT(rehearsed(two_arms(reach("left") + ", " + home("left") + ", " + reach("right"))),
              Not(ReportsAnywhere(Code::kCollision)));
}

TEST(Neighbours, OfParallelBranchesAreCheckedAtTheSameTime) {
  EXPECT_THAT(rehearsed(two_arms(parallel(reach("left"), reach("right")))),
              ReportsAnywhere(Code::kCollision, {"left reaches", "right reaches"}));
  // The second leaves while the first comes: each alone would meet the other where it stands before or after.
  const std::string after =
      reach("left") + ", " + parallel(home("left"), R"({"do": "wait", "seconds": 5}, )" + reach("right"));
  const Diagnostics found = rehearsed(two_arms(after));
  EXPECT_THAT(found, Not(ReportsAnywhere(Code::kCollision)));
}

TEST(Neighbours, AtTimesThatAreNotKnownAreNoted) {
  const std::string steps = parallel(R"({"do": "wait", "seconds": 0.1}, )" + reach("left"), reach("right"));
  const Diagnostics found = rehearsed(two_arms(steps));
  EXPECT_FALSE(found.has_errors()) << found.to_string();
  bool noted = false;
  for (const Diagnostic& one : found.list())
    noted = noted || (one.code == Code::kCollision && one.severity == Severity::kNote);
  EXPECT_TRUE(noted);
}

TEST(Neighbours, OfOneTransactionAreCheckedAgainstEachOther) {
  const auto command = [](const std::string& arm) {
    return fmt::format(R"("{0} reaches": {{"do": "ptp", "arm": "{0}", "start": true,
                          "to": {{"joints_deg": [0, -70, 0, 40, 0, 0, 0]}}}})",
                       arm);
  };
  const auto both = [](const std::string& commands) {
    return rehearsed(two_arms(R"({"do": "transaction", "name": "both", "commands": {)" + commands + "}}"));
  };
  EXPECT_THAT(both(command("left") + ", " + command("right")),
              ReportsAnywhere(Code::kCollision, {"left reaches", "right reaches"}));
  EXPECT_THAT(both(command("left")), Not(ReportsAnywhere(Code::kCollision)));
}

/// The right arm starts when a force is felt, which is not before the run.
TEST(Neighbours, OfOneTransactionAtTimesThatAreNotKnownAreNoted) {
  const auto both = [](const std::string& joints, const std::string& start) {
    return rehearsed(R"({"devices": {
      "left": {"model": "lwr4plus", "at": {"in": "world"}},
      "wrist": {"model": "ft_gamma", "on": "left"},
      "right": {"model": "lwr4plus", "at": {"in": "world", "position_m": [1.6, 0, 0], "rpy_deg": [0, 0, 180]}}},
      "program": {"do": "transaction", "name": "both", "commands": {
        "left reaches": {"do": "ptp", "arm": "left", "start": true, "to": {"joints_deg": [0, -70, 0, 40, 0, 0, 0]}},
        "right reaches": {"do": "ptp", "arm": "right", "to": {"joints_deg": [)" +
                     joints + R"(]}}}, "on": [{"entered": )" + start + R"(, "start": "right reaches"}]}})");
  };
  const auto noted = [](const Diagnostics& found) {
    return std::ranges::count_if(found.list(), [](const Diagnostic& one) {
      return takt::test::fits(
          one,
          {Code::kCollision, "/program/commands/right reaches", {"left reaches", "right reaches"}, Severity::kNote});
    });
  };
  const std::string felt = R"({"sensor": "wrist", "above_N": 5})", ended = R"({"completed": "left reaches"})";
  const Diagnostics found = both("0, -70, 0, 40, 0, 0, 0", felt);
  EXPECT_FALSE(found.has_errors()) << found.to_string();
  EXPECT_GE(noted(found), 1) << found.to_string();
  EXPECT_EQ(noted(both("120, -30, 0, 90, 0, -60, 0", felt)), 0) << "it turns away";
  EXPECT_THAT(both("0, -70, 0, 40, 0, 0, 0", ended), ReportsAnywhere(Code::kCollision, {"right reaches"}))
      << "the times are known, and the left one is there";
}

// -- The floor
// ---------------------------------------------------------------------------------------------------------

/// An arm with a gripper that stands on the floor, and nothing around it. Its fingers end 13 mm before its tool centre
/// point, so 60 mm above the floor.
std::string on_the_floor(const std::string& steps, const std::string& more = "") {
  return R"({"devices": {"arm": {"model": "lwr4plus", "at": {"in": "world"}},
    "wrist": {"model": "ft_gamma", "on": "arm"}, "gripper": {"model": "wsg50", "on": "wrist"}})" +
         more + R"(, "program": {"do": "sequence", "steps": [)" + steps + "]}}";
}
const std::string kOverTheFloor = R"({"do": "ptp", "name": "over it", "to": {"in": "world",
  "position_m": [0.55, 0, 0.073], "rpy_deg": [180, 0, 0]}}, )";
std::string down_by(double way, const std::string& more = "") {
  return fmt::format(R"({{"do": "lin", "name": "down", "to": {{"by_m": [0, 0, {}]}}, "velocity_m_s": 0.02{}}})", -way,
                     more);
}

TEST(Floor, IsABodyOfItsOwn) {
  EXPECT_THAT(rehearsed(on_the_floor(kOverTheFloor + down_by(0.08))),
              Reports(Code::kCollision, "/program/steps/1", {"floor", "gripper", "down"}));
  EXPECT_THAT(rehearsed(on_the_floor(kOverTheFloor + down_by(0.05))), Not(ReportsAnywhere(Code::kCollision)));
  // An elbow, far from every tool.
  EXPECT_THAT(rehearsed(on_the_floor(ptp("0, 110, 0, 0, 0, 0, 0"))),
              Reports(Code::kCollision, "/program/steps/0", {"floor", "arm/"}));
}

TEST(Floor, MayBeTouchedByWhatMeansTo) {
  const std::string touch = down_by(0.08, R"(, "until": {"sensor": "wrist", "above_N": 5})");
  EXPECT_THAT(rehearsed(on_the_floor(kOverTheFloor + touch)), Not(ReportsAnywhere(Code::kCollision)));
  const std::string allowed = R"(, "collisions": {"allow": [{"between": ["floor", "gripper"], "reason": "a mat"}]})";
  EXPECT_THAT(rehearsed(on_the_floor(kOverTheFloor + down_by(0.062), allowed)), Not(ReportsAnywhere(Code::kCollision)));
}

TEST(Floor, AHeldPartMayBeSetDownOnIt) {
  const std::string part = R"(, "objects": {"part": {"shape": "box", "size_m": [0.03, 0.03, 0.2], "fixed": false,
    "mass_kg": 0.3, "at": {"in": "world", "position_m": [0.55, 0, 0.1]}}})";
  const std::string take = R"(
      {"do": "ptp", "to": {"in": "part", "position_m": [0, 0, 0.2], "rpy_deg": [0, 180, 0]}},
      {"do": "lin", "to": {"in": "part", "position_m": [0, 0, 0.08]}}, {"do": "grip", "part": "part"},
      {"do": "lin", "to": {"by_m": [0, 0, 0.1]}}, {"do": "lin", "to": {"by_m": [0, 0.1, 0]}}, )";
  const auto carried = [&](double down) { return rehearsed(on_the_floor(take + down_by(down), part)); };
  EXPECT_THAT(carried(0.1005), Not(ReportsAnywhere(Code::kCollision)));
  EXPECT_THAT(carried(0.105), Reports(Code::kCollision, "/program/steps/5", {"floor", "part"}));
}

TEST(Floor, IsWhereABaseDrives) {
  const auto to = [](const std::string& joints_deg) {
    return rehearsed(
        R"({"devices": {"base": {"model": "youbot_base", "at": {"in": "world"}},
      "arm": {"model": "lwr4plus", "on": "base"}}, "program": {"do": "sequence", "steps": [
      {"do": "lin", "name": "drive", "arm": "base", "to": {"by_m": [1.0, 0, 0]}}, )" +
        fmt::format(R"({{"do": "ptp", "name": "go", "arm": "arm", "to": {{"joints_deg": [{}]}}}})", joints_deg) +
        "]}}");
  };
  EXPECT_THAT(to("0, -30, 0, 90, 0, -60, 0"), Not(ReportsAnywhere(Code::kCollision)));
  EXPECT_THAT(to("0, 118, 0, -20, 0, 0, 0"), Reports(Code::kCollision, "/program/steps/1", {"floor", "arm/"}));
}

TEST(Floor, GivesItsNameToAnObjectThatIsCalledSo) {
  const std::string mat = R"(, "objects": {"floor": {"shape": "box", "size_m": [0.2, 0.2, 0.01],
    "at": {"in": "world", "position_m": [0.55, 0, 0.005]}}})";
  EXPECT_THAT(rehearsed(on_the_floor(kOverTheFloor + down_by(0.055), mat)),
              Reports(Code::kCollision, "/program/steps/1", {"'floor'", "gripper"}));
  EXPECT_THAT(rehearsed(on_the_floor(ptp("0, 110, 0, 0, 0, 0, 0"), mat)),
              Reports(Code::kCollision, "/program/steps/0", {"'world/floor'"}));
}

TEST(Bases, AnArmOnABaseMeetsWhatTheBaseDrivesInto) {
  const std::string text = R"({"devices": {
      "base": {"model": "youbot_base", "at": {"in": "world"}},
      "arm": {"model": "lwr4plus", "on": "base"}},
    "objects": {"beam": {"shape": "box", "size_m": [0.1, 1.0, 0.1],
                         "at": {"in": "world", "position_m": [1.5, 0, 0.8]}}},
    "program": {"do": "sequence", "steps": [
      {"do": "lin", "name": "drive", "arm": "base", "to": {"by_m": [1.0, 0, 0]}}]}})";
  EXPECT_THAT(rehearsed(text), Reports(Code::kCollision, "/program/steps/0", {"beam", "base", "arm"}));
}

// -- All that is shipped
// -----------------------------------------------------------------------------------------------

TEST(Shipped, ScenariosCollideNowhere) {
  for (const std::string& name : takt::test::scenario_names()) {
    const auto session = Session::open(std::filesystem::path("scenarios") / (name + ".json"), models());
    ASSERT_TRUE(session) << session.error().to_string();
    for (const Diagnostic& one : (*session)->warnings().list())
      EXPECT_TRUE(one.code != Code::kCollision || one.severity == Severity::kNote) << name << ": " << to_string(one);
    EXPECT_TRUE((*session)->description().collisions.off.empty()) << name;
  }
}

// -- In the run
// --------------------------------------------------------------------------------------------------------

/// The program believes that the block is where it is drawn; it is up to 40 mm higher, and soft.
CellText mistaken() {
  return {.objects = R"(
    "block": {"shape": "box", "size_m": [0.1, 0.1, 0.05], "at": {"in": "world", "position_m": [0.55, 0, -0.025]},
              "stiffness_N_m": 500, "damping_N_s_m": 5, "vary": {"position_m": [0, 0, 0.04]}})"};
}
const std::string kNearTable = R"({"do": "lin", "name": "low", "to": {"by_m": [0, 0, -0.022]}, "velocity_m_s": 0.02})";

RunReport run_of(const std::string& text, std::uint64_t seed) {
  Description description = parsed(text);
  description.seed = seed;
  return test::run(std::move(description));
}

/// A seed with which the block is 10 to 20 mm higher than it is drawn: the tool stands above it, and comes lower.
std::uint64_t seed_of_a_high_block() {
  const Description description = parsed(mistaken().with(""));
  for (std::uint64_t seed = 1;; ++seed) {
    for (const ObjectEntry& object : description.objects) {
      const double higher = drawn_pose(object, seed).translation().z() + 0.025;
      if (object.name == "block" && higher > 0.01 && higher < 0.02) return seed;
    }
  }
}

/// Where a goal is measured the rehearsal knows only what it will be about.
std::string to_a_measured_goal(const std::string& move) {
  return R"json({"do": "sequence",
    "variables": {"goal": {"type": "pose", "nominal": {
      "in": "world", "position_m": [0.6, 0, 0.3], "rpy_deg": [180, 0, 0]}}},
    "steps": [{"do": "wait", "seconds": 0.1},
      {"do": "let", "values": {
        "goal": "$at(0.6[m], 0[m], select(force('wrist') < 1000[N], -20[mm], 0.3[m])) * rpy(180[deg], 0[deg], 0[deg])"
      }}, )json" +
         move + "]}";
}

TEST(Run, AMotionToAMeasuredGoalIsCheckedBeforeItBegins) {
  const std::string steps = to_a_measured_goal(R"({"do": "ptp", "name": "go", "to": "$goal"})");
  EXPECT_THAT(rehearsed(CellText{}.with(steps)), Not(ReportsAnywhere(Code::kCollision)));
  const RunReport report = run_of(CellText{}.with(steps), 1);
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.diagnostics, Reports(Code::kCollision, "/program/steps/0/steps/2", {"go", "table"}));
  EXPECT_LT(report.sim_time, 0.2) << "nothing has moved";
}

TEST(Run, ACollisionIsAFailureThatAProgramMayHandle) {
  const std::string steps = to_a_measured_goal(
      R"({"do": "try", "steps": [{"do": "ptp", "name": "go", "to": "$goal"}],
          "on_error": {"as": "why", "steps": [{"do": "log", "text": "$'no: ' + why"}]}})");
  const RunReport report = run_of(CellText{}.with(steps), 1);
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
}

TEST(Run, AContactThatNoStepMeansIsAFault) {
  const RunReport report = run_of(mistaken().with(kAbove + kNearTable), seed_of_a_high_block());
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.diagnostics, Reports(Code::kUnexpectedContact, "", {"block", "N", "s"}));
}

/// The block is soft: the force goes on to rise for half a second, until the run ends.
TEST(Run, TheReportOfACrashHasItsPeak) {
  Description description = parsed(mistaken().with(kAbove + kNearTable));
  description.seed = seed_of_a_high_block();
  std::optional<std::size_t> watch;
  std::vector<double> forces;
  RunOptions options;
  options.after_cycle = [&](BuiltCell& built) {
    if (!watch) watch = built.world->watch_contact("probe", "block").value();
    if (built.world->contact(*watch).force > 0.1) forces.push_back(built.world->contact(*watch).force);
    return true;
  };
  const RunReport report = test::run(std::move(description), options);
  EXPECT_EQ(report.verdict, Verdict::kError);
  ASSERT_GT(forces.size(), 50u) << "it goes on after the first touch";
  const double peak = std::ranges::max(forces);
  EXPECT_GT(peak, 5.0 * forces.front());
  EXPECT_THAT(report.diagnostics, Reports(Code::kUnexpectedContact, "", {fmt::format("{:.1f} N at most", peak)}));
}

TEST(Run, AContactThatAStepMeansIsNone) {
  const std::string touch =
      R"({"do": "tare"}, {"do": "lin", "name": "touch", "to": {"by_m": [0, 0, -0.027]}, "velocity_m_s": 0.01,
                                "until": {"sensor": "wrist", "above_N": 5}}, )";
  const std::string up = R"({"do": "lin", "name": "up", "to": {"by_m": [0, 0, 0.05]}})";
  const RunReport report = run_of(mistaken().with(kAbove + touch + up), seed_of_a_high_block());
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
}

TEST(Run, TheSameKeyAllowsItInTheRun) {
  CellText cell = mistaken();
  cell.collisions = R"({"allow": [{"between": ["probe", "block"], "reason": "the block is soft"}]})";
  const RunReport report = run_of(cell.with(kAbove + kNearTable), seed_of_a_high_block());
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
}

/// Jogging has no path that a rehearsal could check.
TEST(Floor, IsNotDrivenIntoInARun) {
  const std::string down = R"({"do": "jog", "linear_m_s": [0, 0, -0.05], "in": "world", "seconds": 3,
                               "while": {"channel": "on"}})";
  const std::string on = R"(, "channels": {"on": {"type": "Boolean", "initial": true}})";
  const RunReport report = run_of(on_the_floor(kOverTheFloor + down, on), 1);
  EXPECT_EQ(report.verdict, Verdict::kError);
  EXPECT_THAT(report.diagnostics, Reports(Code::kUnexpectedContact, "", {"floor", "gripper"}));
}

/// Up beside a block and over it, 6 mm above: a blend of 60 mm cuts the corner into the block. The branch is not known
/// before the run, so the blend is decided in it.
TEST(Run, ABlendThatIsDecidedInItDoesNotCutACornerIntoSomething) {
  const auto over = [](double height) {
    return run_of(fmt::format(R"({{"devices": {{
        "arm": {{"model": "lwr4plus", "at": {{"in": "world"}}}}, "gripper": {{"model": "wsg50", "on": "arm"}}}},
      "objects": {{"block": {{"shape": "box", "size_m": [0.2, 0.15, {0}],
                              "at": {{"in": "world", "position_m": [0.538, 0.105, {1}]}}}}}},
      "program": {{"do": "sequence", "steps": [
        {{"do": "ptp", "name": "right", "to": {{"joints_deg": [0, -30, 0, 90, 0, -60, 0]}}}},
        {{"do": "lin", "name": "up", "to": {{"by_m": [0, 0, 0.12]}}, "blend_m": 0.06}},
        {{"do": "branch", "cases": [{{"when": "$true", "steps": [
          {{"do": "ptp", "name": "over", "to": {{"in": "world", "position_m": [0.466, 0.269, 0.386],
                                               "rpy_deg": [0, 180, 30]}}}}]}}]}}]}}}})",
                              height, 0.5 * height),
                  1);
  };
  const RunReport low = over(0.1), high = over(0.3675);
  EXPECT_EQ(low.verdict, Verdict::kPassed) << low.diagnostics.to_string();
  EXPECT_EQ(high.verdict, Verdict::kPassed) << high.diagnostics.to_string();
  EXPECT_LT(low.sim_time + 0.05, high.sim_time) << "over a low block it is blended, at a high one the arm stops";
}

// -- The distance as a sensor
// ------------------------------------------------------------------------------------------

TEST(Distance, EndsAMotionBeforeItTouches) {
  const std::string down = R"({"do": "lin", "name": "down", "to": {"by_m": [0, 0, -0.027]}, "velocity_m_s": 0.05,
                               "until": {"distance": ["arm", "table"], "below_m": 0.02}})";
  CellText cell;
  cell.more = R"("expectations": [
    {"name": "it stands above", "kind": "tool_pose", "arm": "arm", "in": "world", "position_m": [0.55, 0, 0.0225],
     "position_within_m": 0.003}])";
  const RunReport report = run_of(cell.with(kAbove + down), 1);
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
}

TEST(Distance, AbortsWhatComesTooNear) {
  const std::string down = R"({"do": "lin", "name": "down", "to": {"by_m": [0, 0, -0.022]}, "velocity_m_s": 0.05,
                               "abort_if": {"distance": ["probe", "table"], "below_m": 0.02}})";
  const RunReport report = run_of(CellText{}.with(kAbove + down), 1);
  EXPECT_THAT(report.diagnostics, ReportsAnywhere(Code::kAbortCondition));
}

TEST(Floor, ADistanceToItEndsAMotion) {
  const std::string near = R"(, "until": {"distance": ["arm", "floor"], "below_m": 0.03})";
  const RunReport report = run_of(on_the_floor(kOverTheFloor + down_by(0.05, near), R"(, "expectations": [
    {"kind": "tool_pose", "arm": "arm", "in": "world", "position_m": [0.55, 0, 0.043], "position_within_m": 0.003}])"),
                                  1);
  EXPECT_EQ(report.verdict, Verdict::kPassed) << report.diagnostics.to_string();
}

TEST(Distance, NamesAreChecked) {
  const std::string down =
      R"({"do": "lin", "to": {"by_m": [0, 0, -0.01]}, "until": {"distance": ["arm", "tabel"], "below_m": 0.02}})";
  EXPECT_THAT(rehearsed(CellText{}.with(kAbove + down)),
              Reports(Code::kUnknownName, "/program/steps/1/until/distance/1", {"tabel", "table"}));
}

}  // namespace
}  // namespace takt::cell::collisions_test
