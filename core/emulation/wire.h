#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/base/random.h"
#include "core/base/time.h"

namespace takt::emulation {

/// What a wire does to what is sent over it. Shares are of messages, in [0, 1].
struct WireFaults {
  Nanoseconds transport = 0;  ///< every message takes at least this long
  Nanoseconds jitter = 0;     ///< and up to this much more, evenly spread
  double loss = 0.0;          ///< never arrives
  double repeat = 0.0;        ///< arrives twice
  double reorder = 0.0;       ///< is held back by `hold_back`, so that later ones overtake it
  Nanoseconds hold_back = 0;

  [[nodiscard]] Nanoseconds slowest() const { return transport + jitter; }
};

/// Messages on their way, with the faults of a wire; the same seed and the same calls give the same arrivals.
/// Realtime: cyclic.
template <class T>
class Wire {
 public:
  static constexpr std::size_t kCapacity = 32;  ///< messages on their way; more are lost
  static constexpr Nanoseconds kNever = std::numeric_limits<Nanoseconds>::max();

  Wire(const WireFaults& faults, std::uint64_t seed, std::string_view name) : faults_(faults), random_(seed, name) {}

  /// For what is sent from now on.
  void set_faults(const WireFaults& faults) { faults_ = faults; }

  void send(const T& message, Nanoseconds now) {
    // Every message draws the same number of numbers, so that one fault does not shift all that follow.
    const double lost = random_.unit(), twice = random_.unit(), held = random_.unit();
    const double late = random_.unit(), later = random_.unit();
    if (lost < faults_.loss) return;
    const Nanoseconds hold = held < faults_.reorder ? faults_.hold_back : 0;
    place(message, now + delay(late) + hold);
    if (twice < faults_.repeat) place(message, now + delay(late) + delay(later));
  }

  /// When the next message arrives; kNever if none is on its way.
  [[nodiscard]] Nanoseconds next_arrival() const { return count_ == 0 ? kNever : flights_[first()].arrival; }
  /// Takes the message that arrives next.
  T receive() {
    const std::size_t at = first();
    const T message = flights_[at].message;
    flights_[at] = flights_[--count_];
    return message;
  }

  /// Calls with each message on its way and its arrival, in no order but always the same.
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (std::size_t i = 0; i < count_; ++i) visit(flights_[i].message, flights_[i].arrival);
  }
  [[nodiscard]] const Random& random() const { return random_; }

 private:
  struct Flight {
    T message;
    Nanoseconds arrival = 0;
    std::uint64_t number = 0;  // of two that arrive at the same time the one sent first
  };

  [[nodiscard]] Nanoseconds delay(double share) const {
    return faults_.transport + static_cast<Nanoseconds>(share * static_cast<double>(faults_.jitter));
  }
  void place(const T& message, Nanoseconds arrival) {
    if (count_ < kCapacity) flights_[count_++] = {message, arrival, ++sent_};
  }
  [[nodiscard]] std::size_t first() const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < count_; ++i) {
      const bool sooner = flights_[i].arrival < flights_[best].arrival ||
                          (flights_[i].arrival == flights_[best].arrival && flights_[i].number < flights_[best].number);
      if (sooner) best = i;
    }
    return best;
  }

  WireFaults faults_;
  Random random_;
  std::array<Flight, kCapacity> flights_;
  std::size_t count_ = 0;
  std::uint64_t sent_ = 0;
};

}  // namespace takt::emulation
