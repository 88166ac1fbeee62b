#pragma once

#include <memory>
#include <utility>

#include "core/device/driver.h"

namespace takt::cell {

/// A gripper behind a driver, and its simulated body, whose fingers follow: for pictures, and for what the simulated
/// fingers carry. Nothing of the body reaches the gripper. Thread: the cycle's. Realtime: cyclic.
class ShadowedGripper final : public device::GripperBackend {
 public:
  ShadowedGripper(std::shared_ptr<device::GripperDriver> driver, std::shared_ptr<device::GripperBackend> body)
      : driver_(std::move(driver)), body_(std::move(body)) {}

  bool read(device::GripperSample& sample) override { return driver_->read(sample); }
  /// The body gets the same commands: it holds its simulated part where the gripper holds the real one.
  void write(const device::GripperSetPoint& set_point) override {
    driver_->write(set_point);
    body_->write(set_point);
  }

 private:
  std::shared_ptr<device::GripperDriver> driver_;
  std::shared_ptr<device::GripperBackend> body_;
};

/// An output behind a driver, and the simulated one that shows it: lamps light up. Thread: the cycle's. Realtime:
/// cyclic.
template <class T>
class ShownOutput final : public device::SignalOutputBackend<T> {
 public:
  ShownOutput(std::shared_ptr<device::SignalOutputBackend<T>> output,
              std::shared_ptr<device::SignalOutputBackend<T>> shown)
      : output_(std::move(output)), shown_(std::move(shown)) {}

  [[nodiscard]] bool ready() const override { return output_->ready(); }
  void write(T value) override {
    output_->write(value);
    shown_->write(value);
  }

 private:
  std::shared_ptr<device::SignalOutputBackend<T>> output_, shown_;
};

/// The simulated outputs of a block show what the real ones are told.
inline void show_outputs(device::IoTerminals& terminals, const device::IoTerminals& shown) {
  for (auto& [name, output] : terminals.digital_outputs)
    output = std::make_shared<ShownOutput<bool>>(output, shown.digital_outputs.at(name));
  for (auto& [name, output] : terminals.analog_outputs)
    output = std::make_shared<ShownOutput<double>>(output, shown.analog_outputs.at(name));
}

}  // namespace takt::cell
