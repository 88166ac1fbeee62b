#include "cell/build/faulty_readings.h"

#include <algorithm>
#include <limits>

namespace takt::cell {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

// What a fault does to the value of each type of sample. `scale` is 1 for an offset, and drawn anew for each axis of
// noise.
template <class Scale>
void add(device::WrenchSample& sample, const DeviceFault& fault, const Scale& scale) {
  for (int axis = 0; axis < 3; ++axis) sample.wrench.force[axis] += fault.wrench.force[axis] * scale();
  for (int axis = 0; axis < 3; ++axis) sample.wrench.torque[axis] += fault.wrench.torque[axis] * scale();
}
template <class Scale>
void add(device::SignalSample<double>& sample, const DeviceFault& fault, const Scale& scale) {
  sample.value += fault.value * scale();
}
template <class Scale>
void add(device::SignalSample<bool>&, const DeviceFault&, const Scale&) {}

void make_nan(device::WrenchSample& sample) { sample.wrench.force.setConstant(kNotANumber); }
void make_nan(device::SignalSample<double>& sample) { sample.value = kNotANumber; }
void make_nan(device::SignalSample<bool>&) {}

void copy_value(const device::WrenchSample& from, device::WrenchSample& to) { to.wrench = from.wrench; }
template <class T>
void copy_value(const device::SignalSample<T>& from, device::SignalSample<T>& to) {
  to.value = from.value;
}

void set_value(device::WrenchSample&, const DeviceFault&) {}
void set_value(device::SignalSample<double>& sample, const DeviceFault& fault) { sample.value = fault.value; }
void set_value(device::SignalSample<bool>& sample, const DeviceFault& fault) { sample.value = fault.value != 0.0; }

}  // namespace

template <class Sample>
void ReadingFaults<Sample>::begin(const DeviceFault& fault, std::uint64_t seed, std::string_view name) {
  fault_ = fault;
  random_ = Random(seed ^ 0xFA17, name);
  stuck_.reset();
}

template <class Sample>
bool ReadingFaults<Sample>::pass(Sample& sample) {
  kept_[count_++ % kKept] = sample;
  if (fault_ && !spoil(sample)) return false;
  given_ = sample;
  return true;
}

template <class Sample>
bool ReadingFaults<Sample>::spoil(Sample& sample) {
  switch (fault_->kind) {
    case DeviceFault::Kind::kSilent:
    case DeviceFault::Kind::kGone:
      return false;
    case DeviceFault::Kind::kNan:
      make_nan(sample);
      return true;
    case DeviceFault::Kind::kStuck:
      if (!stuck_) stuck_ = sample;
      copy_value(*stuck_, sample);
      return true;
    case DeviceFault::Kind::kBias:
      add(sample, *fault_, [] { return 1.0; });
      return true;
    case DeviceFault::Kind::kNoise:
      add(sample, *fault_, [this] { return random_.normal(); });
      return true;
    case DeviceFault::Kind::kDelay:
      return read_late(sample);
    case DeviceFault::Kind::kValue:
      set_value(sample, *fault_);
      return true;
    case DeviceFault::Kind::kLoss:
      return lose(sample);
    case DeviceFault::Kind::kJammed:
      return true;
  }
  return true;
}

/// A reading that is lost leaves the one before it in force, as old as it is.
template <class Sample>
bool ReadingFaults<Sample>::lose(Sample& sample) {
  if (random_.unit() >= fault_->share) return true;
  if (!given_) return false;
  sample = *given_;
  return true;
}

/// The newest that is old enough; before there is one, none.
template <class Sample>
bool ReadingFaults<Sample>::read_late(Sample& sample) const {
  const Nanoseconds before = sample.stamp - fault_->delay;
  for (std::size_t back = 0; back < std::min(count_, kKept); ++back) {
    const Sample& kept = kept_[(count_ - 1 - back) % kKept];
    if (kept.stamp > before) continue;
    sample = kept;
    return true;
  }
  return false;
}

template class ReadingFaults<device::WrenchSample>;
template class ReadingFaults<device::SignalSample<bool>>;
template class ReadingFaults<device::SignalSample<double>>;

std::span<const DeviceFault::Kind> FaultySensor::kinds() const {
  static constexpr std::array kKinds = {
      DeviceFault::Kind::kSilent, DeviceFault::Kind::kNan,   DeviceFault::Kind::kStuck, DeviceFault::Kind::kBias,
      DeviceFault::Kind::kNoise,  DeviceFault::Kind::kDelay, DeviceFault::Kind::kLoss};
  return kKinds;
}

template <class T>
std::span<const DeviceFault::Kind> FaultyInput<T>::kinds() const {
  static constexpr std::array kDigital = {DeviceFault::Kind::kSilent, DeviceFault::Kind::kStuck,
                                          DeviceFault::Kind::kDelay, DeviceFault::Kind::kValue,
                                          DeviceFault::Kind::kLoss};
  static constexpr std::array kAnalog = {
      DeviceFault::Kind::kSilent, DeviceFault::Kind::kNan,   DeviceFault::Kind::kStuck, DeviceFault::Kind::kBias,
      DeviceFault::Kind::kNoise,  DeviceFault::Kind::kDelay, DeviceFault::Kind::kValue, DeviceFault::Kind::kLoss};
  if constexpr (std::is_same_v<T, bool>) {
    return kDigital;
  } else {
    return kAnalog;
  }
}

template class FaultyInput<bool>;
template class FaultyInput<double>;

}  // namespace takt::cell
