// The thread of an I/O agent on hardware: packets in, answers out, on the machine's clock, whatever the driver does.
#include "core/device/agent_thread.h"

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/queue_link.h"
#include "tests/support/reports.h"

namespace takt::device {
namespace {

using takt::test::Names;
using Phase = AgentReport::Phase;

JointVector one_joint(double q) { return JointVector::Constant(1, q); }

motion::JointLimits limits_of_one() {
  return {.lower = one_joint(-3),
          .upper = one_joint(3),
          .velocity = one_joint(2),
          .acceleration = one_joint(10),
          .jerk = one_joint(200)};
}

/// Packets of a device that stands and is ready.
class StandingDevice {
 public:
  explicit StandingDevice(Nanoseconds cycle) : cycle_(cycle) {
    packet_.sample.q = packet_.sample.commanded = packet_.sample.dq = one_joint(0.0);
    packet_.sample.ready = true;
  }
  const ArmPacket& next() {
    packet_.instant = packet_.sample.stamp = static_cast<Nanoseconds>(packet_.sample.sequence++) * cycle_;
    return packet_;
  }

 private:
  Nanoseconds cycle_;
  ArmPacket packet_;
};

/// What is tested is the hand-over, not the machine: how late it wakes the threads is not asked for.
TEST(AgentThread, T2_AnswersOnAThreadOfItsOwn) {
  MonotonicClock clock;
  // A machine that sleeps for less than half a second loses no session.
  constexpr Nanoseconds kCycle = 20 * kMillisecond;
  ArmAgent agent(limits_of_one(), {.device_cycle = kCycle, .margin = 200 * kMillisecond}, clock);
  test::QueueLink link;
  StandingDevice device(kCycle);
  constexpr int kCycles = 20;
  {
    const AgentThread thread(agent, link, /*priority=*/0);
    ArmSample sample;
    for (int k = 0; k < kCycles; ++k) {
      link.put(device.next());
      const Nanoseconds due = clock.now() + kCycle;
      while (clock.now() < due) {
        if (agent.read(sample)) {
          EXPECT_LE(sample.stamp, clock.now());
          agent.write({.cycle = k, .stamp = clock.now(), .q = one_joint(0), .dq = one_joint(0), .ddq = one_joint(0)});
        }
        std::this_thread::sleep_for(std::chrono::microseconds(500));
      }
    }
    while (link.answers().size() < kCycles) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    for (int i = 0; i < 1000 && sample.sequence < kCycles; ++i) (void)agent.read(sample);
    EXPECT_EQ(sample.sequence, static_cast<std::uint64_t>(kCycles));
  }
  EXPECT_EQ(link.answers().size(), static_cast<std::size_t>(kCycles));
  for (const ArmAnswer& answer : link.answers()) EXPECT_EQ(answer.state.q[0], 0.0);
}

/// A driver that throws where and as often as the test says.
class ThrowingLink final : public ArmLink {
 public:
  bool receive(ArmPacket& packet, Nanoseconds timeout) override {
    if (throws_in_receive > 0 && throws_in_receive-- > 0) throw std::runtime_error("connection reset");
    return link.receive(packet, timeout);
  }
  void send(const ArmAnswer& answer) override {
    if (throws_in_send > 0 && throws_in_send-- > 0) throw 42;
    link.send(answer);
  }
  test::QueueLink link;
  std::atomic<int> throws_in_receive = 0, throws_in_send = 0;
};

class FailingDriver : public testing::Test {
 protected:
  /// One cycle of the device, and of the core, which reads.
  void cycle() {
    link.link.put(device.next());
    std::this_thread::sleep_for(std::chrono::nanoseconds(kCycle));
    (void)agent.read(sample);
    if (!sample.ready && sample.fault != 0) faults.push_back(sample.fault);
  }
  /// Cycles until the arm is ready. @return false after many.
  bool until_ready() {
    for (int i = 0; i < 500; ++i) {
      cycle();
      if (sample.ready) return true;
    }
    return false;
  }

  static constexpr Nanoseconds kCycle = 5 * kMillisecond;
  MonotonicClock clock;
  ArmAgent agent{limits_of_one(), {.device_cycle = kCycle, .margin = 200 * kMillisecond}, clock};
  ThrowingLink link;
  StandingDevice device{kCycle};
  ArmSample sample;
  std::vector<std::uint32_t> faults;
};

TEST_F(FailingDriver, EndsTheSessionAndNotTheProcess) {
  testing::internal::CaptureStderr();
  {
    const AgentThread thread(agent, link, /*priority=*/0, "left");
    ASSERT_TRUE(until_ready());
    link.throws_in_send = 1;
    for (int i = 0; i < 5; ++i) cycle();
    EXPECT_EQ(link.throws_in_send, 0);
    EXPECT_THAT(faults, testing::Contains(ArmAgent::kFailed));
    EXPECT_TRUE(until_ready()) << "no net holds the arm: it is taken up again";
  }
  EXPECT_THAT(testing::internal::GetCapturedStderr(), Names("send", "left"));
}

TEST_F(FailingDriver, ThatFailsAgainAndAgainIsToldNowAndThen) {
  testing::internal::CaptureStderr();
  {
    link.throws_in_receive = 5;
    const AgentThread thread(agent, link, /*priority=*/0, "left");
    while (link.throws_in_receive > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_TRUE(until_ready());
  }
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, Names("connection reset", "receive", "left", "0"));
  EXPECT_EQ(std::ranges::count(said, '\n'), 3) << said;  // the 1st, 2nd and 4th
}

TEST(ArmAgent, EachCauseOfItsOwnHasWords) {
  for (const std::uint32_t fault : {ArmAgent::kDry, ArmAgent::kElsewhere, ArmAgent::kStep, ArmAgent::kSilent,
                                    ArmAgent::kRestarted, ArmAgent::kDisagrees, ArmAgent::kFailed})
    EXPECT_FALSE(ArmAgent::fault_text(fault).empty()) << std::hex << fault;
  EXPECT_TRUE(ArmAgent::fault_text(5).empty()) << "a device's number is the device's";
}

}  // namespace
}  // namespace takt::device
