// One driver (row O4): Merge, shared devices, and the proof that fragments exclude each other, by hand and against all
// that can really happen.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/net/formula.h"
#include "tests/core/net/net_support.h"
#include "tests/support/reports.h"

namespace takt::net {
namespace {

using takt::test::Notes;
using takt::test::Reports;
using testing::AllOf;
using testing::IsEmpty;

/// A fragment with one constant, active by `active`, whose output is linked to `to`.
void add_speaker(NetDescription& net, const std::string& id, const std::string& active, const std::string& to,
                 double value) {
  FragmentDescription fragment;
  fragment.id = id;
  fragment.net.add("c", "TestConstant", {{"value", value}});
  fragment.outputs = {{"out", "c.out"}};
  net.fragments.push_back(fragment);
  net.link(active, id + ".active").link(id + ".out", to);
}

/// Two fragments at one Merge, switched by these outputs.
NetDescription two_at_a_merge(const NetDescription& base, const std::string& one, const std::string& other) {
  NetDescription net = base;
  net.add("end", "TestEnd").add("m", "TestMerge");
  add_speaker(net, "a", one, "m.input_1", 1.0);
  add_speaker(net, "b", other, "m.input_2", 2.0);
  return net;
}

bool proven(const NetDescription& net) {
  const auto compiled = make_net(net);
  if (compiled == nullptr) return false;
  EXPECT_EQ(compiled->report().exclusions.size(), 1u);
  EXPECT_EQ(
      !testing::Matches(takt::test::ReportsAnywhere(Code::kNote, {"m.input_1", "m.input_2"}))(compiled->report().notes),
      compiled->report().exclusions.front().proven);
  return compiled->report().exclusions.front().proven;
}

NetDescription conditions() {
  NetDescription net;
  net.add("x", "TestTernary").add("y", "TestTernary", {{"weight", 3}}).add("n", "TestNot").link("x.out", "n.in");
  return net;
}

TEST(Exclusion, RowO4AConditionAndItsOpposite) {
  const auto description = two_at_a_merge(conditions(), "x.out", "n.out");
  EXPECT_TRUE(proven(description));
  const auto net = make_net(description);
  std::vector<std::optional<double>> values;
  for (int i = 0; i < 3; ++i) {
    Cycle cycle;
    cycle.index = i;
    net->evaluate(cycle);
    values.push_back(real(*net, "m.out"));
  }
  EXPECT_EQ(values, (std::vector<std::optional<double>>{1.0, 2.0, std::nullopt})) << "null rests both";
  EXPECT_FALSE(net->signals().fail);
}

TEST(Exclusion, RowO4WithoutAProofANoteSaysWhenAndAConflictFailsTheNet) {
  const auto net = make_net(two_at_a_merge(conditions(), "x.out", "y.out"));
  EXPECT_THAT(net->report().notes, AllOf(Notes("/primitives/4", {"m.input_1", "m.input_2"}),
                                         Notes("/primitives/4", {"x.out", "y.out"}), Notes("/primitives/4")));
  EXPECT_FALSE(net->report().exclusions.front().proven);
  net->evaluate({});
  EXPECT_EQ(net->signals().cause.code, Cause::Code::kConflict);
}

TEST(Exclusion, IntegersEqualToDifferentConstants) {
  NetDescription base;
  base.add("k", "TestCounter").add("one", "TestSame", {{"b", 1}}).add("two", "TestSame", {{"a", 2}});
  base.link("k.out", "one.a").link("k.out", "two.b");
  EXPECT_TRUE(proven(two_at_a_merge(base, "one.out", "two.out")));
  base.primitives[2].parameters["a"] = 1;
  EXPECT_FALSE(proven(two_at_a_merge(base, "one.out", "two.out")));
  // Beyond 2^53 neighbours look alike as doubles: no proof, but no lie either.
  base.primitives[1].parameters["b"] = 9007199254740993;
  base.primitives[2].parameters["a"] = 9007199254740992;
  EXPECT_FALSE(proven(two_at_a_merge(base, "one.out", "two.out")));
}

TEST(Exclusion, RangesOfANumber) {
  const auto ranges = [](double below, double above, const std::string& port) {
    NetDescription base;
    base.add("r", "TestSum", {{"in", 1.0}})
        .add("low", "TestLess", {{"b", below}})
        .add("high", "TestLess", {{"a", above}});
    base.link("r.out", "low.a").link("r.out", "high.b");
    return proven(two_at_a_merge(base, "low." + port, "high." + port));
  };
  EXPECT_TRUE(ranges(3.0, 5.0, "out"));
  EXPECT_TRUE(ranges(5.0, 5.0, "out"));
  EXPECT_FALSE(ranges(5.0, 5.0, "or_equal"));
  EXPECT_TRUE(ranges(5.0, std::nextafter(5.0, 6.0), "or_equal"));
  EXPECT_FALSE(ranges(5.0, 3.0, "out"));
}

TEST(Exclusion, TwoSignalsAgainstEachOther) {
  NetDescription base;
  base.add("p", "TestSum", {{"in", 1.0}}).add("q", "TestSum", {{"in", 2.0}}).add("f", "TestLess").add("g", "TestLess");
  base.link("p.out", "f.a").link("q.out", "f.b").link("q.out", "g.a").link("p.out", "g.b");
  EXPECT_TRUE(proven(two_at_a_merge(base, "f.out", "g.out"))) << "p < q and q < p";
  EXPECT_FALSE(proven(two_at_a_merge(base, "f.or_equal", "g.or_equal")));
}

TEST(Exclusion, OutputsThatAPrimitiveDeclaresExclusive) {
  NetDescription base;
  base.add("p", "TestPhases").add("q", "TestPhases");
  EXPECT_TRUE(proven(two_at_a_merge(base, "p.one", "p.three")));
  EXPECT_FALSE(proven(two_at_a_merge(base, "p.one", "q.three")));
}

TEST(Exclusion, NullCountsAsInactive) {
  NetDescription base = conditions();
  base.add("d", "TestElse", {{"b", false}}).add("nd", "TestNot").link("x.out", "d.a").link("d.out", "nd.in");
  EXPECT_TRUE(proven(two_at_a_merge(base, "x.out", "nd.out"))) << "nd is active while x is null, x is not";
  base.primitives[3].parameters["b"] = nullptr;
  EXPECT_TRUE(proven(two_at_a_merge(base, "x.out", "nd.out")));
  base.add("isn", "TestIsNull").link("x.out", "isn.in");
  EXPECT_TRUE(proven(two_at_a_merge(base, "isn.out", "n.out")));
}

TEST(Exclusion, DelaysAreFollowedIntoTheCyclesBefore) {
  auto net = two_at_a_merge(conditions(), "x.out", "n.out");
  const auto delay = [&](std::size_t link, nlohmann::ordered_json initial) {
    net.links[link].delayed = true;
    net.links[link].initial = std::move(initial);
  };
  // Links: 0 x -> n, 1 x -> a.active, 2 a.out, 3 n -> b.active, 4 b.out
  delay(1, false);
  EXPECT_FALSE(proven(net)) << "a is late by a cycle, b is not";
  delay(3, false);
  EXPECT_TRUE(proven(net));
  delay(3, true);
  EXPECT_TRUE(proven(net));
  delay(1, true);
  EXPECT_FALSE(proven(net)) << "both begin as active";
  net = two_at_a_merge(conditions(), "x.out", "n.out");
  delay(2, nullptr);
  EXPECT_FALSE(proven(net)) << "the last value of a arrives when b is active already";
  delay(4, nullptr);
  EXPECT_TRUE(proven(net));
}

TEST(Exclusion, ThroughFragmentsAndPrimitivesThatPropagateNull) {
  NetDescription net = conditions();
  net.add("end", "TestEnd").add("m", "TestMerge").add("sum", "TestAdd", {{"b", 1.0}});
  add_speaker(net, "a", "x.out", "sum.a", 1.0);
  net.link("sum.out", "m.input_1");
  FragmentDescription outer;
  outer.id = "o";
  FragmentDescription inner;
  inner.id = "i";
  inner.net.add("c", "TestConstant", {{"value", 1}});
  inner.outputs = {{"out", "c.out"}};
  outer.net.fragments.push_back(inner);
  outer.outputs = {{"out", "i.out"}};
  net.fragments.push_back(outer);
  net.link("n.out", "o.active").link("o.out", "m.input_2");
  EXPECT_TRUE(proven(net));
}

TEST(Exclusion, MergesOfMerges) {
  NetDescription net = conditions();
  net.add("end", "TestEnd").add("m", "TestMerge").add("inner", "TestMerge");
  net.add("both", "TestAnd").add("not_y", "TestNot").add("rest", "TestAnd");
  net.link("y.out", "not_y.in").link("x.out", "both.a").link("y.out", "both.b");
  net.link("x.out", "rest.a").link("not_y.out", "rest.b");
  add_speaker(net, "a", "both.out", "inner.input_1", 1.0);
  add_speaker(net, "b", "rest.out", "inner.input_2", 2.0);
  add_speaker(net, "c", "n.out", "m.input_2", 3.0);
  net.link("inner.out", "m.input_1");
  const auto compiled = make_net(net);
  for (const auto& exclusion : compiled->report().exclusions) EXPECT_TRUE(exclusion.proven) << exclusion.at;
}

/// Formulas of some depth over three conditions: what is proven never happens, what is not proven does happen.
TEST(Exclusion, RowO4TheProofIsRightAndCompleteForRandomFormulas) {
  constexpr int kConditions = 3;
  int proofs = 0, conflicts = 0;
  for (int seed = 0; seed < 600; ++seed) {
    Random random(static_cast<std::uint64_t>(seed), "formulas");
    NetDescription net;
    std::vector<std::string> ports;
    for (int i = 0; i < kConditions; ++i) {
      net.add(fmt::format("x{}", i), "TestTernary", {{"weight", static_cast<int>(std::pow(3, i))}});
      ports.push_back(fmt::format("x{}.out", i));
    }
    const auto any = [&] { return ports[random.bits() % ports.size()]; };
    for (int i = 0; i < 8; ++i) {
      const std::string id = fmt::format("f{}", i);
      static const std::array<std::string, 5> kTypes = {"TestNot", "TestIsNull", "TestAnd", "TestOr", "TestElse"};
      const std::string& type = kTypes[random.bits() % kTypes.size()];
      net.add(id, type);
      if (type == "TestNot" || type == "TestIsNull") {
        net.link(any(), id + ".in");
      } else {
        net.link(any(), id + ".a").link(any(), id + ".b");
      }
      ports.push_back(id + ".out");
    }
    net = two_at_a_merge(net, any(), any());
    const bool claim = proven(net);
    const auto compiled = make_net(net);
    for (int i = 0; i < std::pow(3, kConditions) && !compiled->signals().fail; ++i) {
      Cycle cycle;
      cycle.index = i;
      compiled->evaluate(cycle);
    }
    ASSERT_EQ(compiled->signals().fail, !claim) << "seed " << seed << "\n" << net_to_json(net).dump(1);
    ++(claim ? proofs : conflicts);
  }
  EXPECT_GT(proofs, 100);
  EXPECT_GT(conflicts, 100);
}

TEST(Exclusion, ALongChainOfConditionsGivesUpWithoutALie) {
  NetDescription net = conditions();
  net.add("c0", "TestAnd").link("x.out", "c0.a").link("y.out", "c0.b");
  for (int i = 1; i < 20'000; ++i) {
    const std::string id = fmt::format("c{}", i);
    net.add(id, "TestAnd").link(fmt::format("c{}.out", i - 1), id + ".a").link("y.out", id + ".b");
  }
  EXPECT_FALSE(proven(two_at_a_merge(net, "c19999.out", "n.out"))) << "true, but too deep to be seen";
  EXPECT_TRUE(proven(two_at_a_merge(net, "c900.out", "n.out")));
}

// Devices.

Result<std::unique_ptr<CompiledNet>> load(const NetDescription& net) {
  TestDevices devices;
  devices.add("left", "drive");
  return CompiledNet::compile(net, devices);
}

NetDescription two_drivers(const std::string& one, const std::string& other) {
  NetDescription net = conditions();
  net.add("end", "TestEnd");
  for (const auto& [id, active] : {std::pair{"a", one}, std::pair{"b", other}}) {
    FragmentDescription fragment;
    fragment.id = id;
    fragment.net.add("drive", "TestDrive", {{"device", "left"}, {"speed", 1}, {"in", 0}});
    net.fragments.push_back(fragment);
    if (!active.empty()) net.link(active, std::string(id) + ".active");
  }
  return net;
}

TEST(Exclusion, RowO4FragmentsThatExcludeEachOtherShareADevice) {
  const auto net = load(two_drivers("x.out", "n.out"));
  ASSERT_TRUE(net.has_value()) << net.error().to_string();
  EXPECT_EQ((*net)->report().resources, std::vector<std::string>{"left"});
  EXPECT_EQ((*net)->claims().size(), 1u);
  ASSERT_EQ((*net)->report().exclusions.size(), 1u);
  EXPECT_EQ((*net)->report().exclusions.front().at, "left");
}

TEST(Exclusion, RowO4SharingADeviceNeedsTheProof) {
  const auto net = load(two_drivers("x.out", "y.out"));
  ASSERT_FALSE(net.has_value());
  EXPECT_THAT(net.error(), Reports(Code::kResourceConflict, "/fragments/1/net/primitives/0/parameters/device",
                                   {"left", "a/drive", "b/drive", "x.out"}));
  EXPECT_FALSE(load(two_drivers("x.out", "")).has_value()) << "b never rests";
}

/// Fragments that drive one device, each active by one of these ports.
void add_drivers(NetDescription& net, const std::vector<std::string>& actives) {
  for (std::size_t i = 0; i < actives.size(); ++i) {
    FragmentDescription fragment;
    fragment.id = fmt::format("f{}", i);
    fragment.net.add("drive", "TestDrive", {{"device", "left"}, {"speed", 1}, {"in", 0}});
    net.fragments.push_back(fragment);
    net.link(actives[i], fragment.id + ".active");
  }
}

/// So many conditions of which the first one that is true has its turn: active = wanted and none before is.
NetDescription take_turns(int count) {
  NetDescription net;
  net.add("end", "TestEnd").add("w0", "TestTernary");
  std::vector<std::string> actives{"w0.out"};
  std::string taken = "w0.out";
  for (int i = 1; i < count; ++i) {
    const std::string n = std::to_string(i), own = "a" + n + ".out";
    net.add("w" + n, "TestTernary").add("free" + n, "TestNot").add("a" + n, "TestAnd").add("taken" + n, "TestOr");
    net.link(taken, "free" + n + ".in")
        .link("w" + n + ".out", "a" + n + ".a")
        .link("free" + n + ".out", "a" + n + ".b");
    net.link(taken, "taken" + n + ".a").link(own, "taken" + n + ".b");
    actives.push_back(own);
    taken = "taken" + n + ".out";
  }
  add_drivers(net, actives);
  return net;
}

/// A port of the outermost level by the name that the compiled net has for it.
std::string full_name(const NetDescription& net, const std::string& port) {
  const std::string id = port.substr(0, port.find('.'));
  const auto fragment = std::ranges::find(net.fragments, id, &FragmentDescription::id);
  return fragment == net.fragments.end() ? port : id + "/" + fragment->outputs.front().second;
}

TEST(Exclusion, RowO4ManyFragmentsTakeTurnsOnOneDevice) {
  for (const int count : {2, 17, 64, 65, 1000, 1100}) {
    const auto net = load(take_turns(count));
    ASSERT_TRUE(net.has_value()) << count << " " << net.error().to_string().substr(0, 500);
    EXPECT_TRUE((*net)->report().exclusions.front().proven);
  }
}

/// The proof of a chain does not overlook the one fragment that does not wait for its turn.
TEST(Exclusion, RowO4OneOfManyThatDoesNotWaitIsFound) {
  for (const int count : {3, 40, 1100}) {
    for (const int bad : {1, count / 2, count - 1}) {
      NetDescription net = take_turns(count);
      const std::string free = fmt::format("free{}.in", bad);
      const auto link = std::ranges::find(net.links, free, &LinkDescription::to);
      link->from = fmt::format("w{}.out", bad);
      const auto wanted = std::ranges::find(net.links, fmt::format("a{}.a", bad), &LinkDescription::to);
      wanted->from = "w0.out";
      const auto compiled = load(net);
      ASSERT_FALSE(compiled.has_value()) << bad << " of " << count;
      EXPECT_THAT(compiled.error(),
                  takt::test::ReportsAnywhere(Code::kResourceConflict, {"left", fmt::format("f{}/drive", bad)}));
    }
  }
}

/// Several fragments by formulas of some depth, some of them inside of fragments that rest: what LOAD accepts never
/// runs together, and what it refuses does.
TEST(Exclusion, RowO4TheProofOfDriversIsRightAndCompleteForRandomFormulas) {
  constexpr int kConditions = 3, kDrivers = 4;
  int accepted = 0, refused = 0;
  for (int seed = 0; seed < 1500; ++seed) {
    Random random(static_cast<std::uint64_t>(seed), "drivers");
    NetDescription net;
    net.add("end", "TestEnd");
    std::vector<std::string> ports;
    for (int i = 0; i < kConditions; ++i) {
      net.add(fmt::format("x{}", i), "TestTernary", {{"weight", static_cast<int>(std::pow(3, i))}});
      ports.push_back(fmt::format("x{}.out", i));
    }
    const auto any = [&] { return ports[random.bits() % ports.size()]; };
    for (int i = 0; i < 12; ++i) {
      static const std::array<std::string, 5> kTypes = {"TestNot", "TestAnd", "TestOr", "TestNot", "TestElse"};
      const std::string &type = kTypes[random.bits() % kTypes.size()], id = fmt::format("g{}", i);
      FragmentDescription inside;
      inside.id = fmt::format("i{}", i);
      const bool gated = random.bits() % 4 == 0;
      (gated ? inside.net : net).add(id, type);
      const std::string prefix = gated ? inside.id + "." : id + ".";
      const bool single = type == "TestNot";
      for (const char* port : {"in", "a", "b"}) {
        if (single != (std::string(port) == "in")) continue;
        if (gated) inside.inputs.emplace_back(port, id + "." + port);
        net.link(any(), prefix + port);
      }
      if (gated) {
        inside.outputs.emplace_back("out", id + ".out");
        net.link(any(), inside.id + ".active");
        net.fragments.push_back(inside);
      }
      ports.push_back(prefix + "out");
    }
    std::vector<std::string> actives{any()};
    std::string taken = actives.front();  // half of them wait for those before
    for (int i = 1; i < kDrivers; ++i) {
      const std::string n = std::to_string(i);
      net.add("free" + n, "TestNot").add("a" + n, "TestAnd").add("taken" + n, "TestOr");
      net.link(random.bits() % 8 == 0 ? any() : taken, "free" + n + ".in");
      net.link(any(), "a" + n + ".a").link("free" + n + ".out", "a" + n + ".b");
      net.link(taken, "taken" + n + ".a").link("a" + n + ".out", "taken" + n + ".b");
      actives.push_back("a" + n + ".out");
      taken = "taken" + n + ".out";
    }
    NetDescription with_drivers = net, bare = net;
    add_drivers(with_drivers, actives);
    const bool claim = load(with_drivers).has_value();
    const auto compiled = make_net(bare);
    bool conflict = false;
    for (int i = 0; i < std::pow(3, kConditions); ++i) {
      Cycle cycle;
      cycle.index = i;
      compiled->evaluate(cycle);
      const auto runs = [&](const std::string& port) {
        const auto* slot = compiled->find<Boolean>(full_name(bare, port));
        return slot->null == 0 && slot->value;
      };
      conflict = conflict || std::ranges::count_if(actives, runs) > 1;
    }
    ASSERT_EQ(claim, !conflict) << "seed " << seed << "\n" << net_to_json(with_drivers).dump(1);
    ++(claim ? accepted : refused);
  }
  EXPECT_GT(accepted, 200);
  EXPECT_GT(refused, 200);
}

// Meanings.

TEST(Formula, MalformedTextsAreRefused) {
  const PrimitiveInfo& info = *Registry::global().find("TestAnd");
  for (const char* good : {"a", "!a", "a & b | !(a ^ b)", "a ?? b", "null(a)", "?", "true", "!!a"}) {
    EXPECT_TRUE(parse_formula(good, info)) << good;
  }
  for (const char* bad : {"", "a &", "& a", "a b", "(a", "a)", "c", "a = b", "1 <", "null()", "null(c)", "a & & b"}) {
    EXPECT_FALSE(parse_formula(bad, info)) << bad;
  }
  const PrimitiveInfo& numbers = *Registry::global().find("TestLess");
  EXPECT_TRUE(parse_formula("a < 1.5 | -2 <= b & a = b", numbers));
  EXPECT_FALSE(parse_formula("a", numbers)) << "a is not a Boolean";
}

}  // namespace
}  // namespace takt::net
