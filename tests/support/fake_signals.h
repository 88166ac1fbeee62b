#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/device/gripper.h"
#include "core/device/signal.h"

namespace takt::test {

/// A terminal that reads what the test says.
template <class T>
class FakeInput final : public device::SignalInputBackend<T> {
 public:
  bool read(device::SignalSample<T>& out) override {
    if (silent) return false;
    ++sample.sequence;
    out = sample;
    return true;
  }
  bool silent = false;
  device::SignalSample<T> sample;
};

/// A terminal that remembers what it was told.
template <class T>
class FakeOutput final : public device::SignalOutputBackend<T> {
 public:
  FakeOutput() { written.reserve(1u << 16); }  // a cycle must not allocate
  [[nodiscard]] bool ready() const override { return is_ready; }
  void write(T value) override { written.push_back(value); }
  bool is_ready = true;
  std::vector<T> written;
};

inline device::GripperSample ready_sample() {
  device::GripperSample sample;
  sample.ready = true;
  return sample;
}

/// A gripper that reports what the test says and remembers what it was told.
class FakeGripper final : public device::GripperBackend {
 public:
  FakeGripper() { written.reserve(1u << 12); }  // a cycle must not allocate
  bool read(device::GripperSample& out) override {
    if (silent) return false;
    ++sample.sequence;
    out = sample;
    return true;
  }
  void write(const device::GripperSetPoint& set_point) override {
    if (written.empty() || written.back().sequence != set_point.sequence) written.push_back(set_point);
    ++writes;
  }
  /// From now on it speaks of the newest command.
  void answer(device::GripperState state, double width) {
    sample.state = state;
    sample.width = width;
    sample.command = written.empty() ? 0 : written.back().sequence;
  }
  bool silent = false;
  int writes = 0;
  device::GripperSample sample = ready_sample();
  std::vector<device::GripperSetPoint> written;
};

/// Of the WSG 50 class, without geometry.
inline device::GripperDescription fake_gripper_description() {
  device::GripperDescription gripper;
  gripper.stroke = 0.11;
  gripper.speed_min = 0.005;
  gripper.speed_max = 0.42;
  gripper.force_min = 5.0;
  gripper.force_max = 80.0;
  return gripper;
}

/// A terminal of a block; analog ones have a range.
inline device::IoChannel fake_channel(device::IoChannel::Kind kind, std::string name, double lower = 0.0,
                                      double upper = 1.0) {
  device::IoChannel channel;
  channel.kind = kind;
  channel.name = std::move(name);
  channel.lower = lower;
  channel.upper = upper;
  return channel;
}

}  // namespace takt::test
