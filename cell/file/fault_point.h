#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "core/base/time.h"
#include "core/net/value.h"

namespace takt::cell {

/// What is wrong with a device for a while.
struct DeviceFault {
  enum class Kind {
    // of readings
    kSilent,  ///< there is none: null
    kNan,     ///< it is not a number
    kStuck,   ///< the last one again and again, with new numbers and stamps
    kBias,    ///< an offset is added
    kNoise,   ///< normally distributed, added to each axis
    kDelay,   ///< readings come later; their stamps say so
    kValue,   ///< an input reads this value, whatever is there
    // of what is between a device and the core
    kGone,    ///< nothing comes and nothing arrives
    kLoss,    ///< a share of the readings, and of what a machine is told, does not arrive
    kJammed,  ///< nothing that it is told has an effect
  };
  static constexpr std::size_t kMaxDelayCycles = 1000;  ///< readings are kept for so many

  Kind kind = Kind::kSilent;
  net::Wrench wrench{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};  ///< N, Nm: the offset, or the sigma per axis
  double value = 0.0;  ///< of an input, in its unit: the offset, the sigma, the value
  Nanoseconds delay = 0;
  double share = 0.0;  ///< of what is lost, 0 to 1
};

/// A place between a device and the core at which a fault of the scenario acts. Without one it is not there.
/// Thread: the cycle's. Realtime: cyclic.
class FaultPoint {
 public:
  virtual ~FaultPoint() = default;
  /// What can be wrong with it; the first is the plainest.
  [[nodiscard]] virtual std::span<const DeviceFault::Kind> kinds() const = 0;
  /// From the next cycle on; one fault at a time, the newest.
  /// @param seed  of the scenario; @param name  of the device: together they give the random numbers
  virtual void begin(const DeviceFault& fault, std::uint64_t seed, std::string_view name) = 0;
  virtual void end() = 0;
};

}  // namespace takt::cell
