#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/device/backend.h"
#include "sim/model/device.h"

namespace takt::sim {

/// What lies between an arm's sensors and whoever reads them: samples are seen late and not all of them.
/// Thread: one. Realtime: cyclic but for the constructor.
class SampleLine {
 public:
  /// @param delay  cycles from a sample to when it is seen @param every  one of so many is seen, >= 1
  SampleLine(std::size_t delay, std::size_t every) : under_way_(delay + 1), every_(every) {}

  void push(const device::ArmSample& sample) {
    under_way_[static_cast<std::size_t>(count_) % under_way_.size()] = sample;
    // Before the first one has come through, the first one is seen: the arm has stood there before.
    const std::uint64_t delay = under_way_.size() - 1, seen = count_ < delay ? 0 : count_ - delay;
    if (count_ <= delay || seen % every_ == 0) visible_ = under_way_[seen % under_way_.size()];
    ++count_;
  }
  [[nodiscard]] const device::ArmSample& visible() const { return visible_; }

  void stream(StateStream& state) {
    state(count_);
    for (device::ArmSample& sample : under_way_) stream(state, sample);
    stream(state, visible_);
  }

  /// A sample whose vectors have their final sizes.
  static void stream(StateStream& state, device::ArmSample& sample) {
    state(sample.sequence);
    state(sample.stamp);
    for (auto* values : {&sample.q, &sample.dq, &sample.tau, &sample.tau_external}) state.vector(*values);
    auto mode = static_cast<std::uint64_t>(sample.mode);
    state(mode);
    sample.mode = static_cast<device::ControlMode>(mode);
    state(sample.changing_mode);
    state(sample.braked);
  }

  /// Gives every sample its final sizes.
  void reset(const device::ArmSample& sample) {
    for (device::ArmSample& one : under_way_) one = sample;
    visible_ = sample;
  }

 private:
  std::vector<device::ArmSample> under_way_;
  std::size_t every_;
  device::ArmSample visible_;
  std::uint64_t count_ = 0;
};

}  // namespace takt::sim
