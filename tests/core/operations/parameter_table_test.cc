#include <numbers>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/operations/basic/wait.h"
#include "core/operations/force/press.h"
#include "core/operations/motion/motion.h"
#include "core/operations/motion/motion_plan.h"
#include "core/operations/online/jog.h"
#include "tests/support/reports.h"

namespace takt::operations {
namespace {

using takt::test::Reports;

using ::testing::ElementsAre;
using Json = nlohmann::ordered_json;
using Type = ParameterInfo::Type;

/// A cell of which only the names are known.
expression::Cell named_cell() {
  expression::Cell cell;
  cell.arms["robot"] = {};
  cell.sensors["wrist"] = {.arm = "robot"};
  return cell;
}

/// All parameters, those of objects inside of others included.
void collect(const std::vector<ParameterInfo>& parameters, std::vector<ParameterInfo>& all) {
  for (const ParameterInfo& one : parameters) {
    all.push_back(one);
    collect(one.fields, all);
  }
}

std::vector<ParameterInfo> all_parameters() {
  std::vector<ParameterInfo> all;
  for (const Operation& operation : Operations::global().all()) collect(operation.parameters(), all);
  return all;
}

TEST(Operations, EveryKeyNamesItsUnit) {
  // Keys that say in words what they count, and a gain whose unit does not fit into a suffix.
  const std::set<std::string> exceptions{"seconds", "gain_m_s_per_N"};
  for (const ParameterInfo& one : all_parameters()) {
    if (one.unit.empty() || exceptions.contains(one.key)) continue;
    EXPECT_TRUE(one.key.ends_with(net::key_suffix(one.unit))) << one.key << " is in " << one.unit;
  }
}

TEST(Operations, NoKeyWithoutAUnitLooksAsIfItHadOne) {
  for (const ParameterInfo& one : all_parameters()) {
    const bool counts = one.type == Type::kNumber || one.type == Type::kVector || one.type == Type::kNumbers;
    if (!counts || !one.unit.empty()) continue;
    for (const char* suffix : {"_m", "_s", "_N", "_Nm", "_deg", "_kg", "_m_s", "_deg_s"})
      EXPECT_FALSE(one.key.ends_with(suffix)) << one.key;
  }
}

TEST(Operations, EveryParameterIsDocumented) {
  for (const Operation& operation : Operations::global().all()) {
    EXPECT_TRUE(operation.doc.ends_with('.')) << operation.name;
    std::set<std::string> keys;
    for (const ParameterInfo& one : operation.parameters()) {
      EXPECT_TRUE(keys.insert(one.key).second) << operation.name << " has '" << one.key << "' twice";
      EXPECT_FALSE(one.doc.empty()) << operation.name << "." << one.key;
      EXPECT_FALSE(one.required && !one.fallback.empty()) << operation.name << "." << one.key;
    }
  }
}

TEST(Operations, ARegistrationIsChecked) {
  Registration* list = nullptr;
  const auto checked = [&list](const Operation& operation) { return OperationRegistration(list, operation).check(); };
  const Operation press = press_operation();
  EXPECT_THAT(checked(press), Reports(Code::kDuplicate, "", {"press"}));
  Operation own = press;
  own.name = "squeeze";
  EXPECT_EQ(checked(own).to_string(), "");
  own.read_step = nullptr;
  own.read_command = nullptr;
  EXPECT_THAT(checked(own), Reports(Code::kMissing, "", {"squeeze"}));
  own.name = "";
  EXPECT_THAT(checked(own), Reports(Code::kMissing, ""));
}

TEST(ParameterTable, ReadsInTheUnitOfFilesAndKeepsSi) {
  const expression::Cell cell = named_cell();
  Diagnostics diagnostics;
  const Json json = Json::parse(R"({"do": "jog", "angular_max_deg_s": 90, "angular_deg_s": [0, 0, 180],
                                    "while": {"channel": "go"}})");
  expression::Cell with_channel = cell;
  with_channel.channels["go"] = nullptr;
  ObjectReader reader(json, "", diagnostics);
  const JogParameters jog = jog_parameters().read(reader, with_channel);
  EXPECT_EQ(diagnostics.to_string(), "");
  EXPECT_DOUBLE_EQ(jog.angular_max, std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(jog.angular->z(), std::numbers::pi);
  EXPECT_EQ(jog.arm, "robot");
  EXPECT_FALSE(jog.seconds);
}

TEST(ParameterTable, AValueSetInCppIsRefusedLikeThatOfAFile) {
  const expression::Cell cell = named_cell();
  PressParameters press;
  press.force = 5000.0;
  press.travel = -0.1;
  press.direction.setZero();
  const Diagnostics in_cpp = press_parameters().check(press, cell);

  Diagnostics in_file;
  const Json json = Json::parse(R"({"force_N": 5000, "travel_m": -0.1, "direction": [0, 0, 0]})");
  ObjectReader reader(json, "", in_file);
  (void)press_parameters().read(reader, cell);
  EXPECT_EQ(in_cpp.to_string(), in_file.to_string());
  std::vector<std::string> places;
  for (const Diagnostic& one : in_cpp.list()) places.push_back(one.pointer);
  EXPECT_THAT(places, ElementsAre("/direction", "/force_N", "/travel_m"));
}

TEST(ParameterTable, DefaultsOfCppAreThoseOfFiles) {
  const expression::Cell cell = named_cell();
  const PressParameters in_cpp;
  Diagnostics diagnostics;
  const Json nothing = Json::object();
  ObjectReader reader(nothing, "", diagnostics);
  const PressParameters in_file = press_parameters().read(reader, cell);
  EXPECT_EQ(diagnostics.to_string(), "");
  EXPECT_EQ(in_file.force, in_cpp.force);
  EXPECT_EQ(in_file.approach, in_cpp.approach);
  EXPECT_EQ(in_file.travel, in_cpp.travel);
  EXPECT_EQ(in_file.direction, in_cpp.direction);
  EXPECT_EQ(in_file.in, in_cpp.in);
  EXPECT_EQ(press_parameters().check(in_cpp, cell).to_string(), "");
}

TEST(ParameterTable, WhatIsWrittenIsReadBack) {
  const expression::Cell cell = named_cell();
  MotionTask motion;
  motion.velocity = 0.25;
  motion.linear_velocity = 0.1;
  motion.blend = activity::BlendingCondition::at_distance(0.02);
  motion.weave.emplace().amplitude = 0.004;
  ParameterWriter writer;
  motion_parameters(PathKind::kLin).write(motion, writer);
  Json json = writer.result();
  json["to"] = "home";
  Diagnostics diagnostics;
  ObjectReader reader(json, "", diagnostics);
  const MotionTask back = motion_parameters(PathKind::kLin).read(reader, cell);
  EXPECT_EQ(diagnostics.to_string(), "");
  EXPECT_EQ(back.velocity, motion.velocity);
  EXPECT_EQ(back.linear_velocity, motion.linear_velocity);
  EXPECT_EQ(back.blend.along_path.kind, motion.blend.along_path.kind);
  EXPECT_EQ(back.blend.along_path.value, motion.blend.along_path.value);
  EXPECT_EQ(back.weave->amplitude, 0.004);
}

TEST(ParameterTable, AnUnknownKeyIsReportedWithTheNearest) {
  Diagnostics diagnostics;
  const Json json = Json::parse(R"({"seconds": 1, "timeot_s": 2})");
  ObjectReader reader(json, "/steps/0", diagnostics);
  (void)wait_parameters().read(reader, {});
  EXPECT_THAT(diagnostics, Reports(Code::kUnknownKey, "/steps/0/timeot_s", {"timeout_s"}));
}

// Fault of 60396cd: the unit was guessed from the ending of the key, so "_N_m" was taken for metres.
TEST(UnitInOperation, ComesFromTheTableAndNotFromTheEndingOfTheKey) {
  const auto unit = [](const char* text, const char* pointer) {
    const auto found = unit_in_operation(Json::parse(text), pointer);
    return found ? net::to_string(found->dimension) : std::string("any");
  };
  const auto named = [](const char* text) { return net::to_string(net::file_unit(text).dimension); };
  const char* lin = R"({"do": "lin"})";
  EXPECT_EQ(unit(lin, "/compliance/stiffness_N_m"), named("N/m"));
  EXPECT_EQ(unit(lin, "/compliance/stiffness_N_m/2"), named("N/m"));
  EXPECT_EQ(unit(lin, "/compliance/rotational_stiffness_Nm_rad"), named("Nm/rad"));
  EXPECT_EQ(unit(lin, "/force_offset/jerk_max_m_s3"), named("m/s^3"));
  EXPECT_EQ(unit(lin, "/force_offset/gain_m_s_per_N"), named("m/s/N"));
  EXPECT_EQ(unit(lin, "/to/rpy_deg/0"), named("deg"));
  EXPECT_EQ(unit(lin, "/speed"), named(""));
  EXPECT_EQ(unit(lin, "/until/above_N"), named("N"));
  EXPECT_EQ(unit(lin, "/until/all/0/below_Nm"), named("Nm"));
  EXPECT_EQ(unit(R"({"do": "set"})", "/value"), "any");
  EXPECT_EQ(unit(R"({"do": "set"})", "/factor"), "any");
  const char* tree = R"({"do": "transaction", "commands": {"a": {"do": "motions", "steps": [{"do": "lin"}]},
                                                          "b": {"do": "press"}}})";
  EXPECT_EQ(unit(tree, "/commands/a/steps/0/velocity_m_s"), named("m/s"));
  EXPECT_EQ(unit(tree, "/commands/b/force_N"), named("N"));
  EXPECT_EQ(unit(tree, "/on/0/after_s"), named("s"));
}

TEST(MotionNotes, ANoteWithoutANumberIsOfTheFirstMotion) {
  std::vector<MotionTask> requests(2);
  requests[0].pointer = "/steps/3";
  requests[1].pointer = "/steps/4";
  requests[1].blend.along_path.kind = motion::Blend::Kind::kDistance;
  Diagnostics notes;
  for (const char* pointer : {"", "/blend", "/1/blend", "/7/blend"}) notes.note(pointer, "stops at the goal");
  std::vector<std::string> pointers;
  const Diagnostics seen = notes_of_motions(notes, requests);
  for (const Diagnostic& one : seen.list()) pointers.push_back(one.pointer);
  EXPECT_THAT(pointers, ElementsAre("/steps/3/blend_fraction", "/steps/3/blend_fraction", "/steps/4/blend_m",
                                    "/steps/4/blend_m"));
}

}  // namespace
}  // namespace takt::operations
