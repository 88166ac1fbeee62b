// Demanded bounds and critical paths (rows O6, O7); what null means where the net says so (rows N3, N4); the report.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/core/net/net_support.h"
#include "tests/support/reports.h"

namespace takt::net {
namespace {

using takt::test::Notes;
using takt::test::Reports;
using testing::ElementsAre;
using testing::IsEmpty;

std::vector<Diagnostic> errors_of(const NetDescription& net) {
  TestDevices devices;
  const auto compiled = CompiledNet::compile(net, devices);
  return compiled ? std::vector<Diagnostic>() : compiled.error().list();
}

/// s -> r -> (at once, and by way of a delayed gain) -> sum -> m
NetDescription dual_entry() {
  NetDescription d;
  d.add("end", "TestEnd").add("s", "TestCounter").add("r", "TestToReal").add("sum", "TestAdd").add("m", "TestMonitor");
  d.add("g", "TestMultiply", {{"b", 2.0}});
  d.link("s.out", "r.in").link("r.out", "sum.a").link_delayed("r.out", "g.a", 0.0).link("g.out", "sum.b");
  return d.link("sum.out", "m.in");
}

TEST(Demands, RowO7AKeptBoundIsReportedWithItsCriticalPath) {
  auto d = dual_entry();
  d.demand("s.out", "m.in", 1).demands[0].minimum_cycles = 0;
  const auto net = make_net(d);
  ASSERT_NE(net, nullptr);
  ASSERT_EQ(net->report().demands.size(), 1u);
  const NetReport::Demand& demand = net->report().demands[0];
  EXPECT_EQ(demand.minimum_cycles, 0);
  EXPECT_EQ(demand.maximum_cycles, 1);
  EXPECT_THAT(demand.links, ElementsAre(0, 2, 3, 4));
}

TEST(Demands, RowO7ABrokenMaximumNamesTheLongestWay) {
  auto d = dual_entry();
  d.demand("s.out", "m.in", 0);
  EXPECT_THAT(errors_of(d),
              ElementsAre(Reports(Code::kReactionBound, "/demands/0/maximum_cycles", {"s.out", "m.in", "1", "0"})));
}

TEST(Demands, RowO7ABrokenMinimumNamesTheShortestWay) {
  auto d = dual_entry();
  d.demand("s.out", "m.in", 5).demands[0].minimum_cycles = 1;
  EXPECT_THAT(errors_of(d), ElementsAre(Reports(Code::kReactionBound, "/demands/0/minimum_cycles", {"0"})));
}

TEST(Demands, LatenciesOfPrimitivesAreNamed) {
  NetDescription d;
  d.add("end", "TestEnd").add("s", "TestSum", {{"in", 1.0}}).add("late", "TestLags").add("m", "TestMonitor");
  d.link("s.out", "late.in").link("late.fixed", "m.in").demand("s.out", "m.in", 2);
  EXPECT_THAT(errors_of(d), ElementsAre(Reports(Code::kReactionBound, "/demands/0/maximum_cycles", {"3"})));
  d.demands[0].maximum_cycles = 3;
  EXPECT_THAT(errors_of(d), IsEmpty());
}

TEST(Demands, RowO6ATimeThatDependsOnDataHasNoBound) {
  NetDescription d;
  d.add("end", "TestEnd").add("s", "TestSum", {{"in", 1.0}}).add("late", "TestLags").add("m", "TestMonitor");
  d.link("s.out", "late.in").link("late.some_day", "m.in").demand("s.out", "m.in", 1'000'000);
  EXPECT_THAT(errors_of(d), ElementsAre(Reports(Code::kReactionBound, "/demands/0", {"some_day"})));
}

TEST(Demands, WhatNeverArrivesKeepsNoBound) {
  auto d = dual_entry();
  d.demand("m.out", "s.in", 1).demand("sum.out", "r.in", 1);
  EXPECT_THAT(errors_of(d), ElementsAre(Reports(Code::kUnknownName, "/demands/0/from"),
                                        Reports(Code::kUnknownName, "/demands/0/to")));
  d.demands.erase(d.demands.begin());
  EXPECT_THAT(errors_of(d), ElementsAre(Reports(Code::kReactionBound, "/demands/0", {"sum.out", "r.in"})));
  d.demands[0].minimum_cycles = 2;
  EXPECT_THAT(errors_of(d), testing::Contains(Reports(Code::kOutOfRange, "/demands/0")));
}

TEST(Demands, InsideFragmentsAndThroughTheirPorts) {
  NetDescription d;
  d.add("end", "TestEnd").add("s", "TestCounter").add("r", "TestToReal").add("m", "TestMonitor");
  FragmentDescription f;
  f.id = "f";
  f.net.add("late", "TestLags").add("sum", "TestAdd", {{"b", 1.0}}).link("late.fixed", "sum.a");
  f.net.demand("late.fixed", "sum.a", 0);
  f.inputs = {{"in", "late.in"}};
  f.outputs = {{"out", "sum.out"}};
  d.fragments.push_back(f);
  d.link("s.out", "r.in")
      .link("r.out", "f.in")
      .link("f.out", "m.in")
      .demand("r.out", "f.in", 0)
      .demand("f.out", "m.in", 0);
  EXPECT_THAT(errors_of(d), IsEmpty());
  d.demand("s.out", "m.in", 2);
  EXPECT_THAT(errors_of(d), ElementsAre(Reports(Code::kReactionBound, "/demands/2/maximum_cycles", {"3"})));
}

/// In a loop the critical path enters, goes round as far as it can without passing a port twice, and leaves.
TEST(Demands, TheCriticalPathRunsThroughALoop) {
  NetDescription d;
  d.add("end", "TestEnd").add("s", "TestCounter").add("r", "TestToReal").add("a", "TestAdd").add("b", "TestAdd");
  d.add("m", "TestMonitor");
  d.link("s.out", "r.in").link("r.out", "a.a").link_delayed("a.out", "b.a", 0.0).link("r.out", "b.b");
  d.link_delayed("b.out", "a.b", 0.0).link("a.out", "m.in").demand("s.out", "m.in", 1);
  EXPECT_THAT(errors_of(d), IsEmpty());
  const auto net = make_net(d);
  EXPECT_THAT(net->report().demands[0].links, ElementsAre(0, 3, 4, 5));
  ASSERT_EQ(net->report().reactions.size(), 1u);
  EXPECT_THAT(net->report().reactions[0].links, ElementsAre(0, 3, 4, 5));
  EXPECT_TRUE(net->report().reactions[0].exact);
}

// What null means.

TEST(OnNull, RowN3TheNetDeclaresWhatNullMeansAtAStop) {
  NetDescription d;
  d.add("end", "TestEnd").add("q", "TestDivide", {{"a", 1}, {"b", 0}}).add("g", "TestGreater", {{"b", 0}});
  d.add("stop", "TestStop").link("q.out", "g.a").link("g.out", "stop.condition");
  auto net = make_net(d);
  EXPECT_THAT(net->report().notes, Notes("/primitives/3"));
  net->evaluate({});
  EXPECT_TRUE(net->signals().fail);

  d.primitives.back().on_null = {{"condition", false}};
  net = make_net(d);
  ASSERT_EQ(net->report().null_paths.size(), 1u);
  EXPECT_EQ(net->report().null_paths[0].meaning, "false");
  EXPECT_THAT(net->report().null_paths[0].ports, ElementsAre("q.out", "g.out", "stop.condition"));
  EXPECT_THAT(net->report().null_paths[0].links, ElementsAre(0, 1));
  net->evaluate({});
  EXPECT_FALSE(net->signals().fail);

  d.primitives.back().on_null = {{"condition", true}, {"unless", true}};
  net = make_net(d);
  net->evaluate({});
  EXPECT_FALSE(net->signals().fail) << "null at `unless` counts as true now";
}

TEST(OnNull, RowN4TheNetDeclaresHowManyCyclesAreBridged) {
  NetDescription d;
  d.add("end", "TestEnd").add("b", "TestBridge", {{"in", nullptr}});
  const auto lasts = [&] {
    const auto net = make_net(d);
    int cycles = 0;
    for (; cycles < 20 && !net->signals().fail; ++cycles) net->evaluate({.index = cycles});
    return cycles;
  };
  EXPECT_EQ(lasts(), 1);
  d.primitives[1].on_null = {{"in", "stop"}};
  EXPECT_EQ(lasts(), 1);
  d.primitives[1].on_null = {{"in", {{"bridge_cycles", 4}}}};
  EXPECT_EQ(lasts(), 5);
  EXPECT_EQ(make_net(d)->report().null_paths[0].meaning, "bridge 4 cycles");
  EXPECT_EQ(make_net(d)->report().null_paths[0].origin, "the constant null");
}

TEST(OnNull, WhatCannotBeDeclared) {
  NetDescription d;
  d.add("end", "TestEnd").add("stop", "TestStop", {{"condition", false}}).add("b", "TestBridge", {{"in", 1.0}});
  d.add("add", "TestAdd", {{"a", 1}, {"b", 1}});
  d.primitives[1].on_null = {{"condition", "stop"}, {"unles", true}};
  d.primitives[2].on_null = {{"in", {{"bridge_cycles", -1}}}};
  d.primitives[3].on_null = {{"a", true}};
  EXPECT_THAT(errors_of(d), ElementsAre(Reports(Code::kInvalidValue, "/primitives/1/on_null/condition"),
                                        Reports(Code::kUnknownName, "/primitives/1/on_null/unles", {"unless"}),
                                        Reports(Code::kUnknownName, "/primitives/2/on_null/in", {"0", "1000"}),
                                        Reports(Code::kUnknownName, "/primitives/3/on_null/a")));
  d.primitives[1].on_null = 5;
  EXPECT_THAT(errors_of(d), testing::Contains(Reports(Code::kWrongType, "/primitives/1/on_null", {"on_null"})));
}

TEST(OnNull, RowN4NullPassesLogicSelectionsAndMerges) {
  NetDescription d;
  d.add("end", "TestEnd").add("x", "TestTernary").add("n", "TestNot").add("and", "TestAnd", {{"b", true}});
  d.add("m", "TestMerge").add("sink", "TestForceSink");
  d.link("x.out", "n.in").link("x.out", "and.a").link("and.out", "end.in").link("m.out", "sink.in");
  for (int i = 0; i < 2; ++i) {
    FragmentDescription f;
    f.id = i == 0 ? "f" : "g";
    f.net.add("c", "TestConstant", {{"value", 1}});
    f.outputs = {{"out", "c.out"}};
    d.fragments.push_back(f);
    d.link(i == 0 ? "x.out" : "n.out", f.id + ".active").link(f.id + ".out", fmt::format("m.input_{}", i + 1));
  }
  const auto net = make_net(d);
  std::vector<std::string> at;
  for (const auto& path : net->report().null_paths) at.push_back(fmt::format("{}", fmt::join(path.ports, " -> ")));
  EXPECT_THAT(at, ElementsAre("x.out -> and.out -> end.in", "f/c.out -> m.out -> sink.in"));
}

// The report.

TEST(Report, AsData) {
  auto d = dual_entry();
  FragmentDescription f;
  f.id = "f";
  f.when_inactive = WhenInactive::kKeep;
  f.net.add("late", "TestLags", {{"in", nullptr}});
  d.fragments.push_back(f);
  d.add("x", "TestTernary").link("x.out", "f.active");
  const auto net = make_net(d);
  const auto json = report_to_json(net->report());
  EXPECT_EQ(json["order"].size(), 8u);
  EXPECT_EQ(json["fragments"],
            nlohmann::ordered_json::parse(R"([{"id": "f", "can_rest": true, "when_inactive": "keep"}])"));
  EXPECT_EQ(json["primitives"][1]["id"], "s");
  EXPECT_EQ(json["primitives"][1]["type"], "TestCounter");
  EXPECT_EQ(json["primitives"].back()["id"], "f/late");
  EXPECT_EQ(json["primitives"].back()["fragment"], "f");
  EXPECT_EQ(json["primitives"].back()["latencies"][0]["cycles"], 3);
  EXPECT_EQ(json["links"][2],
            nlohmann::ordered_json::parse(R"({"from": "r.out", "to": "g.a", "delayed": true, "may_be_null": true})"));
  EXPECT_EQ(json["links"].back()["to"], "f.active");
  EXPECT_EQ(json["reactions"][0]["critical_path"],
            nlohmann::ordered_json::parse(R"(["s.out", "r.in", "r.out", "g.a", "g.out", "sum.b", "sum.out", "m.in"])"));
  for (const auto& primitive : json["primitives"]) {
    EXPECT_EQ(json["order"][primitive["order"].get<std::size_t>()], primitive["id"]);
  }
}

}  // namespace
}  // namespace takt::net
