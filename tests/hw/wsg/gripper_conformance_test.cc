// The driver of WSG grippers under the suite that every gripper must pass: on a virtual wire, and over sockets.
#include "tests/support/gripper_conformance.h"

#include <thread>

#include "tests/hw/wsg/twin_rig.h"

namespace takt::hw::wsg {
namespace {

/// Driver with its thread and emulator over sockets; a cycle of the core lasts a millisecond of the wall clock.
class SocketRig final : public test::GripperRig {
 public:
  explicit SocketRig(bool with_part) {
    description = std::make_shared<const device::GripperDescription>(test::fake_gripper_description());
    part_width = with_part ? TwinRig::kPart : 0.0;
    machine_ = std::make_shared<test::KinematicGripper>(description->stroke, part_width);
    emulator_ = std::make_unique<Emulator>(EmulatorOptions{}, description, network_, machine_);
    auto free_port = network_.listen({kLoopback, 0});
    ClientOptions options;
    options.remote = (*free_port)->local();
    free_port->reset();
    if (auto begun = emulator_->listen(options.remote); !begun) throw std::runtime_error(begun.error().to_string());
    clock_.align(0, MonotonicClock::machine_time());
    backend =
        std::make_shared<Driver>(options, device::GripperRequest{"gripper", description, kMillisecond, 1}, clock_);
    // The suite waits for 50 cycles of virtual time: here a thread has to start first.
    device::GripperSample sample;
    for (int i = 0; i < 2000 && !(backend->read(sample) && sample.ready); ++i) live();
    clock_.align(0, MonotonicClock::machine_time());
    cycle_ = 0;
  }
  void advance() override {
    ++cycle_;
    live();
    // A cycle that the machine left out is none of the core's.
    const Nanoseconds late = clock_.now() - (cycle_ + 1) * kMillisecond;
    if (late > 0) clock_.skip(late);
    while (clock_.now() < cycle_ * kMillisecond) std::this_thread::sleep_for(std::chrono::microseconds(100));
  }

 private:
  void live() {
    machine_->advance();
    emulator_->advance(time_ += kMillisecond);
    std::this_thread::sleep_for(std::chrono::microseconds(800));
  }

  PosixNetwork network_;
  MonotonicClock clock_;
  std::shared_ptr<test::KinematicGripper> machine_;
  std::unique_ptr<Emulator> emulator_;
  std::int64_t cycle_ = 0;
  Nanoseconds time_ = 0;
};

test::GripperUnderTest on_wire(std::string name, TwinOptions options) {
  return {std::move(name), [options](bool part) { return std::make_unique<TwinRig>(part, options); }};
}

TwinOptions rough_wire() {
  TwinOptions options = ideal_wire();
  options.faults.wire.jitter = 3 * kMillisecond;
  options.faults.stream_piece = 1;
  return options;
}

}  // namespace
}  // namespace takt::hw::wsg

namespace takt::test {

INSTANTIATE_TEST_SUITE_P(
    Wsg, GripperConformance,
    testing::Values(hw::wsg::on_wire("Ideal", hw::wsg::ideal_wire()),
                    hw::wsg::on_wire("ByteByByteWithJitter", hw::wsg::rough_wire()),
                    GripperUnderTest{"Sockets", [](bool part) { return std::make_unique<hw::wsg::SocketRig>(part); }}),
    name_of_gripper);

}  // namespace takt::test
