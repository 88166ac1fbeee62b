#include "cell/file/copies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/reports.h"

namespace takt::cell {
namespace {

using takt::test::Reports;
using takt::test::ReportsAnywhere;
using Json = nlohmann::ordered_json;

Json written(const char* text, Diagnostics& diagnostics) {
  Json document = Json::parse(text);
  write_out_copies(document, diagnostics);
  return document;
}
Json written(const char* text) {
  Diagnostics diagnostics;
  Json document = written(text, diagnostics);
  EXPECT_FALSE(diagnostics.has_errors()) << diagnostics.to_string();
  return document;
}

TEST(Copies, AnObjectStandsForAsManyOneStepFurtherEach) {
  const Json document = written(R"({"parameters": {"parts": 3}, "objects": {
    "part #": {"copies": {"count": "$parts", "step_m": [0.5, 0, -1]}, "lit_by": "io/lamp #",
               "at": {"in": "tray", "position_m": [1, 2, 3]}},
    "table": {"at": {"in": "world"}}}})");
  EXPECT_EQ(document["objects"].size(), 4u);
  EXPECT_EQ(document["objects"]["part 1"]["at"]["position_m"], Json({1, 2, 3}));
  EXPECT_EQ(document["objects"]["part 3"]["at"]["position_m"], Json({2.0, 2.0, 1.0}));
  EXPECT_EQ(document["objects"]["part 3"]["at"]["in"], "tray");
  EXPECT_EQ(document["objects"]["part 2"]["lit_by"], "io/lamp 2");
  EXPECT_FALSE(document["objects"]["part 2"].contains("copies"));
  EXPECT_FALSE(document.contains("parameters"));
}

TEST(Copies, NoneOfThemLeaveNothing) {
  EXPECT_TRUE(written(R"({"objects": {"part #": {"copies": {"count": 0}, "at": {}}}})")["objects"].empty());
}

TEST(Copies, AnExpectationStandsForAsMany) {
  const Json document = written(R"({"expectations": [{"kind": "limits"},
    {"kind": "object_pose", "name": "# lies well", "object": "part #", "position_m": [0, 0, 0],
     "copies": {"count": 2, "step_m": [0, 0.1, 0]}}]})");
  ASSERT_EQ(document["expectations"].size(), 3u);
  EXPECT_EQ(document["expectations"][1]["object"], "part 1");
  EXPECT_EQ(document["expectations"][2]["name"], "2 lies well");
  EXPECT_EQ(document["expectations"][2]["position_m"], Json({0.0, 0.1, 0.0}));
}

TEST(Copies, ParametersAreValuesOutsideOfProgramsAndVariablesInside) {
  const Json document = written(R"({"parameters": {"mass": 0.2, "robot": "ur5"},
    "devices": {"arm": {"model": "$robot"}}, "objects": {"part": {"mass_kg": "$mass"}},
    "program": {"do": "sequence", "variables": {"mass": 1}, "steps": [{"do": "log", "text": "$robot"}]}})");
  EXPECT_EQ(document["devices"]["arm"]["model"], "ur5");
  EXPECT_EQ(document["objects"]["part"]["mass_kg"], 0.2);
  EXPECT_EQ(document["program"]["variables"]["robot"], "ur5");
  EXPECT_EQ(document["program"]["variables"]["mass"], 1) << "what a program declares itself counts there";
  EXPECT_EQ(document["program"]["steps"][0]["text"], "$robot") << "an expression";
}

TEST(Copies, AParameterOutsideOfItsRangeIsReportedAtTheParameter) {
  const auto reported = [](const std::string& parameters) {
    Json document = Json::parse(R"({"parameters": )" + parameters + R"(, "parameter_ranges": {
      "parts": {"at_least": 1, "at_most": 6, "whole": true}, "mass": {"at_least": 0.1},
      "pattern": {"one_of": ["spiral", "zigzag"]}}})");
    Diagnostics diagnostics;
    write_out_copies(document, diagnostics);
    EXPECT_FALSE(document.contains("parameter_ranges"));
    return diagnostics;
  };
  EXPECT_FALSE(reported(R"({"parts": 6, "mass": 0.1, "pattern": "zigzag"})").has_errors());
  const Diagnostics all = reported(R"({"parts": 7, "mass": 0, "pattern": "circle"})");
  EXPECT_THAT(all, Reports(Code::kOutOfRange, "/parameters/parts"));
  EXPECT_THAT(all, ReportsAnywhere(Code::kOutOfRange, {"1", "6"}));
  EXPECT_THAT(all, Reports(Code::kOutOfRange, "/parameters/mass"));
  EXPECT_THAT(all, ReportsAnywhere(Code::kUnknownName, {"circle", "spiral"}));
  for (const char* parts : {"2.5", "\"two\"", "true"})
    EXPECT_THAT(reported(std::string(R"({"mass": 1, "pattern": "spiral", "parts": )") + parts + "}"),
                Reports(Code::kOutOfRange, "/parameters/parts"));
}

TEST(Copies, WhatFollowsFromAParameterOutsideOfItsRangeIsNoFinding) {
  Diagnostics diagnostics;
  const Json document = written(R"({"parameters": {"parts": 2.5, "robot": "ur7"},
    "parameter_ranges": {"parts": {"at_least": 1, "at_most": 6, "whole": true}, "robot": {"one_of": ["ur5", "tx90"]}},
    "devices": {"arm": {"model": "$robot"}}, "objects": {"part #": {"copies": {"count": "$parts"}, "at": {}}}})",
                                diagnostics);
  EXPECT_EQ(diagnostics.list().size(), 2u) << diagnostics.to_string();
  EXPECT_EQ(document["devices"]["arm"]["model"], "ur5");
}

TEST(Copies, MistakesAreReportedWhereTheyAre) {
  const auto reported = [](const char* text) {
    Diagnostics diagnostics;
    (void)written(text, diagnostics);
    return diagnostics;
  };
  EXPECT_THAT(reported(R"({"parameters": {"2 parts": 1}})"), Reports(Code::kInvalidName, "/parameters/2 parts"));
  EXPECT_THAT(reported(R"({"parameters": {"parts": [1]}})"), Reports(Code::kWrongType, "/parameters/parts"));
  EXPECT_THAT(reported(R"({"parameters": {"parts": 2}, "objects": {"a #": {"copies": {"count": "$pars"}}}})"),
              ReportsAnywhere(Code::kUnknownName, {"pars", "parts"}));
  EXPECT_THAT(reported(R"({"objects": {"part": {"copies": {"count": 2}}}})"),
              Reports(Code::kInvalidName, "/objects/part"));
  EXPECT_THAT(reported(R"({"objects": {"part #": {"copies": {"count": -1}}}})"),
              Reports(Code::kOutOfRange, "/objects/part #/copies/count"));
  EXPECT_THAT(reported(R"({"parameters": {"parts": 2}, "parameter_ranges": {"part": {}}})"),
              ReportsAnywhere(Code::kUnknownName, {"part", "parts"}));
  EXPECT_THAT(reported(R"({"parameter_ranges": {"parts": {}}})"),
              Reports(Code::kUnknownName, "/parameter_ranges/parts"));
  EXPECT_THAT(reported(R"({"parameters": {"parts": 2}, "parameter_ranges": {"parts": {"at_least": 3, "at_most": 1}}})"),
              Reports(Code::kOutOfRange, "/parameter_ranges/parts/at_most"));
  EXPECT_THAT(reported(R"({"parameters": {"kind": "a"}, "parameter_ranges": {"kind": {"one_of": []}}})"),
              Reports(Code::kWrongSize, "/parameter_ranges/kind/one_of"));
  EXPECT_THAT(reported(R"({"objects": {"part #": {"copies": 2}}})"),
              Reports(Code::kWrongType, "/objects/part #/copies"));
}

}  // namespace
}  // namespace takt::cell
