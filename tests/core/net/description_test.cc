#include "core/net/description.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/json.h"
#include "core/net/registry.h"
#include "tests/core/net/net_support.h"
#include "tests/support/reports.h"

namespace takt::net {
namespace {

using takt::test::Reports;
using testing::UnorderedElementsAre;

std::vector<Diagnostic> diagnostics(std::string_view text) {
  const auto document = parse_json(text);
  if (!document) return document.error().list();
  const auto net = net_from_json(*document);
  return net ? std::vector<Diagnostic>() : net.error().list();
}

TEST(NetJson, ReadsEveryPart) {
  const auto document = parse_json(R"({"name": "n", "primitives": [{"id": "a", "type": "T", "parameters": {"x": [1]},
                                                                          "on_null": {"y": {"bridge_cycles": 3}}}],
    "demands": [{"from": "a.o", "to": "b.i", "maximum_cycles": 3, "minimum_cycles": 1}],
    "links": [{"from": "a.o", "to": "b.i", "delayed": true, "initial": 0.5}],
    "fragments": [{"id": "f", "when_inactive": "keep", "inputs": [{"port": "p", "to": "q.i"}],
                   "outputs": [{"port": "r", "from": "q.o"}], "net": {"primitives": [{"id": "q", "type": "Q"}]}}]})");
  const auto net = net_from_json(*document);
  ASSERT_TRUE(net.has_value()) << net.error().to_string();
  NetDescription wanted;
  wanted.name = "n";
  wanted.add("a", "T", {{"x", {1}}}).link_delayed("a.o", "b.i", 0.5);
  wanted.primitives[0].on_null["y"] = {{"bridge_cycles", 3}};
  wanted.demand("a.o", "b.i", 3).demands[0].minimum_cycles = 1;
  FragmentDescription f;
  f.id = "f";
  f.when_inactive = WhenInactive::kKeep;
  f.net.add("q", "Q");
  f.inputs = {{"p", "q.i"}};
  f.outputs = {{"r", "q.o"}};
  wanted.fragments.push_back(f);
  EXPECT_TRUE(*net == wanted);
  EXPECT_TRUE(*net_from_json(net_to_json(wanted)) == wanted);
}

TEST(NetJson, EveryMistakeWithItsPointer) {
  EXPECT_THAT(diagnostics(R"({"nmae": "n", "primitives": [{"id": 1, "typ": "T"}, 5],
    "links": [{"from": "a.o", "delayed": 1}, {"from": "a", "to": "b", "initail": 0}],
    "fragments": [{"id": "f", "when_inactive": "rest", "net": {"link": []}, "inputs": [{"port": "p"}]},
                  {"id": "g"}]})"),
              UnorderedElementsAre(
                  Reports(Code::kUnknownKey, "/nmae"), Reports(Code::kWrongType, "/primitives/0/id"),
                  Reports(Code::kUnknownKey, "/primitives/0/typ"), Reports(Code::kMissing, "/primitives/0", {"type"}),
                  Reports(Code::kWrongType, "/primitives/1"), Reports(Code::kWrongType, "/links/0/delayed"),
                  Reports(Code::kMissing, "/links/0"), Reports(Code::kUnknownKey, "/links/1/initail"),
                  Reports(Code::kUnknownName, "/fragments/0/when_inactive"),
                  Reports(Code::kUnknownKey, "/fragments/0/net/link"), Reports(Code::kMissing, "/fragments/0/inputs/0"),
                  Reports(Code::kMissing, "/fragments/1")));
}

TEST(NetJson, WhatIsNoNet) {
  for (const char* text :
       {"[]", "1", "null", "\"x\"", R"({"primitives": {}})", R"({"links": 1})", R"({"fragments": "f"})"}) {
    EXPECT_FALSE(diagnostics(text).empty()) << text;
  }
}

TEST(NetJson, DuplicateKeysAreRefusedByTheReader) {
  EXPECT_THAT(diagnostics(R"({"primitives": [{"id": "a", "id": "b", "type": "T"}]})"),
              testing::ElementsAre(Reports(Code::kDuplicate, "/primitives/0/id")));
}

TEST(Registry, DescribesATypeWithoutANet) {
  const PrimitiveInfo* drive = Registry::global().find("TestDrive");
  ASSERT_NE(drive, nullptr);
  EXPECT_EQ(drive->family, "test");
  EXPECT_EQ(drive->claims, "device");
  ASSERT_EQ(drive->parameters.size(), 3u);
  EXPECT_EQ(drive->parameters[0].type, "device:drive");
  EXPECT_EQ(drive->parameters[1].name, "speed");
  EXPECT_EQ(drive->parameters[1].fallback, "");
  EXPECT_EQ(drive->parameters[1].spec.unit, "m/s");
  EXPECT_EQ(drive->parameters[2].fallback, "\"slow\"");
  EXPECT_FALSE(drive->source);
  EXPECT_TRUE(Registry::global().find("TestEnd")->termination);
  EXPECT_TRUE(Registry::global().find("TestMonitor")->monitor);
  EXPECT_THAT(Registry::global().find("TestPrevious")->loop_breaking_inputs, testing::ElementsAre("in"));
  EXPECT_EQ(Registry::global().find("Nothing"), nullptr);
  EXPECT_TRUE(std::ranges::is_sorted(Registry::global().names()));
}

TEST(RegistryDeathTest, ANameTwiceIsAProgrammingError) {
  EXPECT_DEATH(Registry::global().add("TestAdd", "", "", {}), "TestAdd is registered twice");
}

}  // namespace
}  // namespace takt::net
