#include "core/device/composed_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/device/signal.h"
#include "tests/support/fake_signals.h"
#include "tests/support/reports.h"

namespace takt::device {
namespace {

using testing::ElementsAre;

TEST(ComposedDevice, KnowsItsLeavesThroughOtherWholes) {
  DigitalOutput a("a", {}, std::make_shared<test::FakeOutput<bool>>(), kMillisecond);
  DigitalOutput b("b", {}, std::make_shared<test::FakeOutput<bool>>(), kMillisecond);
  DigitalOutput c("c", {}, std::make_shared<test::FakeOutput<bool>>(), kMillisecond);
  const auto inner = ComposedDevice::make("inner", {&a, &b});
  ASSERT_TRUE(inner) << inner.error().to_string();
  const auto outer = ComposedDevice::make("outer", {inner->get(), &c});
  ASSERT_TRUE(outer) << outer.error().to_string();
  EXPECT_THAT((*outer)->parts(), ElementsAre(inner->get(), &c));
  EXPECT_THAT((*outer)->leaves(), ElementsAre(&a, &b, &c));
  EXPECT_EQ((*outer)->kind(), "composed_device");
}

TEST(ComposedDevice, APartStandsOnceAndThereIsOne) {
  DigitalOutput a("a", {}, std::make_shared<test::FakeOutput<bool>>(), kMillisecond);
  const auto inner = ComposedDevice::make("inner", {&a});
  const auto twice = ComposedDevice::make("outer", {&a, inner->get()});
  ASSERT_FALSE(twice);
  EXPECT_THAT(twice.error(), takt::test::Reports(Code::kDuplicate, "", {"outer"}));
  EXPECT_FALSE(ComposedDevice::make("empty", {}));
}

}  // namespace
}  // namespace takt::device
