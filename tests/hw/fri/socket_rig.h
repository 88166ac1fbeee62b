#pragma once

#include <memory>

#include "hw/emulators/fri/emulator.h"
#include "hw/fri/driver.h"
#include "hw/wire/posix_network.h"
#include "tests/support/arm_rig.h"

namespace takt::test {

/// What an arm over sockets is made of, in the order in which it has to be made.
struct SocketParts {
  SocketParts()
      : client_link(std::move(*hw::PosixNetwork().open_datagrams({hw::kLoopback, 0}))), remote(client_link->local()) {}
  VirtualClock clock;
  std::unique_ptr<hw::DatagramLink> client_link;
  hw::Endpoint remote;
};

/// The driver and the emulated controller over two UDP sockets of this machine. Time is virtual: each datagram is
/// waited for before time goes on, so that the machine's load changes nothing.
class SocketTwin final : private SocketParts, public hw::fri::Backend {
 public:
  SocketTwin(const device::DriverRequest& request, const hw::fri::ClientOptions& client,
             const hw::fri::ControllerOptions& controller, std::shared_ptr<device::ArmBackend> machine)
      : Backend(request, client, std::move(client_link), clock),
        link_(std::move(*hw::PosixNetwork().open_datagrams({hw::kLoopback, 0}))),
        link_view_(link_.get()),
        machine_(machine),
        emulator_(request, controller, std::move(link_), remote, std::move(machine)) {}

  bool read(device::ArmSample& sample) override {
    advance();
    return client_.read(sample);
  }
  void set_payload(const device::PayloadSetting& payload) override { machine_->set_payload(payload); }
  void pass_cycle() { advance(); }

 private:
  void advance() {
    const Nanoseconds now = ++cycle_number_ * core_period_;
    clock.set(now);
    emulator_.look();
    emulator_.receive(now);
    while (emulator_.next_cycle() <= now) exchange();
    emulator_.drive(now);
  }
  void exchange() {
    const auto sent = link_view_->counts().sent;
    emulator_.begin_cycle();
    if (link_view_->counts().sent == sent) return;
    const auto answers = client_.report().answers;
    if (client_.wait(kSecond)) client_.serve();
    if (client_.report().answers > answers) (void)link_view_->wait(kSecond);
  }

  std::unique_ptr<hw::DatagramLink> link_;
  hw::DatagramLink* link_view_;
  std::shared_ptr<device::ArmBackend> machine_;
  hw::fri::Emulator emulator_;
  std::int64_t cycle_number_ = -1;
};

struct FriSocketRig final : ArmRig {
  FriSocketRig() {
    auto adapted = std::make_shared<device::ArmDescription>(compliant_arm_description(hw::fri::kJoints));
    description = adapted;
    arm = std::make_shared<FakeArm>(device::JointVector::Zero(hw::fri::kJoints));
    tap = std::make_shared<ArmTap>(arm);
    hw::fri::ClientOptions client;
    hw::fri::ControllerOptions controller;
    twin = std::make_shared<SocketTwin>(device::DriverRequest{.device = "arm", .description = description}, client,
                                        controller, tap);
    backend = twin;
    pass_cycle = [this] { twin->pass_cycle(); };
    told_resolution = tracking = 3e-7;
    smoothness = 1.08;
    speed_noise = 1e-3;
  }
  void release() override {
    arm->state().ready = true;
    twin->reset();
  }

  std::shared_ptr<FakeArm> arm;
  std::shared_ptr<SocketTwin> twin;
};

}  // namespace takt::test
