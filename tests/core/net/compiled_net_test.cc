#include "core/net/compiled_net.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/net/net_support.h"
#include "tests/support/primitive_harness.h"

namespace takt::net {
namespace {

using testing::ElementsAre;

TEST(CompiledNet, EvaluatesInTheOrderOfTheLinks) {
  NetDescription d;
  d.add("z", "TestConstant", {{"value", 2.0}}).add("a", "TestAdd", {{"b", 1.0}}).add("m", "TestAdd", {{"b", 10.0}});
  d.add("end", "TestEnd").link("z.out", "m.a").link("m.out", "a.a");
  const auto net = make_net(d);
  run(*net, 1);
  EXPECT_EQ(real(*net, "a.out"), 13.0);
  EXPECT_THAT(net->report().order, ElementsAre("end", "z", "m", "a"));
  EXPECT_EQ(net->find<Real>("a.nothing"), nullptr);
  EXPECT_EQ(net->find<Integer>("a.out"), nullptr);
}

TEST(CompiledNet, RowO2DelayedLinkDelaysOneCycleAndStartsWithItsInitial) {
  NetDescription d;
  d.add("n", "TestCounter").add("r", "TestToReal").add("end", "TestEnd").link("n.out", "r.in");
  d.add("with", "TestAdd", {{"b", 0.0}}).add("without", "TestAdd", {{"b", 0.0}}).add("again", "TestAdd", {{"b", 0.0}});
  d.link_delayed("r.out", "with.a", 7.5).link_delayed("r.out", "without.a").link_delayed("with.out", "again.a");
  const auto net = make_net(d);
  run(*net, 1);
  EXPECT_EQ(real(*net, "with.out"), 7.5);
  EXPECT_EQ(real(*net, "without.out"), std::nullopt);
  EXPECT_EQ(real(*net, "again.out"), std::nullopt);
  run(*net, 1);
  EXPECT_EQ(real(*net, "with.out"), 0.0);
  EXPECT_EQ(real(*net, "without.out"), 0.0);
  EXPECT_EQ(real(*net, "again.out"), 7.5);
  run(*net, 3);
  EXPECT_EQ(real(*net, "with.out"), 3.0);
  EXPECT_EQ(real(*net, "again.out"), 2.0);
}

TEST(CompiledNet, RowO2LoopsCloseOverADelay) {
  NetDescription d;
  d.add("one", "TestConstant", {{"value", 1.0}}).add("sum", "TestAdd").add("end", "TestEnd");
  d.link("one.out", "sum.a").link_delayed("sum.out", "sum.b", 0.0);
  const auto net = make_net(d);
  run(*net, 5);
  EXPECT_EQ(real(*net, "sum.out"), 5.0);
}

TEST(CompiledNet, AnInputThatBreaksLoopsReadsTheCycleBeforeWhateverTheOrder) {
  // "a" is evaluated before, "z" after their source.
  for (const char* id : {"a", "z"}) {
    NetDescription d;
    d.add("m", "TestCounter").add("n", "TestToReal").add(id, "TestPrevious").add("end", "TestEnd");
    d.link("m.out", "n.in").link("n.out", std::string(id) + ".in");
    const auto net = make_net(d);
    const std::string port = std::string(id) + ".out";
    run(*net, 1);
    EXPECT_EQ(real(*net, port), std::nullopt);
    run(*net, 3);
    EXPECT_EQ(real(*net, port), 2.0);
  }
}

TEST(CompiledNet, RowN5WhatIsNotFiniteBecomesNull) {
  NetDescription d;
  d.add("q", "TestDivide", {{"a", 1.0}, {"b", 0.0}})
      .add("z", "TestMultiply", {{"a", -1.0}, {"b", 0.0}})
      .add("end", "TestEnd");
  const auto net = make_net(d);
  run(*net, 1);
  EXPECT_EQ(real(*net, "q.out"), std::nullopt);
  EXPECT_EQ(net->find<Real>("q.out")->value, 0.0);
  ASSERT_EQ(real(*net, "z.out"), 0.0);
  EXPECT_FALSE(std::signbit(net->find<Real>("z.out")->value)) << "row N1: -0 is stored as +0";
}

TEST(CompiledNet, RowN6ConstantsFeedInputsNullIncluded) {
  NetDescription d;
  d.add("x", "TestAllTypes",
        {{"boolean", true},
         {"integer", -5},
         {"real", 2.5},
         {"text", "grün"},
         {"vector", {1, 2, 3}},
         {"rotation", {0.7071, 0, 0, 0.7071}},
         {"frame", {{"position", {1, 2, 3}}, {"quaternion", {1, 0, 0, 0}}}},
         {"twist", {{"linear", {1, 0, 0}}}},
         {"wrench", nullptr}});
  d.add("end", "TestEnd");
  const auto net = make_net(d);
  run(*net, 1);
  EXPECT_TRUE(net->find<Boolean>("x.boolean_out")->value);
  EXPECT_EQ(net->find<Integer>("x.integer_out")->value, -5);
  EXPECT_EQ(net->find<Text>("x.text_out")->value.view(), "grün");
  EXPECT_EQ(net->find<Vector>("x.vector_out")->value, Vector(1, 2, 3));
  EXPECT_NEAR(net->find<Rotation>("x.rotation_out")->value.norm(), 1.0, 1e-15);
  EXPECT_EQ(net->find<Frame>("x.frame_out")->value.translation(), Vector(1, 2, 3));
  EXPECT_EQ(net->find<Twist>("x.twist_out")->value.linear, Vector(1, 0, 0));
  EXPECT_EQ(net->find<Wrench>("x.wrench_out")->null, 1u);
  EXPECT_EQ(net->find<JointArray>("x.joints_out")->null, 1u) << "optional, unset";
}

TEST(CompiledNet, RowL7AnExceptionFailsItsNetWithThePrimitiveNamed) {
  NetDescription d;
  d.add("bad", "TestThrow", {{"at", 2}}).add("sum", "TestSum", {{"in", 1.0}}).add("end", "TestEnd");
  const auto net = make_net(d);
  for (int i = 0; i < 5; ++i) net->evaluate({.index = 100 + i});
  EXPECT_TRUE(net->signals().fail);
  EXPECT_EQ(net->signals().cause.code, Cause::Code::kException);
  EXPECT_EQ(net->signals().cause.text.view(), "bad: broken on purpose");
  EXPECT_EQ(net->signals().cause.cycle, 102);
  EXPECT_EQ(real(*net, "sum.out"), 2.0) << "nothing runs after the failure";
}

TEST(CompiledNet, SlotsHoldNoByteThatNobodyWrote) {
  // Two nets in memory of different history must have equal bytes, paddings included.
  NetDescription d;
  d.add("x", "TestAllTypes", {{"boolean", true}, {"rotation", {1, 0, 0, 0}}, {"joints", {1, 2}}}).add("end", "TestEnd");
  d.add("y", "TestAllTypes").link("x.boolean_out", "y.boolean").link_delayed("x.rotation_out", "y.rotation");
  std::vector<std::byte> first;
  for (int round = 0; round < 3; ++round) {
    std::vector<std::unique_ptr<std::array<char, 4096>>> dirt;
    for (int i = 0; i < 64; ++i) {
      dirt.push_back(std::make_unique<std::array<char, 4096>>());
      dirt.back()->fill(static_cast<char>(0x5A + round));
    }
    dirt.clear();
    const auto net = make_net(d);
    run(*net, 3);
    const std::vector<std::byte> bytes(net->slots().begin(), net->slots().end());
    if (round == 0) first = bytes;
    EXPECT_EQ(bytes, first);
    std::size_t covered = 0;
    for (const auto& port : net->ports()) {
      EXPECT_LE(port.offset + port.size, bytes.size());
      covered += port.size;
    }
    EXPECT_GT(covered, bytes.size() / 2);
  }
}

TEST(CompiledNet, MonitorsReadTheSlotOfTheirSource) {
  NetDescription d;
  d.add("c", "TestConstant", {{"value", 4.0}})
      .add("speed", "TestMonitor")
      .add("end", "TestEnd")
      .link("c.out", "speed.in");
  const auto net = make_net(d);
  run(*net, 1);
  ASSERT_EQ(net->monitors().size(), 1u);
  EXPECT_EQ(net->monitors()[0].name, "speed");
  EXPECT_EQ(static_cast<const Slot<Real>*>(net->monitors()[0].slot)->value, 4.0);
}

TEST(PrimitiveContract, HoldsForTheTestPrimitives) {
  for (const char* type :
       {"TestAdd", "TestMultiply", "TestDivide", "TestSum", "TestToReal", "TestGreater", "TestAllTypes"}) {
    test::check_primitive_contract(type);
  }
}

}  // namespace
}  // namespace takt::net
