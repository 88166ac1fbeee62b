#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "core/base/random.h"
#include "core/device/backend.h"

namespace takt::scenario {

/// What is wrong with the readings of a force/torque sensor for a while.
struct SensorFault {
  enum class Kind {
    kSilent,  ///< there is no reading: null
    kNan,     ///< the force is not a number
    kStuck,   ///< the last reading again and again, with new numbers and stamps
    kBias,    ///< an offset is added
    kNoise,   ///< normally distributed, added to each axis
    kDelay    ///< readings come later; their stamps say so
  };
  Kind kind = Kind::kSilent;
  net::Wrench wrench{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};  ///< N, Nm: the offset, or the sigma per axis
  Nanoseconds delay = 0;
};

/// A force/torque sensor between its machine and the core that can be told to be wrong (docs/how-to/
/// operator-and-faults.md). Without a fault it is not there. Owned by its device. Realtime: cyclic.
class FaultySensor final : public device::ForceTorqueBackend {
 public:
  explicit FaultySensor(std::shared_ptr<device::ForceTorqueBackend> sensor) : sensor_(std::move(sensor)) {}

  /// From the next reading on; one fault at a time, the newest.
  void begin(const SensorFault& fault, std::uint64_t seed, const std::string& name) {
    fault_ = fault;
    random_ = Random(seed, name + " fault");
    stuck_.reset();
  }
  void end() { fault_.reset(); }

  bool read(device::WrenchSample& sample) override;
  [[nodiscard]] device::BackendTiming timing() const override { return sensor_->timing(); }

  /// Readings are kept for so many cycles: the longest delay.
  static constexpr std::size_t kKept = 1000;

 private:
  bool spoil(device::WrenchSample& sample);
  [[nodiscard]] bool read_late(device::WrenchSample& sample) const;
  void add_noise(net::Wrench& wrench);

  std::shared_ptr<device::ForceTorqueBackend> sensor_;
  std::optional<SensorFault> fault_;
  Random random_{0, ""};
  std::optional<net::Wrench> stuck_;
  std::array<device::WrenchSample, kKept> kept_{};  ///< a ring
  std::size_t count_ = 0;
};

}  // namespace takt::scenario
