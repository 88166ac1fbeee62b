// A device that begins anew while a net holds it (row S4): the net ends, and only then is the device accepted again.
#include <gtest/gtest.h>

#include "core/device/arm_agent.h"
#include "core/motion/path_clock.h"
#include "tests/core/rcc/fixture.h"

namespace takt::test {
namespace {

using rcc::NetState;

/// An arm of 1 ms behind an I/O agent, in lock-step: it goes where it is answered.
class AgentArm final : public device::ArmBackend {
 public:
  explicit AgentArm(const motion::JointLimits& limits) : agent(limits, {.margin = kMillisecond}, clock_) {
    packet_.sample.q = packet_.sample.dq = packet_.sample.commanded = JointVector::Zero(limits.velocity.size());
    packet_.sample.ready = true;
  }
  void set_held(bool held) override { agent.set_held(held); }
  bool read(device::ArmSample& sample) override {
    clock_.set(++cycle_ * kMillisecond);
    ++packet_.sample.sequence;
    device_time_ += kMillisecond;
    packet_.instant = packet_.sample.stamp = device_time_;
    if (const auto answer = agent.answer(packet_)) {
      packet_.sample.q = packet_.sample.commanded = answer->state.q;
      packet_.sample.dq = answer->state.dq;
      ++answers;
    }
    return agent.read(sample);
  }
  void write(const device::ArmSetPoint& set_point) override { agent.write(set_point); }
  void set_payload(const device::PayloadSetting&) override {}
  void brake() override { agent.brake(); }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override {
    return device::ArmAgent::fault_text(fault);
  }

  /// Counter and clock begin anew; the arm stands where it is.
  void restart() {
    packet_.sample.sequence = 0;
    device_time_ = 0;
    packet_.sample.dq.setZero();
  }
  [[nodiscard]] const JointVector& q() const { return packet_.sample.q; }

 private:
  VirtualClock clock_;

 public:
  device::ArmAgent agent;
  int answers = 0;

 private:
  device::ArmPacket packet_;
  std::int64_t cycle_ = -1;
  Nanoseconds device_time_ = 77 * kSecond;
};

class DeviceRestartTest : public CoreTest {
 protected:
  DeviceRestartTest() {
    machine = std::make_shared<AgentArm>(description->limits);
    core->add(std::make_unique<device::Arm>("third", description, machine, core->period()));
    steps(50);
  }
  /// The third arm and the left one on one clock.
  rcc::NetId start_pair(const JointVector& from, const JointVector& goal) {
    NetDescription net = ptp_net("pair", "left", {JointVector::Zero(3), joints(0.6, -0.4, 0.2)});
    net.add("line_2", "JointLine", {{"path", motion::to_json(motion::Path(motion::JointLine{from, goal}))}});
    net.add("arm_2", "ArmCommand", {{"device", "third"}});
    for (const char* port : {"s", "ds", "dds"}) net.link(std::string("law.") + port, std::string("line_2.") + port);
    for (const char* port : {"q", "dq", "ddq"}) net.link(std::string("line_2.") + port, std::string("arm_2.") + port);
    const rcc::NetId id = load(net);
    core->start(id);
    return id;
  }
  std::shared_ptr<AgentArm> machine;
};

TEST_F(DeviceRestartTest, S4_ItIsAcceptedOnlyWhenNoNetHoldsIt) {
  const rcc::NetId pair = start_pair(JointVector::Zero(3), joints(-0.6, 0.4, -0.2));
  steps(300);
  ASSERT_EQ(core->state(pair), NetState::kRunning);
  ASSERT_GT(machine->q().cwiseAbs().maxCoeff(), 0.01);
  const JointVector stands = machine->q();
  const int before = machine->answers;
  machine->restart();
  const device::Arm& arm = *core->find_arm("third");
  int held = 0, canceling = 0;
  for (; arm.held() && held < 100; ++held) {
    steps(1);
    ASSERT_EQ(machine->answers, before) << "while a net holds it nothing is answered";
  }
  EXPECT_GE(held, device::DeviceSession::kRun);
  EXPECT_EQ(core->state(pair), NetState::kCanceling) << "the other arm comes to rest on its path";
  while (core->state(pair) != NetState::kTerminated && ++canceling < 2000) {
    steps(1);
    ASSERT_EQ(machine->q(), stands) << "the rest of the net moves it no more";
  }
  EXPECT_GT(canceling, 50);
  EXPECT_EQ(core->status(pair).cause.code, net::Cause::Code::kDevice);
  steps(30);
  EXPECT_GT(machine->answers, before);
  EXPECT_EQ(machine->q(), stands) << "nothing moves it";
  EXPECT_EQ(core->find_arm("third")->phase(), device::Arm::Phase::kFrozen);
  EXPECT_EQ(core->find_arm("third")->set_point().q, stands);

  const rcc::NetId again = load(ptp_net("again", "third", {stands, JointVector::Zero(3)}));
  core->start(again);
  EXPECT_TRUE(run_to_end(again));
  EXPECT_EQ(core->status(again).cause.code, net::Cause::Code::kTerminated);
  steps(20);
  EXPECT_LE(machine->q().cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace takt::test
