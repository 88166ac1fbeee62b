// Composed devices: a whole and its parts exclude each other, within a net at LOAD, between nets at START (rows O4,
// L2).
#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/device/composed_device.h"
#include "core/device/signal.h"
#include "core/rcc/control_core.h"
#include "tests/support/fake_signals.h"
#include "tests/support/guarded_step.h"
#include "tests/support/reports.h"

namespace takt::test {
namespace {

using takt::test::Reports;

using device::DigitalOutput;
using net::NetDescription;
using rcc::NetState;

/// Three lamps; "pair" is two of them.
class Composed : public testing::Test {
 protected:
  Composed() {
    std::vector<net::Resource*> pair;
    for (const char* name : {"a", "b", "c"}) {
      auto lamp = std::make_unique<DigitalOutput>(name, device::SignalOutputDescription<bool>{.stop = false},
                                                  std::make_shared<FakeOutput<bool>>(), core.period());
      DigitalOutput& added = core.add(std::move(lamp));
      if (added.name() != "c") pair.push_back(&added);
    }
    auto whole = device::ComposedDevice::make("pair", pair);
    core.add("pair", std::move(*whole));
    guarded_step(core);
  }
  /// Lights lamps and reserves wholes for ever.
  static NetDescription net(const std::vector<std::string>& lamps, const std::vector<std::string>& wholes) {
    NetDescription net;
    for (const auto& lamp : lamps) net.add("light " + lamp, "DigitalOutput", {{"device", lamp}, {"value", true}});
    for (const auto& whole : wholes) net.add("hold " + whole, "Reservation", {{"device", whole}});
    for (auto& primitive : net.primitives) std::ranges::replace(primitive.id, ' ', '-');
    net.add("cancel", "Cancel");
    net.add("end", "Termination");
    net.link("cancel.requested", "end.condition");
    return net;
  }
  rcc::NetId started(const NetDescription& description) {
    const auto id = core.load(description);
    if (!id) {
      ADD_FAILURE() << id.error().to_string();
      return 0;
    }
    core.start(*id);
    guarded_step(core);
    return *id;
  }

  rcc::ControlCore core{{}};
};

TEST_F(Composed, O4_WholeAndPartInOneNetAreFoundAtLoad) {
  const auto refused = core.load(net({"a"}, {"pair"}));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error(),
              Reports(Code::kResourceConflict, "/primitives/0/parameters/device", {"light-a", "hold-pair"}));
  EXPECT_TRUE(core.load(net({"c"}, {"pair"}))) << "no part of it";
  EXPECT_TRUE(core.load(net({"a", "b"}, {}))) << "part by part";
}

TEST_F(Composed, L2_WholeKeepsOthersFromItsParts) {
  const auto whole = started(net({}, {"pair"}));
  EXPECT_EQ(core.state(whole), NetState::kRunning);
  const auto part = started(net({"b"}, {}));
  EXPECT_EQ(core.state(part), NetState::kReady) << "refused";
  const auto other = started(net({"c"}, {}));
  EXPECT_EQ(core.state(other), NetState::kRunning);
  core.cancel(whole);
  guarded_step(core);
  guarded_step(core);
  EXPECT_EQ(core.state(whole), NetState::kTerminated);
  core.start(part);
  guarded_step(core);
  EXPECT_EQ(core.state(part), NetState::kRunning);
}

TEST_F(Composed, L2_PartKeepsOthersFromTheWhole) {
  const auto part = started(net({"a"}, {}));
  EXPECT_EQ(core.state(part), NetState::kRunning);
  EXPECT_EQ(core.state(started(net({}, {"pair"}))), NetState::kReady) << "refused";
}

TEST_F(Composed, ReservationTellsWhetherAllPartsCanBeDriven) {
  NetDescription description = net({}, {"pair"});
  const auto whole = started(description);
  guarded_step(core);
  const auto* ready = core.net(whole)->find<net::Boolean>("hold-pair.ready");
  ASSERT_NE(ready, nullptr);
  EXPECT_TRUE(ready->value);
}

}  // namespace
}  // namespace takt::test
