// Fragments (row O3): flattening, ports, activity, reset.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/net/net_support.h"
#include "tests/support/reports.h"

namespace takt::net {
namespace {

using takt::test::Notes;
using takt::test::Reports;

/// r counts 0, 1, 2, ...; `on` is true while r > threshold; the fragment sums r.
NetDescription summing(WhenInactive when, double threshold) {
  NetDescription d;
  d.name = "summing";
  d.add("n", "TestCounter").add("r", "TestToReal").add("on", "TestGreater", {{"b", threshold}}).add("end", "TestEnd");
  d.link("n.out", "r.in").link("r.out", "on.a");
  FragmentDescription f;
  f.id = "f";
  f.when_inactive = when;
  f.net.add("sum", "TestSum").add("old", "TestAdd", {{"b", 0}});
  f.net.link_delayed("sum.out", "old.a", -1.0);
  f.inputs = {{"value", "sum.in"}};
  f.outputs = {{"total", "sum.out"}, {"before", "old.out"}};
  d.fragments.push_back(f);
  d.add("out", "TestAdd", {{"b", 0}}).link("f.total", "out.a").link("r.out", "f.value");
  return d;
}

TEST(Fragment, UnlinkedItIsActive) {
  const auto net = make_net(summing(WhenInactive::kReset, 0));
  run(*net, 4);
  EXPECT_EQ(real(*net, "out.out"), 6.0);
  EXPECT_EQ(real(*net, "f/old.out"), 3.0);
}

TEST(Fragment, RowO3RestingGivesNullAndActivationIsAFirstCycle) {
  auto d = summing(WhenInactive::kReset, 2);
  d.link("on.out", "f.active");
  const auto net = make_net(d);
  run(*net, 3);
  EXPECT_EQ(real(*net, "out.out"), std::nullopt);
  EXPECT_EQ(real(*net, "f/sum.out"), std::nullopt);
  run(*net, 1);
  EXPECT_EQ(real(*net, "out.out"), 3.0) << "the sum begins at the activation, in the same cycle";
  EXPECT_EQ(real(*net, "f/old.out"), -1.0) << "delayed links inside begin with their initial value";
  run(*net, 1);
  EXPECT_EQ(real(*net, "out.out"), 7.0);
  EXPECT_EQ(real(*net, "f/old.out"), 3.0);
}

/// active in cycles 0-2, resting in 3, 4, active again: `pulse` is null in every 4th cycle of its own making.
NetDescription pulsing(WhenInactive when) {
  NetDescription d = summing(when, 0);
  d.add("gap", "TestCounter", {{"null_every", 4}}).add("g", "TestToReal").add("pulse", "TestGreater", {{"b", -1}});
  d.link("gap.out", "g.in").link("g.out", "pulse.a").link("pulse.out", "f.active");
  return d;
}

TEST(Fragment, RowO3KeepGoesOnResetBeginsAnew) {
  for (const auto when : {WhenInactive::kKeep, WhenInactive::kReset}) {
    const bool keep = when == WhenInactive::kKeep;
    const auto net = make_net(pulsing(when));
    run(*net, 3);
    EXPECT_EQ(real(*net, "out.out"), 3.0);
    run(*net, 1);
    EXPECT_EQ(real(*net, "out.out"), std::nullopt) << "active is null: the fragment rests";
    run(*net, 1);
    EXPECT_EQ(real(*net, "out.out"), keep ? 7.0 : 4.0);
    EXPECT_EQ(real(*net, "f/old.out"), keep ? 3.0 : -1.0);
  }
}

TEST(Fragment, AResetReachesFragmentsThatKeep) {
  NetDescription d = pulsing(WhenInactive::kReset);
  FragmentDescription inner;
  inner.id = "inner";
  inner.when_inactive = WhenInactive::kKeep;
  inner.net.add("sum", "TestSum", {{"in", 1.0}});
  inner.outputs = {{"total", "sum.out"}};
  d.fragments[0].net.fragments.push_back(inner);
  d.fragments[0].outputs.emplace_back("inner_total", "inner.total");
  d.add("deep", "TestAdd", {{"b", 0}}).link("f.inner_total", "deep.a");
  const auto net = make_net(d);
  run(*net, 3);
  EXPECT_EQ(real(*net, "deep.out"), 3.0);
  run(*net, 1);
  EXPECT_EQ(real(*net, "deep.out"), std::nullopt);
  run(*net, 2);
  EXPECT_EQ(real(*net, "deep.out"), 2.0);
  EXPECT_EQ(net->find<Real>("f/inner/sum.out")->value, 2.0);
}

TEST(Fragment, OneInputPortFeedsManyAndPortsPassThroughLevels) {
  NetDescription d;
  d.add("c", "TestConstant", {{"value", 2.0}}).add("end", "TestEnd");
  FragmentDescription inner, outer;
  inner.id = "inner";
  inner.net.add("x", "TestMultiply");
  inner.inputs = {{"v", "x.a"}, {"v", "x.b"}};
  inner.outputs = {{"square", "x.out"}};
  outer.id = "outer";
  outer.net.add("y", "TestAdd").link("inner.square", "y.a");
  outer.net.fragments.push_back(inner);
  outer.inputs = {{"v", "inner.v"}, {"v", "y.b"}};
  outer.outputs = {{"result", "y.out"}};
  d.fragments.push_back(outer);
  d.add("r", "TestAdd", {{"b", 0}}).link("c.out", "outer.v").link("outer.result", "r.a");
  d.add("s", "TestAdd", {{"b", 0}}).link("outer/inner/x.out", "s.a");
  const auto net = make_net(d);
  run(*net, 1);
  EXPECT_EQ(real(*net, "r.out"), 6.0);
  EXPECT_EQ(real(*net, "s.out"), 4.0) << "inner ports may be named outright";
}

TEST(Fragment, MistakesInPortsAreNamedOnce) {
  NetDescription d;
  d.add("end", "TestEnd").add("m", "TestMetres");
  FragmentDescription f;
  f.id = "f";
  f.net.add("x", "TestAdd", {{"b", 1}});
  f.inputs = {{"v", "x.aa"}, {"w", "x.a"}};
  f.outputs = {{"o", "y.out"}};
  d.fragments.push_back(f);
  f.id = "end";
  f.inputs = {{"w", "x.a"}, {"w", "x.a"}, {"active", "x.a"}};
  f.outputs = {};
  d.fragments.push_back(f);
  d.link("m.out", "f.v").link("m.out", "f.w").link("f.p", "end.in").link("m.out", "f.activ");
  TestDevices devices;
  const auto net = CompiledNet::compile(d, devices);
  ASSERT_FALSE(net.has_value());
  EXPECT_THAT(net.error().list(),
              testing::UnorderedElementsAre(Reports(Code::kUnknownName, "/fragments/0/inputs/0/to", {"x", "aa"}),
                                            Reports(Code::kUnknownName, "/fragments/0/outputs/0/from", {"y"}),
                                            Reports(Code::kDuplicate, "/fragments/1/id", {"end"}),
                                            Reports(Code::kDuplicate, "/fragments/1/inputs/1", {"w"}),
                                            Reports(Code::kDuplicate, "/fragments/1/inputs/2", {"active"}),
                                            Reports(Code::kUnlinkedInput, "/fragments/1/net/primitives/0", {"end/x.a"}),
                                            Reports(Code::kUnknownName, "/links/2/from", {"f", "p"}),
                                            Reports(Code::kUnknownName, "/links/3/to", {"f", "activ"})));
}

TEST(Fragment, ActivityThatWaitsForItsOwnFragmentIsACycle) {
  auto d = summing(WhenInactive::kReset, 0);
  d.add("late", "TestGreater", {{"b", 0}}).link("f.total", "late.a").link("late.out", "f.active");
  TestDevices devices;
  const auto net = CompiledNet::compile(d, devices);
  ASSERT_FALSE(net.has_value());
  EXPECT_THAT(net.error(), Reports(Code::kCycleWithoutDelay, "/links/4"));
  d.links.back() = {"late.out", "f.active", true, true};
  EXPECT_TRUE(CompiledNet::compile(d, devices).has_value());
}

TEST(Fragment, EndlessNestingIsRefused) {
  NetDescription d;
  for (int i = 0; i < 100; ++i) {
    FragmentDescription f;
    f.id = "f";
    f.net = std::move(d);
    d = NetDescription();
    d.fragments.push_back(std::move(f));
  }
  d.add("end", "TestEnd");
  TestDevices devices;
  const auto net = CompiledNet::compile(d, devices);
  ASSERT_FALSE(net.has_value());
  EXPECT_THAT(
      net.error(),
      Reports(
          Code::kTooLarge,
          "/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/"
          "0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/"
          "fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/"
          "net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/"
          "fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0/net/fragments/0",
          {"32"}));
}

TEST(Fragment, RestingFragmentsAreNullSourcesForReadersOutside) {
  auto d = summing(WhenInactive::kReset, 2);
  d.link("on.out", "f.active").add("g", "TestGreater", {{"b", 100}}).link("out.out", "g.a").link("g.out", "end.in");
  const auto net = make_net(d);
  EXPECT_THAT(net->report().notes, Notes("/primitives/3", {"end.in"}));
}

}  // namespace
}  // namespace takt::net
