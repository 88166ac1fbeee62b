#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace takt {

/// Hands the newest value from one thread to another: three places, of which the writer holds one, the reader one, and
/// one lies between. Nothing is ever torn, nobody ever waits; what is not taken in time is overwritten. T is copied
/// without allocation. One thread writes, one reads. Realtime: cyclic, wait-free.
template <class T>
class NewestSlot {
 public:
  /// Writer: the value is the newest from now on.
  void publish(const T& value) {
    places_[writing_] = value;
    writing_ = between_.exchange(static_cast<std::uint8_t>(writing_ | kFresh), std::memory_order_acq_rel) & kPlace;
  }

  /// Reader: goes over to the newest value. @return false if there is none newer than the last one taken.
  bool take() {
    if ((between_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    reading_ = between_.exchange(reading_, std::memory_order_acq_rel) & kPlace;
    return true;
  }
  /// Reader: what was taken last; T() before the first.
  [[nodiscard]] const T& value() const { return places_[reading_]; }

 private:
  static constexpr std::uint8_t kFresh = 4, kPlace = 3;

  std::array<T, 3> places_{};
  std::uint8_t writing_ = 0;
  std::atomic<std::uint8_t> between_ = 1;
  std::uint8_t reading_ = 2;
};

}  // namespace takt
