// The newest value from one thread to another, never torn, nobody waits.
#include <array>
#include <atomic>
#include <cstdint>
#include <thread>

#include <gtest/gtest.h>

#include "core/base/newest_slot.h"

namespace takt {
namespace {

using Value = std::array<std::uint64_t, 64>;

Value filled(std::uint64_t n) {
  Value value;
  value.fill(n);
  return value;
}

TEST(NewestSlot, GivesTheNewestOnce) {
  NewestSlot<int> slot;
  EXPECT_FALSE(slot.take());
  EXPECT_EQ(slot.value(), 0);
  slot.publish(1);
  slot.publish(2);
  EXPECT_TRUE(slot.take());
  EXPECT_EQ(slot.value(), 2);
  EXPECT_FALSE(slot.take());
  EXPECT_EQ(slot.value(), 2) << "what was taken stays";
  slot.publish(3);
  slot.publish(4);
  slot.publish(5);
  EXPECT_EQ(slot.value(), 2);
  EXPECT_TRUE(slot.take());
  EXPECT_EQ(slot.value(), 5);
}

TEST(NewestSlot, BetweenThreadsNothingIsTornAndNothingGoesBack) {
  NewestSlot<Value> slot;
  constexpr std::uint64_t kLast = 200'000;
  std::thread writer([&slot] {
    for (std::uint64_t n = 1; n <= kLast; ++n) slot.publish(filled(n));
  });
  std::uint64_t newest = 0;
  while (newest < kLast) {
    if (!slot.take()) continue;
    const Value& value = slot.value();
    ASSERT_GT(value[0], newest);
    newest = value[0];
    for (const std::uint64_t word : value) ASSERT_EQ(word, newest);
  }
  writer.join();
}

}  // namespace
}  // namespace takt
