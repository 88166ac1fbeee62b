#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "cell/file/fault_point.h"
#include "core/base/random.h"
#include "core/device/backend.h"
#include "core/device/signal.h"

namespace takt::cell {

/// What faults make of the readings of a device, one per cycle. Sample: WrenchSample, SignalSample<bool>,
/// SignalSample<double>. Realtime: cyclic.
template <class Sample>
class ReadingFaults {
 public:
  void begin(const DeviceFault& fault, std::uint64_t seed, std::string_view name);
  void end() { fault_.reset(); }
  /// @param sample  in: what was read; out: what the core gets
  /// @return false: it gets nothing
  bool pass(Sample& sample);

  /// Readings are kept for so many cycles: the longest delay.
  static constexpr std::size_t kKept = DeviceFault::kMaxDelayCycles;

 private:
  bool spoil(Sample& sample);
  bool lose(Sample& sample);
  [[nodiscard]] bool read_late(Sample& sample) const;

  std::optional<DeviceFault> fault_;
  Random random_{0, ""};
  std::optional<Sample> stuck_;
  std::optional<Sample> given_;       ///< what the core got last
  std::array<Sample, kKept> kept_{};  ///< a ring
  std::size_t count_ = 0;
};

extern template class ReadingFaults<device::WrenchSample>;
extern template class ReadingFaults<device::SignalSample<bool>>;
extern template class ReadingFaults<device::SignalSample<double>>;

/// A force/torque sensor between its machine and the core that can be told to be wrong (docs/how-to/
/// operator-and-faults.md). Owned by its device. Realtime: cyclic.
class FaultySensor final : public device::ForceTorqueBackend, public FaultPoint {
 public:
  explicit FaultySensor(std::shared_ptr<device::ForceTorqueBackend> sensor) : sensor_(std::move(sensor)) {}

  [[nodiscard]] std::span<const DeviceFault::Kind> kinds() const override;
  void begin(const DeviceFault& fault, std::uint64_t seed, std::string_view name) override {
    faults_.begin(fault, seed, name);
  }
  void end() override { faults_.end(); }
  bool read(device::WrenchSample& sample) override { return sensor_->read(sample) && faults_.pass(sample); }
  [[nodiscard]] device::BackendTiming timing() const override { return sensor_->timing(); }

 private:
  std::shared_ptr<device::ForceTorqueBackend> sensor_;
  ReadingFaults<device::WrenchSample> faults_;
};

/// The same of an input: a terminal, a light barrier, a range finder.
template <class T>
class FaultyInput final : public device::SignalInputBackend<T>, public FaultPoint {
 public:
  explicit FaultyInput(std::shared_ptr<device::SignalInputBackend<T>> input) : input_(std::move(input)) {}

  [[nodiscard]] std::span<const DeviceFault::Kind> kinds() const override;
  void begin(const DeviceFault& fault, std::uint64_t seed, std::string_view name) override {
    faults_.begin(fault, seed, name);
  }
  void end() override { faults_.end(); }
  bool read(device::SignalSample<T>& sample) override { return input_->read(sample) && faults_.pass(sample); }

 private:
  std::shared_ptr<device::SignalInputBackend<T>> input_;
  ReadingFaults<device::SignalSample<T>> faults_;
};

extern template class FaultyInput<bool>;
extern template class FaultyInput<double>;

}  // namespace takt::cell
