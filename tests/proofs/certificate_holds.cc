// The reaction certificate against measured reactions (rows O6, O7): an event reaches a sink after no fewer cycles than
// the certified minimum and no more than the certified maximum, and both are reached.
#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/net/load_report.h"
#include "core/net/net_plan.h"
#include "core/net/registry.h"
#include "core/net/schedule.h"
#include "core/net/setup.h"
#include "tests/core/net/net_support.h"
#include "tests/proofs/random_ways.h"
#include "tests/support/random_runs.h"

namespace takt::net {
namespace {

/// 0, and 1 from one cycle on: an event from outside.
class ProofEvent final : public Primitive {
 public:
  explicit ProofEvent(Setup& setup)
      : out_(setup.out<Real>("out", {.unit = "1"})), at_(setup.parameter<Integer>("at", -1)) {
    setup.is_source();
  }
  void update(const Cycle& cycle) override { out_.set(at_ >= 0 && cycle.index_in_net >= at_ ? 1.0 : 0.0); }

 private:
  Out<Real> out_;
  Integer at_;
};
TAKT_PRIMITIVE(ProofEvent, "test", "An event that stays.");

/// Hands on the input that a parameter names. LOAD cannot know which: both are ways for an event.
class ProofRoute final : public Primitive {
 public:
  explicit ProofRoute(Setup& setup)
      : a_(setup.in<Real>("a", {.unit = "1", .on_null = OnNull::kHandled})),
        b_(setup.in<Real>("b", {.unit = "1", .on_null = OnNull::kHandled})),
        out_(setup.out<Real>("out", {.unit = "1"})),
        way_(setup.parameter<Integer>("way", 0)) {}
  void update(const Cycle&) override {
    const In<Real>& in = way_ == 0 ? a_ : b_;
    if (in.null()) return out_.set_null();
    out_.set(*in);
  }

 private:
  In<Real> a_, b_;
  Out<Real> out_;
  Integer way_;
};
TAKT_PRIMITIVE(ProofRoute, "test", "One of two.");

/// The value of kCycles cycles ago, null included; as long as there was none: 0 in a net that has just begun, -1 (which
/// no event gives) in a fragment that comes to life later.
template <std::int64_t kCycles>
class ProofLag : public Primitive {
 public:
  explicit ProofLag(Setup& setup)
      : in_(setup.in<Real>("a", {.unit = "1", .on_null = OnNull::kHandled})),
        out_(setup.out<Real>("out", {.unit = "1"})) {
    setup.latency("a", "out", {.cycles = kCycles});
  }
  void update(const Cycle& cycle) override {
    if (cycle.first) past_.fill(cycle.index == 0 ? 0.0 : -1.0);
    std::optional<double>& oldest = past_[static_cast<std::size_t>(cycle.index_in_net % kCycles)];
    if (oldest) {
      out_.set(*oldest);
    } else {
      out_.set_null();
    }
    oldest = in_.null() ? std::nullopt : std::optional(*in_);
  }

 private:
  In<Real> in_;
  Out<Real> out_;
  std::array<std::optional<double>, kCycles> past_;
};
using ProofLag1 = ProofLag<1>;
using ProofLag2 = ProofLag<2>;
using ProofLag7 = ProofLag<7>;
TAKT_PRIMITIVE(ProofLag1, "test", "1 cycle late.");
TAKT_PRIMITIVE(ProofLag2, "test", "2 cycles late.");
TAKT_PRIMITIVE(ProofLag7, "test", "7 cycles late.");

class ProofPrevious final : public Primitive {
 public:
  explicit ProofPrevious(Setup& setup)
      : in_(setup.in<Real>("a", {.unit = "1"})), out_(setup.out<Real>("out", {.unit = "1"})) {
    setup.breaks_loop("a");
  }
  void update(const Cycle&) override {
    if (in_.null()) return out_.set_null();
    out_.set(*in_);
  }

 private:
  In<Real> in_;
  Out<Real> out_;
};
TAKT_PRIMITIVE(ProofPrevious, "test", "One cycle ago; its input breaks loops.");

/// Switches a fragment: on by the event, off by it, or on for ever whatever comes. It sees the event as a value above
/// 0.5 or as the presence of any value (what a fragment brings to life need not be above).
class ProofSwitch final : public Primitive {
 public:
  explicit ProofSwitch(Setup& setup)
      : in_(setup.in<Real>("a", {.unit = "1", .on_null = OnNull::kHandled})),
        out_(setup.out<Boolean>("out")),
        mode_(setup.parameter<std::string>("mode", "always", {.range = "on|off|always"})),
        sees_(setup.parameter<std::string>("sees", "above", {.range = "above|there"})) {}
  void update(const Cycle&) override {
    const bool happened = !in_.null() && (sees_ == "there" || *in_ > 0.5);
    out_.set(mode_ == "always" || happened == (mode_ == "on"));
  }

 private:
  In<Real> in_;
  Out<Boolean> out_;
  std::string mode_, sees_;
};
TAKT_PRIMITIVE(ProofSwitch, "test", "A threshold that switches a fragment.");

/// A sink of the certificate that shows what it read. (After a cycle, the memory behind a delayed link holds what is
/// read in the next one.)
class ProofSink final : public Primitive {
 public:
  explicit ProofSink(Setup& setup)
      : in_(setup.in<Real>("in", {.unit = "1", .on_null = OnNull::kHandled})),
        seen_(setup.out<Real>("seen", {.unit = "1"})) {
    setup.is_monitor();
  }
  void update(const Cycle&) override {
    if (in_.null()) return seen_.set_null();
    seen_.set(*in_);
  }

 private:
  In<Real> in_;
  Out<Real> seen_;
};
TAKT_PRIMITIVE(ProofSink, "test", "What arrived.");

/// Runs nets of one plan with parameters of their own.
class Measurement {
 public:
  explicit Measurement(test::RandomWays& ways)
      : ways_(ways), flat_(flatten(ways.net, report_)), plan_(plan_net(flat_, schedule(flat_, report_))) {}

  /// Cycles from the event at `source` to each change that it makes at the sink, compared with a run without it. None
  /// if the net without the event does not rest from then on: a fragment that comes and goes by itself holds events
  /// back, which is no question of the way (docs/testing.md).
  std::vector<std::int64_t> run(int source, const std::string& sink, std::int64_t at, std::int64_t horizon) {
    ways_.set_event(source, -1);
    const auto without = make();
    ways_.set_event(source, at);
    const auto with = make();
    ways_.set_event(source, -1);
    const auto *plain = without->find<Real>(sink + ".seen"), *reacting = with->find<Real>(sink + ".seen");
    std::vector<std::int64_t> changes;
    Slot<Real> before;
    bool differed = false;
    std::vector<std::byte> rest;
    for (std::int64_t i = 0; i < at + horizon; ++i) {
      if (i == at) rest.assign(without->slots().begin(), without->slots().end());
      without->evaluate({.index = i});
      with->evaluate({.index = i});
      if (i >= at && !std::ranges::equal(rest, without->slots())) return {};
      const bool differs = std::memcmp(plain, reacting, sizeof(before)) != 0;
      const bool changed = std::memcmp(reacting, &before, sizeof(before)) != 0;
      if (differs != differed || (differs && changed)) changes.push_back(i - at);
      differed = differs;
      copy_slot(*reacting, before);
    }
    return changes;
  }

 private:
  std::unique_ptr<CompiledNet> make() {
    TestDevices devices;
    auto net = CompiledNet::from_plan(flat_, plan_, devices, report_);
    EXPECT_FALSE(report_.has_errors()) << report_.take().to_string();
    return net;
  }

  test::RandomWays& ways_;
  LoadReport report_;
  FlatNet flat_;
  NetPlan plan_;
};

struct Tally {
  long edges = 0, shortest = 0, longest = 0, reactions = 0, unsearched = 0, between = 0;
};

/// One pair of source and sink.
class Edge {
 public:
  Edge(test::RandomWays& ways, const NetReport::Reaction& certified, std::string sink, Random& random)
      : ways_(ways), measurement_(ways), certified_(certified), sink_(std::move(sink)), random_(random) {}

  /// Lets the event run along a way and the rest of the net at random, some times over, since what else happens may
  /// hide it (a part that a fragment brings to life with a null). @return true if the sink once changed after `cycles`.
  bool reaches(const test::Way& way, std::int64_t cycles, Tally& tally) {
    for (int attempt = 0; attempt < 16; ++attempt) {
      ways_.choose_at_random(random_);
      ways_.choose(way);
      const std::vector<std::int64_t> changes = measure(tally);
      if (testing::Test::HasFatalFailure()) return false;
      if (std::ranges::find(changes, cycles) != changes.end()) return true;
    }
    return false;
  }
  /// Cycles from an event to the changes that it makes; the first of them is its reaction.
  std::vector<std::int64_t> measure(Tally& tally) {
    // Not in the first cycles: until then delayed links bring the net to rest.
    const std::int64_t at = 20 + static_cast<std::int64_t>(random_.bits() % 20);
    const int source = ways_.number_of(certified_.source);
    std::vector<std::int64_t> changes = measurement_.run(source, sink_, at, certified_.maximum_cycles + 12);
    if (changes.empty() || ways_.may_blink()) return changes;
    ++tally.reactions;
    const std::int64_t reaction = changes.front();
    tally.between += certified_.minimum_cycles < reaction && reaction < certified_.maximum_cycles ? 1 : 0;
    check(reaction);
    return changes;
  }

 private:
  void check(std::int64_t reaction) const {
    ASSERT_GE(reaction, certified_.minimum_cycles) << ways_.text();
    ASSERT_LE(reaction, certified_.maximum_cycles) << ways_.text();
  }

  test::RandomWays& ways_;
  Measurement measurement_;
  const NetReport::Reaction& certified_;
  std::string sink_;
  Random& random_;
};

TEST(ReactionCertificate, RowsO6O7HoldsOverRandomEdges) {
  const test::RandomRuns runs(100'000);
  Tally tally;
  long nets = 0, loops = 0, switched = 0;
  for (; tally.edges < runs.count; ++nets) {
    Random random(runs.first_seed + static_cast<std::uint64_t>(nets), "edges");
    test::RandomWays ways(random);
    loops += ways.has_loop ? 1 : 0;
    switched += ways.switched_fragments;
    const auto net = make_net(ways.net);
    ASSERT_NE(net, nullptr);
    for (const NetReport::Reaction& certified : net->report().reactions) {
      const std::string sink = certified.sink.substr(0, certified.sink.rfind('.'));
      if (!sink.starts_with("m")) continue;
      SCOPED_TRACE(fmt::format("net {}: {} to {}", nets, certified.source, sink));
      ASSERT_FALSE(certified.data_dependent);
      const test::Ways found = ways.search(ways.number_of(certified.source), ways.number_of(sink));
      ASSERT_FALSE(found.shortest.empty()) << "certified, but there is no way";
      Edge edge(ways, certified, sink, random);
      ++tally.edges;
      tally.shortest += edge.reaches(found.shortest, certified.minimum_cycles, tally) ? 1 : 0;
      tally.longest += edge.reaches(found.longest, certified.maximum_cycles, tally) ? 1 : 0;
      tally.unsearched += found.complete ? 0 : 1;
      ways.choose_at_random(random);
      (void)edge.measure(tally);
      if (HasFatalFailure()) return;
    }
  }
  std::printf(
      "%ld edges in %ld nets (%ld with loops, %ld switched fragments): minimum reached %ld times, maximum %ld "
      "times; %ld reactions measured, none outside, %ld strictly between; %ld searches given up\n",
      tally.edges, nets, loops, switched, tally.shortest, tally.longest, tally.reactions, tally.between,
      tally.unsearched);
  EXPECT_GE(tally.longest, 0.99 * static_cast<double>(tally.edges));
  EXPECT_GE(tally.shortest, 0.99 * static_cast<double>(tally.edges));
  // The nets must be worth it.
  EXPECT_GT(loops, nets / 4);
  EXPECT_GT(switched, nets / 4);
  EXPECT_GT(tally.between, tally.edges / 50);
}

}  // namespace
}  // namespace takt::net
