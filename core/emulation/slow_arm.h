#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/base/clock.h"
#include "core/device/arm_agent.h"
#include "core/device/backend.h"
#include "core/emulation/slow_controller.h"
#include "core/emulation/slow_options.h"
#include "core/emulation/state_hash.h"

namespace takt::emulation {

/// What was measured of a slow arm, with the true clocks at hand.
struct SlowArmReport {
  device::AgentReport agent;
  /// From the time of a set point to the instant for which the device is told it: least and most so far, ns. The most
  /// is less than the least before the first set point.
  Nanoseconds delay_least = INT64_MAX, delay_most = INT64_MIN;
  std::uint64_t missed_answers = 0;

  [[nodiscard]] bool moved() const { return delay_least <= delay_most; }
};

/// A slow arm around any arm that lives in the core's cycle: a controller with a cycle and a clock of its own, a wire
/// in both directions with jitter, losses, repeats and overtaking, and the I/O agent at the core's end of it, all on
/// virtual time (row T4). read() makes time go on by one core cycle, so it is called once in each.
/// What it tells the arm behind it in a cycle comes from the controller's interpolator. Compliances and changes of the
/// control mode reach the controller at once: they do not travel with the set points. A change that needs standstill
/// waits until the set points that are on their way have come to rest. Realtime: cyclic but for the constructor.
class SlowArm final : public device::ArmBackend {
 public:
  /// Cause of a controller that stopped because answers were missing (ArmSample::fault).
  static constexpr std::uint32_t kAnswersMissing = 0x4000'0001;

  /// @param inner   the arm behind it @param limits  of the controller's own stop @param seed  of the wire's faults
  /// @param modes   of the arm behind it
  SlowArm(const std::string& name, std::shared_ptr<device::ArmBackend> inner, const motion::JointLimits& limits,
          const SlowOptions& options, Nanoseconds core_period, std::uint64_t seed, device::ControlModes modes = {});
  /// The modes as the core sees them through such a device: what is done at standstill takes longer by the delay of the
  /// set points, and nothing enters position in motion. Realtime: setup.
  [[nodiscard]] static device::ControlModes delayed(const device::ControlModes& modes, const SlowOptions& options,
                                                    Nanoseconds core_period);

  void set_held(bool held) override { agent_.set_held(held); }
  bool read(device::ArmSample& sample) override;
  void write(const device::ArmSetPoint& set_point) override { agent_.write(set_point); }
  void write_compliance(const device::Compliance& compliance) override { inner_->write_compliance(compliance); }
  void change_mode(device::ControlMode mode) override;
  /// Settings do not travel with the set points: the controller has it at once.
  void set_payload(const device::PayloadSetting& payload) override { inner_->set_payload(payload); }
  void set_tool(const device::ToolSetting& tool) override { inner_->set_tool(tool); }
  void brake() override { agent_.brake(); }
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override;
  [[nodiscard]] device::BackendTiming timing() const override;

  /// A core cycle in which the core does nothing: what a stalled core looks like to the arm.
  void pass_cycle() { advance(++core_cycle_ * core_period_); }
  [[nodiscard]] SlowArmReport report() const;
  /// All that its future depends on, as a block for the digest.
  [[nodiscard]] const StateHash& state() const { return state_; }

 private:
  /// A change of the mode at standstill, from the request until the arm behind is in the new mode.
  struct Change {
    device::ControlMode to = device::ControlMode::kPosition;
    std::int64_t from = 0, end = 0;  // core cycles: the arm behind is asked for it; then no more
    std::int64_t shown_until = -1;   // device cycle: so long at least, that the agent and the core see it; -1: not yet
  };
  struct Sent {
    device::ArmAnswer answer;
    Nanoseconds resampled = -1;
  };

  void advance(Nanoseconds now);
  void look_at_plant();
  void begin_device_cycle();
  void answer_packet();
  void take_answer();
  void tell_plant(Nanoseconds now);
  void measure_delay();
  void hash_state();
  void continue_change();
  [[nodiscard]] bool ready() const { return plant_.ready && !controller_.timed_out(); }
  /// Set points that were sent before the request are still followed.
  [[nodiscard]] bool changing() const { return (change_ && change_->shown_until >= 0) || plant_.changing_mode; }

  std::shared_ptr<device::ArmBackend> inner_;
  SlowOptions options_;
  Nanoseconds core_period_;
  device::ControlModes modes_;
  DeviceClock device_clock_;
  VirtualClock core_clock_;
  device::ArmAgent agent_;
  SlowController controller_;
  Wire<device::ArmPacket> to_core_;
  Wire<Sent> to_device_;

  std::int64_t core_cycle_ = -1;
  std::int64_t device_cycle_;  ///< the next one
  std::uint64_t sequence_ = 0;
  device::ArmSample plant_;  ///< as the controller measures it
  bool has_plant_ = false, looked_ = false;
  std::optional<Change> change_;
  SlowArmReport report_;
  StateHash state_;
};

}  // namespace takt::emulation
