#include "core/expression/condition.h"
#include "tests/support/reports.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace takt::expression {
namespace {

using takt::test::Reports;
using testing::ElementsAre;
using Json = nlohmann::ordered_json;

Cell cell_with_two_sensors() {
  Cell cell;
  cell.sensors["wrist"] = {};
  cell.sensors["table"] = {};
  return cell;
}

Result<Condition> parse(const char* text) {
  return parse_condition(Json::parse(text), "/until", cell_with_two_sensors());
}

Condition good(const char* text) {
  const auto condition = parse(text);
  if (!condition) ADD_FAILURE() << text << "\n" << condition.error().to_string();
  return condition.value_or(Condition{});
}

/// Pointers of all diagnostics, in their order.
std::vector<std::string> pointers(const char* text) {
  const auto condition = parse(text);
  std::vector<std::string> pointers;
  if (condition) return pointers;
  for (const Diagnostic& diagnostic : condition.error().list()) pointers.push_back(diagnostic.pointer);
  return pointers;
}

TEST(Condition, AComparisonHasSensorQuantityAndThreshold) {
  const Condition force = good(R"({"sensor": "wrist", "above_N": 5})");
  EXPECT_EQ(force.kind, Condition::Kind::kForce);
  EXPECT_EQ(force.device, "wrist");
  EXPECT_EQ(force.quantity, Quantity::kForce) << "the default";
  EXPECT_TRUE(force.above);
  EXPECT_EQ(force.threshold, 5.0);
  const Condition torque = good(R"({"sensor": "table", "quantity": "torque_y", "below_Nm": -0.5})");
  EXPECT_EQ(torque.quantity, Quantity::kTorqueY);
  EXPECT_FALSE(torque.above);
  EXPECT_EQ(torque.threshold, -0.5);
}

TEST(Condition, AnInternalForceHasTwoSensorsAndAThreshold) {
  const Condition inside = good(R"({"internal_force": ["wrist", "table"], "above_N": 40})");
  EXPECT_EQ(inside.kind, Condition::Kind::kInternalForce);
  EXPECT_EQ(inside.device, "wrist");
  EXPECT_EQ(inside.other, "table");
  EXPECT_TRUE(inside.above);
  EXPECT_EQ(inside.threshold, 40.0);
  EXPECT_THAT(sensors_of(inside), ElementsAre("wrist", "table"));
  EXPECT_FALSE(good(R"({"internal_force": ["table", "wrist"], "below_N": 3})").above);
  EXPECT_THAT(pointers(R"({"internal_force": "wrist", "above_N": 5})"),
              ElementsAre("/until/internal_force", "/until/internal_force"));
  EXPECT_THAT(pointers(R"({"internal_force": ["wrist", "table"], "above_Nm": 5})"),
              ElementsAre("/until", "/until/above_Nm"));
  EXPECT_THAT(pointers(R"({"internal_force": ["wrist", "table"], "above_N": 5, "quantity": "force_x"})"),
              ElementsAre("/until/quantity"));
}

TEST(Condition, EveryQuantityHasItsUnit) {
  const std::pair<const char*, Quantity> all[] = {{"force", Quantity::kForce},      {"force_x", Quantity::kForceX},
                                                  {"force_y", Quantity::kForceY},   {"force_z", Quantity::kForceZ},
                                                  {"torque", Quantity::kTorque},    {"torque_x", Quantity::kTorqueX},
                                                  {"torque_y", Quantity::kTorqueY}, {"torque_z", Quantity::kTorqueZ}};
  for (const auto& [name, quantity] : all) {
    const std::string begin = std::string(R"({"sensor": "wrist", "quantity": ")") + name + "\", ";
    const bool torque = std::string_view(name).starts_with("torque");
    EXPECT_EQ(is_torque(quantity), torque);
    EXPECT_EQ(good((begin + (torque ? R"("above_Nm": 1})" : R"("above_N": 1})")).c_str()).quantity, quantity);
    const auto wrong = parse((begin + (torque ? R"("above_N": 1})" : R"("above_Nm": 1})")).c_str());
    ASSERT_FALSE(wrong.has_value()) << name;
    EXPECT_THAT(wrong.error(), Reports(Code::kConflict, "/until",
                                       torque ? std::vector<std::string>{"above_Nm", "below_Nm"}
                                              : std::vector<std::string>{"above_N", "below_N"}));
  }
}

TEST(Condition, AllAnyAndNotNest) {
  const Condition condition = good(R"({"all": [
      {"any": [{"sensor": "table", "above_N": 1}, {"sensor": "wrist", "above_N": 2}]},
      {"not": {"sensor": "table", "below_N": 3}}]})");
  EXPECT_EQ(condition.kind, Condition::Kind::kAll);
  ASSERT_EQ(condition.operands.size(), 2u);
  EXPECT_EQ(condition.operands[0].kind, Condition::Kind::kAny);
  EXPECT_EQ(condition.operands[1].kind, Condition::Kind::kNot);
  ASSERT_EQ(condition.operands[1].operands.size(), 1u);
  EXPECT_EQ(condition.operands[1].operands[0].threshold, 3.0);
  EXPECT_THAT(sensors_of(condition), ElementsAre("table", "wrist")) << "each once, in order of first use";
}

TEST(Condition, AllErrorsAreFoundAtOnceWhereTheyStand) {
  EXPECT_THAT(pointers(R"({"any": [
      {"sensor": "wirst", "above_N": 1},
      {"sensor": "wrist", "quantity": "forze", "above_N": 1},
      {"sensor": "wrist", "above_N": 1, "below_N": 2},
      {"sensor": "wrist", "above_N": "5"},
      {"not": {"all": []}},
      7
    ]})"),
              ElementsAre("/until/any/0/sensor", "/until/any/1/quantity", "/until/any/2", "/until/any/3/above_N",
                          "/until/any/4/not/all", "/until/any/5"));
}

TEST(Condition, ANameThatIsNearlyRightIsTold) {
  EXPECT_THAT(parse(R"({"sensor": "wirst", "above_N": 1})").error(),
              Reports(Code::kUnknownName, "/until/sensor", {"wrist"}));
  EXPECT_THAT(parse(R"({"sensor": "wrist", "quantity": "force_w", "above_N": 1})").error(),
              Reports(Code::kUnknownName, "/until/quantity"));
  EXPECT_THAT(parse(R"({"sensor": "wrist", "abov_N": 1})").error(),
              Reports(Code::kUnknownKey, "/until/abov_N", {"above_N"}));
}

TEST(Condition, WhatIsMissingOrTooMuchIsSaid) {
  EXPECT_FALSE(parse(R"({"above_N": 1})").has_value()) << "no sensor";
  EXPECT_FALSE(parse(R"({"sensor": "wrist"})").has_value()) << "no threshold";
  EXPECT_FALSE(parse(R"({"all": [{"sensor": "wrist", "above_N": 1}], "any": []})").has_value()) << "two at once";
  EXPECT_FALSE(parse(R"({"not": []})").has_value());
  EXPECT_FALSE(parse(R"({"any": {}})").has_value());
}

TEST(Condition, ChannelsAreKnownByNameAndReadAsTheKeysSay) {
  Cell cell;
  cell.channels["enable"] = nullptr;  // only names are known
  cell.channels["level"] = nullptr;
  const auto read = [&](const char* text) { return parse_condition(Json::parse(text), "/until", cell); };
  const auto level = read(R"({"channel": "enable", "is": false})");
  ASSERT_TRUE(level.has_value());
  EXPECT_EQ(level->kind, Condition::Kind::kBooleanChannel);
  EXPECT_FALSE(level->level);
  const auto number = read(R"({"channel": "level", "below": 2})");
  ASSERT_TRUE(number.has_value());
  EXPECT_EQ(number->kind, Condition::Kind::kRealChannel);
  EXPECT_FALSE(number->above);
  EXPECT_EQ(number->threshold, 2.0);
  EXPECT_THAT(read(R"({"channel": "enabel"})").error(), Reports(Code::kUnknownName, "/until/channel", {"enable"}));
  EXPECT_THAT(read(R"({"channel": "level", "above": 1, "below": 2})").error(),
              Reports(Code::kConflict, "/until", {"above", "below"}));
  EXPECT_THAT(read(R"({"channel": "level", "above": 1, "is": true})").error(), Reports(Code::kUnknownKey, "/until/is"));
}

}  // namespace
}  // namespace takt::expression
