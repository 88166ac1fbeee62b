#include "cell/build/faulty_machines.h"

#include <array>

namespace takt::cell {
namespace {

/// A message that is lost leaves the one before it in force, as old as it is.
template <class Backend, class Sample>
bool read_through(Backend& machine, ConnectionFaults& faults, std::optional<Sample>& given, Sample& sample) {
  if (!machine.read(sample) || faults.gone()) return false;
  if (faults.loses()) {
    if (!given) return false;
    sample = *given;
    return true;
  }
  given = sample;
  return true;
}

}  // namespace

std::span<const DeviceFault::Kind> FaultyArm::kinds() const {
  static constexpr std::array kKinds = {DeviceFault::Kind::kGone, DeviceFault::Kind::kLoss};
  return kKinds;
}

bool FaultyArm::read(device::ArmSample& sample) { return read_through(*machine_, faults_, given_, sample); }

std::span<const DeviceFault::Kind> FaultyGripper::kinds() const {
  static constexpr std::array kKinds = {DeviceFault::Kind::kGone, DeviceFault::Kind::kLoss, DeviceFault::Kind::kJammed};
  return kKinds;
}

bool FaultyGripper::read(device::GripperSample& sample) { return read_through(*machine_, faults_, given_, sample); }

}  // namespace takt::cell
