// Values into, out of and between running nets (row O5), and how they leave the core.
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/rcc/fixture.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using takt::test::Reports;

using device::Channel;
using device::ChannelDescription;
using rcc::Event;
using rcc::NetState;
using Writer = ChannelDescription::Writer;

class ChannelsTest : public CoreTest {
 protected:
  /// A core with the channels; nothing has run yet.
  void declare(const std::vector<ChannelDescription>& channels, const rcc::ControlCore::Options& options = {}) {
    core = std::make_unique<rcc::ControlCore>(options);
    for (const ChannelDescription& channel : channels) {
      const auto declared = core->declare(channel);
      if (!declared) ADD_FAILURE() << declared.error().to_string();
    }
  }

  /// Counts the cycles of the net and writes the number to a channel.
  static NetDescription counter(const std::string& channel) {
    NetDescription net;
    net.name = "counter";
    net.add("one", "ConstantReal", {{"value", 1.0}}).add("sum", "Add").add("out", "OutputReal", {{"channel", channel}});
    net.link("one.value", "sum.a").link_delayed("sum.value", "sum.b", 0.0).link("sum.value", "out.value");
    return endless(net);
  }
  /// Shows a channel under "value" and "age"; ends never.
  static NetDescription reader(const std::string& channel) {
    NetDescription net;
    net.name = "reader";
    net.add("in", "InputReal", {{"channel", channel}});
    net.add("value", "MonitorReal").add("age", "MonitorReal");
    net.link("in.value", "value.value").link("in.age", "age.value");
    return endless(net);
  }
  static NetDescription endless(NetDescription net) {
    net.add("end", "Termination", {{"condition", false}});
    return net;
  }

  rcc::NetId started(const NetDescription& net) {
    const rcc::NetId id = load(net);
    core->start(id);
    return id;
  }
  std::optional<double> shown(rcc::NetId net, const char* port = "in.value") {
    const auto* slot = core->net(net)->find<net::Real>(port);
    if (slot == nullptr || slot->null != 0) return std::nullopt;
    return slot->value;
  }
  Diagnostics rejected(const NetDescription& net) {
    const auto id = core->load(net);
    return id ? Diagnostics() : id.error();
  }
};

TEST_F(ChannelsTest, O5_WhatANetWritesIsReadOneCycleLaterWhateverTheOrder) {
  for (const bool writer_first : {true, false}) {
    declare({{.name = "count", .writer = Writer::kNet}});
    rcc::NetId reader_id = 0, writer_id = 0;
    if (writer_first) writer_id = load(counter("count"));
    reader_id = load(reader("count"));
    if (!writer_first) writer_id = load(counter("count"));
    (void)core->post(rcc::Transaction{.abort = {}, .cancel = {}, .start = {reader_id, writer_id}});
    steps(2);  // started, then the first cycle
    EXPECT_EQ(shown(reader_id), std::nullopt);
    for (int k = 1; k < 5; ++k) {
      guarded_step(*core);
      EXPECT_EQ(shown(reader_id), k);
      EXPECT_EQ(shown(reader_id, "in.age"), 1e-3);
      EXPECT_EQ(shown(writer_id, "sum.value"), k + 1);
    }
    core->abort(writer_id);
    guarded_step(*core);  // what it wrote in this cycle is lost (row L2)
    EXPECT_EQ(core->state(writer_id), NetState::kTerminated);
    steps(2);
    EXPECT_EQ(shown(reader_id), 5.0) << "the last value stays";
    EXPECT_EQ(shown(reader_id, "in.age"), 3e-3) << "and ages";
  }
}

TEST_F(ChannelsTest, L2_ANetThatFailsLosesWhatItWroteInThatCycle) {
  declare({{.name = "count", .writer = Writer::kNet}});
  NetDescription net = counter("count");
  net.add("many", "GreaterThan", {{"b", 2.5}}).add("failed", "Error", {{"text", "too many"}});
  net.link("sum.value", "many.a").link("many.value", "failed.condition");
  const rcc::NetId writer_id = started(net), reader_id = started(reader("count"));
  steps(8);
  EXPECT_EQ(core->state(writer_id), NetState::kTerminated);
  EXPECT_EQ(shown(reader_id), 2.0);
}

TEST_F(ChannelsTest, O5_ANetReadsItsOwnChannelOneCycleLateToo) {
  declare({{.name = "count", .writer = Writer::kNet, .initial = 0.0}});
  NetDescription net;
  net.add("in", "InputReal", {{"channel", "count"}}).add("sum", "Add", {{"b", 1.0}});
  net.add("out", "OutputReal", {{"channel", "count"}});
  net.link("in.value", "sum.a").link("sum.value", "out.value");
  const rcc::NetId id = started(endless(net));
  steps(5);
  EXPECT_EQ(shown(id, "sum.value"), 4.0);
}

TEST_F(ChannelsTest, SecondWriterIsRefusedAndTheFirstGoesOn) {
  declare({{.name = "count", .writer = Writer::kNet}});
  const rcc::NetId first = started(counter("count"));
  steps(3);
  const rcc::NetId second = load(counter("count"));
  const auto request = core->start(second);
  guarded_step(*core);
  const Event* refused = event(Event::Kind::kRefused);
  ASSERT_NE(refused, nullptr);
  EXPECT_EQ(refused->request, request);
  EXPECT_EQ(refused->cause.text.view(), "count is held by net 1");
  EXPECT_EQ(shown(first, "sum.value"), 3.0);
  core->abort(first);
  guarded_step(*core);
  core->start(second);
  steps(2);
  EXPECT_EQ(core->state(second), NetState::kRunning);
}

TEST_F(ChannelsTest, U1_U2_UnitAndFrameAreDeclaredOnceAndHoldForAllNets) {
  declare({{.name = "speed", .unit = "m/s"},
           {.name = "count", .writer = Writer::kNet, .unit = "N"},
           {.name = "tool", .type = net::ValueType::kFrame, .frame = "base>tool"}});
  NetDescription net = reader("speed");
  net.add("sum", "Add").add("other", "InputReal", {{"channel", "count"}});
  net.link("in.value", "sum.a").link("other.value", "sum.b");
  EXPECT_THAT(rejected(net), Reports(Code::kUnitMismatch, "/links/3", {"other.value", "count", "sum.b"}));
  NetDescription writer = endless({});
  writer.add("in", "InputReal", {{"channel", "speed"}}).add("out", "OutputReal", {{"channel", "count"}});
  writer.link("in.value", "out.value");
  EXPECT_THAT(rejected(writer), Reports(Code::kUnitMismatch, "/links/0", {"in.value", "speed", "out.value", "count"}));
  NetDescription frames = endless({});
  frames.add("in", "InputFrame", {{"channel", "tool"}}).add("twice", "Compose");
  frames.link("in.value", "twice.left").link("in.value", "twice.right");
  EXPECT_THAT(rejected(frames), Reports(Code::kFrameMismatch, "/links/1", {"in.value", "tool"}));
}

TEST_F(ChannelsTest, UnknownChannelsOfOtherTypesAndForeignWritersAreRejected) {
  declare({{.name = "speed"}, {.name = "valve", .type = net::ValueType::kBoolean}});
  EXPECT_THAT(rejected(reader("sped")),
              Reports(Code::kUnknownName, "/primitives/0/parameters/channel", {"sped", "speed"}));
  EXPECT_THAT(rejected(reader("valve")), Reports(Code::kUnknownName, "/primitives/0/parameters/channel", {"valve"}));
  EXPECT_THAT(rejected(counter("speed")), Reports(Code::kInvalidValue, "/primitives/2/parameters/channel", {"speed"}));
  const auto again = core->declare({.name = "speed", .unit = "parsec"});
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error(), Reports(Code::kDuplicate, "/name", {"speed"}));
  EXPECT_THAT(again.error(), Reports(Code::kInvalidValue, "/unit", {"parsec"}));
}

TEST_F(ChannelsTest, D2_ValuesFromOutsideAreRecordedWithTheirCycleAndReplayBitForBit) {
  const std::vector<ChannelDescription> channels = {{.name = "speed", .unit = "m/s", .timeout = 5 * kMillisecond},
                                                    {.name = "valve", .type = net::ValueType::kBoolean}};
  declare(channels, {.latch_capacity = 64});
  started(reader("speed"));
  Channel* speed = core->find_channel("speed");
  Channel* valve = core->find_channel("valve");
  for (int k = 0; k < 40; ++k) {
    if (k % 7 == 3) (void)speed->write(0.1 * k);
    if (k % 11 == 5) (void)valve->write(k % 2 == 0);
    if (k == 20) (void)speed->write_null();
    guarded_step(*core);
  }
  const auto digest = core->digest().value();
  const auto latches = core->take_latches();
  EXPECT_EQ(core->latches_dropped(), 0);
  ASSERT_EQ(latches.size(), 11u);
  EXPECT_EQ(latches[0].cycle, 3);
  EXPECT_EQ(latches[0].channel, "speed");
  EXPECT_EQ(std::get<net::Real>(*latches[0].value), 0.1 * 3);

  declare(channels);
  started(reader("speed"));
  rcc::LatchReplay replay(latches);
  for (int k = 0; k < 40; ++k) {
    const Diagnostics diagnostics = replay.before_step(*core);
    EXPECT_TRUE(diagnostics.empty()) << diagnostics.to_string();
    guarded_step(*core);
  }
  EXPECT_EQ(core->digest().value(), digest);

  declare(channels);
  started(reader("speed"));
  steps(40);
  EXPECT_NE(core->digest().value(), digest) << "without the values the run is another one";
}

TEST_F(ChannelsTest, D2_AFullLogDropsAndCounts) {
  declare({{.name = "speed"}}, {.latch_capacity = 4});
  for (int k = 0; k < 10; ++k) {
    (void)core->find_channel("speed")->write(double(k));
    guarded_step(*core);
  }
  EXPECT_EQ(core->take_latches().size(), 4u);
  EXPECT_EQ(core->latches_dropped(), 6);
}

TEST_F(ChannelsTest, ReplayOfWhatIsNotThereSaysSo) {
  declare({{.name = "speed", .writer = Writer::kNet}});
  rcc::LatchReplay replay(std::vector<rcc::Latch>{{.cycle = 0, .channel = "sped", .value = {}},
                                                  {.cycle = 0, .channel = "speed", .value = 1.0}});
  const Diagnostics text = replay.before_step(*core);
  EXPECT_THAT(text, Reports(Code::kUnknownName, "", {"sped"}));
  EXPECT_THAT(text, Reports(Code::kNotPossibleNow, "", {"speed", "0"}));
}

TEST_F(ChannelsTest, O5_MonitorsGiveEveryNthCycleAndTheRateChangesWhileRunning) {
  declare({{.name = "count", .writer = Writer::kNet}});
  const rcc::NetId id = load(counter("count"));
  const auto watch = core->watch(id, "sum.value", {.every = 1, .capacity = 64});
  ASSERT_TRUE(watch) << watch.error().to_string();
  const auto channel = core->watch("count", {.every = 4});
  ASSERT_TRUE(channel);
  EXPECT_FALSE((*watch)->newest());
  core->start(id);
  steps(6);  // cycle 0 starts it
  (*watch)->set_every(3);
  steps(7);  // cycles 6 to 12
  (*watch)->set_every(0);
  steps(5);
  std::vector<rcc::WatchedValue> values(64);
  values.resize((*watch)->take(values));
  std::vector<std::int64_t> cycles;
  for (const auto& value : values) {
    cycles.push_back(value.cycle);
    EXPECT_EQ(std::get<net::Real>(*value.value), static_cast<double>(value.cycle));
  }
  EXPECT_THAT(cycles, testing::ElementsAre(1, 2, 3, 4, 5, 6, 9, 12));
  EXPECT_EQ((*watch)->newest()->cycle, 12);
  EXPECT_EQ((*watch)->newest()->cycle, 12) << "as often as it is asked for";
  EXPECT_EQ((*channel)->newest()->cycle, 16);
  EXPECT_EQ(std::get<net::Real>(*(*channel)->newest()->value), 15.0) << "what the net wrote in the cycle before";
}

TEST_F(ChannelsTest, AFullRingDropsAndCountsAndAnEndedNetIsSaid) {
  declare({{.name = "count", .writer = Writer::kNet}});
  const rcc::NetId id = started(counter("count"));
  const auto watch = core->watch(id, "sum.value", {.capacity = 4});
  ASSERT_TRUE(watch);
  steps(11);  // attached in cycle 0, sampled in 1 to 10
  EXPECT_EQ((*watch)->dropped(), 6);
  EXPECT_FALSE((*watch)->ended());
  core->abort(id);
  guarded_step(*core);
  EXPECT_TRUE((*watch)->ended());
  EXPECT_TRUE(core->unload(id));
  steps(3);
  EXPECT_EQ((*watch)->newest()->cycle, 11) << "the last cycle of the net is seen";

  const auto of_channel = core->watch("count");
  steps(2);
  core->unwatch(*of_channel);
  guarded_step(*core);
  EXPECT_TRUE((*of_channel)->ended());
  EXPECT_THAT(core->watch("cuont").error(), Reports(Code::kUnknownName, "", {"count"}));
  EXPECT_THAT(core->watch(id, "sum.value").error(), Reports(Code::kUnknownName, ""));
}

TEST_F(ChannelsTest, AWatchThatIsGivenUpStaysUntilTheCycleHasLetGoOfIt) {
  declare({{.name = "count", .writer = Writer::kNet}});
  const rcc::NetId id = started(counter("count"));
  for (const bool sampled : {true, false}) {
    auto watch = core->watch(id, "sum.value", {.capacity = 4});
    ASSERT_TRUE(watch);
    if (sampled) steps(3);
    const std::weak_ptr<rcc::Watch> kept = *watch;
    core->unwatch(*watch);
    watch->reset();
    EXPECT_TRUE(core->watch("count")) << "in the same pause between two cycles";
    EXPECT_FALSE(kept.expired()) << "the cycle will still look at it, sampled " << sampled;
    steps(1);
    EXPECT_TRUE(core->watch("count"));
    EXPECT_TRUE(kept.expired()) << "sampled " << sampled;
  }
}

TEST_F(ChannelsTest, O5_WatchesDoNotChangeTheRun) {
  const auto run = [&](int every) {
    declare({{.name = "count", .writer = Writer::kNet}});
    const rcc::NetId id = started(counter("count"));
    if (every > 0) {
      EXPECT_TRUE(core->watch(id, "sum.value", {.every = every, .capacity = 4}));
    }
    steps(20);
    return core->digest().value();
  };
  EXPECT_EQ(run(0), run(1));
  EXPECT_EQ(run(0), run(7));
}

/// The cycle runs in a thread of its own; a reader polls the newest value: it is whole and never goes back.
TEST_F(ChannelsTest, O5_TheNewestValueIsNeverTorn) {
  declare({{.name = "pose", .type = net::ValueType::kVector}});
  Channel* pose = core->find_channel("pose");
  const auto watch = core->watch("pose", {.every = 1, .capacity = 16});
  ASSERT_TRUE(watch);
  std::jthread cycle([&](const std::stop_token& stop) {
    for (double i = 1; !stop.stop_requested(); ++i) {
      (void)pose->write(net::Vector(i, 2 * i, 3 * i));
      guarded_step(*core);
    }
  });
  double last = 0;
  std::vector<rcc::WatchedValue> values(16);
  for (int seen = 0; seen < 2'000;) {
    const auto newest = (*watch)->newest();
    for (std::size_t i = 0, n = (*watch)->take(values); i < n && values[i].value; ++i) {
      const auto& v = std::get<net::Vector>(*values[i].value);
      ASSERT_EQ(v.y() + v.z(), 5 * v.x());
    }
    if (!newest || !newest->value) continue;
    const auto& value = std::get<net::Vector>(*newest->value);
    ASSERT_EQ(value.y(), 2 * value.x());
    ASSERT_EQ(value.z(), 3 * value.x());
    ASSERT_GE(value.x(), last);
    if (value.x() > last) ++seen;
    last = value.x();
  }
}

TEST_F(ChannelsTest, NothingIsAllocatedInTheCycle) {
  declare({{.name = "speed", .unit = "m/s"}, {.name = "count", .writer = Writer::kNet}}, {.latch_capacity = 16});
  const rcc::NetId id = started(counter("count"));
  started(reader("speed"));
  const auto watch = core->watch(id, "sum.value", {.capacity = 4});
  ASSERT_TRUE(watch);
  Channel* speed = core->find_channel("speed");
  const AllocationGuard guard;
  for (int k = 0; k < 50; ++k) {
    (void)speed->write(double(k));
    guarded_step(*core);
  }
  core->abort(id);
  guarded_step(*core);
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace takt::test
