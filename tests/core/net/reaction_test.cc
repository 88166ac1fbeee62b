// The reaction certificate (rows O6, O7), by hand and against measured reactions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/net/registry.h"
#include "core/net/setup.h"
#include "tests/core/net/net_support.h"
#include "tests/support/reports.h"

namespace takt::net {
namespace {

using takt::test::Notes;
using takt::test::Reports;

using Reaction = NetReport::Reaction;

/// Gives 1 in one cycle of the core, else 0: an event from outside.
class TestEvent : public Primitive {
 public:
  explicit TestEvent(Setup& setup)
      : out_(setup.out<Real>("out", {.unit = "1"})), at_(setup.parameter<Integer>("at", 0)) {
    setup.is_source();
  }
  void update(const Cycle& cycle) override { out_.set(cycle.index_in_net == at_ ? 1.0 : 0.0); }

 private:
  Out<Real> out_;
  Integer at_;
};
TAKT_PRIMITIVE(TestEvent, "test", "One at one cycle.");

/// Three cycles late, as it declares.
class TestLate : public Primitive {
 public:
  explicit TestLate(Setup& setup)
      : in_(setup.in<Real>("in", {.unit = "u"})), out_(setup.out<Real>("out", {.unit = "u"})) {
    setup.latency("in", "out", {.cycles = 3});
  }
  void update(const Cycle& cycle) override {
    if (cycle.first) past_ = {};
    if (in_.null()) return out_.set_null();
    out_.set(past_[static_cast<std::size_t>(cycle.index_in_net % 3)]);
    past_[static_cast<std::size_t>(cycle.index_in_net % 3)] = *in_;
  }

 private:
  In<Real> in_;
  Out<Real> out_;
  std::array<double, 3> past_{};
};
TAKT_PRIMITIVE(TestLate, "test", "Three cycles ago.");

class TestDebounce : public Primitive {
 public:
  explicit TestDebounce(Setup& setup)
      : in_(setup.in<Real>("in", {.unit = "u"})), out_(setup.out<Real>("out", {.unit = "u"})) {
    setup.latency("in", "out", {.cycles = 1, .data_dependent = true});
  }
  void update(const Cycle&) override {
    if (in_.null()) return out_.set_null();
    out_.set(*in_);
  }

 private:
  In<Real> in_;
  Out<Real> out_;
};
TAKT_PRIMITIVE(TestDebounce, "test", "Later, depending on data.");

/// As late as its parameter says.
class TestShift : public Primitive {
 public:
  explicit TestShift(Setup& setup)
      : in_(setup.in<Real>("in", {.unit = "u"})),
        out_(setup.out<Real>("out", {.unit = "u"})),
        cycles_(setup.parameter<Integer>("cycles", 2, {.range = "[0,100]"})) {
    setup.latency_by("in", "out", "cycles");
  }
  void update(const Cycle&) override {
    if (in_.null() || cycles_ > 100) return out_.set_null();
    out_.set(*in_);
  }

 private:
  In<Real> in_;
  Out<Real> out_;
  std::int64_t cycles_;
};
TAKT_PRIMITIVE(TestShift, "test", "Later, by a parameter.");

void PrintReaction(const Reaction& r, std::ostream* stream) {
  *stream << r.source << " -> " << r.sink << " " << r.minimum_cycles << ".." << r.maximum_cycles;
}

std::vector<std::string> certificate(const NetDescription& description) {
  const auto net = make_net(description);
  std::vector<std::string> lines;
  for (const Reaction& r : net->report().reactions) {
    std::ostringstream line;
    PrintReaction(r, &line);
    lines.push_back(line.str() + (r.data_dependent ? " data" : ""));
  }
  return lines;
}

/// e -> two ways -> m
NetDescription two_routes() {
  NetDescription d;
  d.add("end", "TestEnd").add("e", "TestEvent").add("sum", "TestAdd").add("late", "TestLate").add("m", "TestMonitor");
  d.link("e.out", "sum.a").link("e.out", "late.in").link("late.out", "sum.b").link("sum.out", "m.in");
  return d;
}

TEST(Reaction, RowO6ShortestAndLongestWay) {
  auto d = two_routes();
  EXPECT_THAT(certificate(d), testing::ElementsAre("e -> m.in 0..3"));
  d.links[0].delayed = true;
  EXPECT_THAT(certificate(d), testing::ElementsAre("e -> m.in 1..3"));
  d.links[3].delayed = true;
  EXPECT_THAT(certificate(d), testing::ElementsAre("e -> m.in 2..4"));
}

TEST(Reaction, RowO6DataDependentWaysAreMarked) {
  auto d = two_routes();
  d.primitives[3].type = "TestDebounce";
  EXPECT_THAT(certificate(d), testing::ElementsAre("e -> m.in 0..1 data"));
  EXPECT_THAT(make_net(d)->report().notes, Notes("/primitives/3", {"late.in", "late.out"}));
}

TEST(Reaction, RowO6AParameterMaySayHowManyCycles) {
  auto d = two_routes();
  d.primitives[3].type = "TestShift";
  EXPECT_THAT(certificate(d), testing::ElementsAre("e -> m.in 0..2"));
  d.primitives[3].parameters["cycles"] = 7;
  EXPECT_THAT(certificate(d), testing::ElementsAre("e -> m.in 0..7"));
  const auto report = report_to_json(make_net(d)->report());
  EXPECT_EQ(report["primitives"][3]["latencies"][0]["cycles"], 7);
  d.demand("e.out", "m.in", 6);
  TestDevices devices;
  const auto refused = CompiledNet::compile(d, devices);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error(), Reports(Code::kReactionBound, "/demands/0/maximum_cycles", {"7"}));
  d.primitives[3].parameters["cycles"] = "many";  // one diagnostic, of the parameter
  EXPECT_THAT(CompiledNet::compile(d, devices).error(), Reports(Code::kSyntax, "/primitives/3/parameters/cycles"));
}

TEST(Reaction, RowO7ALoopCountsItsDelayOnlyOnTheWayThatPassesIt) {
  // e -> act -> monitor m; act's state comes back one cycle late; n looks at what comes back.
  NetDescription d;
  d.add("end", "TestEnd").add("e", "TestEvent").add("act", "TestAdd").add("gain", "TestMultiply", {{"b", 0.5}});
  d.add("m", "TestMonitor").add("n", "TestMonitor");
  d.link("e.out", "act.a").link("act.out", "m.in").link_delayed("act.out", "gain.a", 0.0).link("gain.out", "act.b");
  d.link("gain.out", "n.in");
  EXPECT_THAT(certificate(d), testing::ElementsAre("e -> m.in 0..0", "e -> n.in 1..1"));
}

TEST(Reaction, InputsThatBreakLoopsCountOneCycle) {
  NetDescription d;
  d.add("end", "TestEnd").add("e", "TestEvent").add("p", "TestPrevious").add("m", "TestMonitor");
  d.link("e.out", "p.in").link("p.out", "m.in");
  EXPECT_THAT(certificate(d), testing::ElementsAre("e -> m.in 1..1"));
}

TEST(Reaction, WhatSwitchesAFragmentReachesItsOutputs) {
  NetDescription d;
  d.add("end", "TestEnd").add("e", "TestEvent").add("on", "TestGreater", {{"b", 0.5}}).add("m", "TestMonitor");
  FragmentDescription f;
  f.id = "f";
  f.net.add("c", "TestConstant", {{"value", 1}});
  f.outputs = {{"v", "c.out"}};
  d.fragments.push_back(f);
  d.link("e.out", "on.a").link_delayed("on.out", "f.active", false).link("f.v", "m.in");
  EXPECT_THAT(certificate(d), testing::ElementsAre("e -> m.in 1..1"));
}

/// A member that is three cycles late begins at once when its fragment does, and three cycles later gives what it reads
/// from then on: both are reactions to the switch.
TEST(Reaction, WhatSwitchesAFragmentReachesItsLateMembersLateToo) {
  NetDescription d;
  d.add("end", "TestEnd").add("e", "TestEvent").add("on", "TestGreater", {{"b", 0.5}}).add("m", "TestMonitor");
  FragmentDescription f;
  f.id = "f";
  f.net.add("late", "TestLate", {{"in", 1.0}});
  f.outputs = {{"v", "late.out"}};
  d.fragments.push_back(f);
  d.link("e.out", "on.a").link("on.out", "f.active").link("f.v", "m.in");
  EXPECT_THAT(certificate(d), testing::ElementsAre("e -> m.in 0..3"));
}

TEST(Reaction, EveryStopIsASink) {
  NetDescription d;
  d.add("end", "TestEnd").add("e", "TestEvent").add("g", "TestGreater", {{"b", 0.5}});
  d.link("e.out", "g.a").link("g.out", "end.in");
  EXPECT_THAT(certificate(d), testing::ElementsAre("e -> end.in 0..0"));
}

/// Random nets of sums with hidden delays: the first cycle in which the monitor differs from a run without the event is
/// the certified minimum, the last is at most the certified maximum, and without loops it is the maximum.
TEST(Reaction, RowO6MeasuredReactionsKeepTheCertificate) {
  int tight = 0, measured = 0;
  for (int seed = 0; seed < 400; ++seed) {
    Random random(static_cast<std::uint64_t>(seed), "reaction");
    NetDescription d;
    d.add("end", "TestEnd").add("e", "TestEvent", {{"at", 5}});
    std::vector<std::string> outputs{"e.out"};
    for (int i = 0; i < 12; ++i) {
      const std::string id = fmt::format("{}{}", static_cast<char>('a' + random.bits() % 26), i);
      const bool late = random.unit() < 0.2;
      d.add(id, late ? "TestLate" : "TestAdd");
      for (const char* input : late ? std::vector<const char*>{"in"} : std::vector<const char*>{"a", "b"}) {
        const std::string& from = outputs[random.bits() % outputs.size()];
        if (random.unit() < 0.3) {
          d.link_delayed(from, id + "." + input, 0.0);
        } else {
          d.link(from, id + "." + input);
        }
      }
      outputs.push_back(id + ".out");
    }
    d.add("m", "TestMonitor").link(outputs.back(), "m.in");
    const auto net = make_net(d);
    ASSERT_EQ(net->report().reactions.size(), 1u);
    const Reaction& reaction = net->report().reactions[0];
    std::int64_t first = -1, last = -1;
    for (int i = 0; i < 80; ++i) {
      net->evaluate({.index = i});
      const auto* slot = static_cast<const Slot<Real>*>(net->monitors()[0].slot);
      if (slot->null == 0 && slot->value != 0.0) {
        if (first < 0) first = i - 5;
        last = i - 5;
      }
    }
    ++measured;
    EXPECT_EQ(first, reaction.minimum_cycles) << "seed " << seed;
    EXPECT_LE(last, reaction.maximum_cycles) << "seed " << seed;
    tight += last == reaction.maximum_cycles ? 1 : 0;
  }
  EXPECT_EQ(tight, measured) << "sums of positive values lose no way";
}

}  // namespace
}  // namespace takt::net
