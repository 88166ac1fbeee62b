#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/rcc/rules.h"

namespace takt::rcc {

/// The events of one cycle, in order; what does not fit is counted. Realtime: cyclic.
class EventBuffer {
 public:
  /// An answer to each request of a full queue and to each rule that waits, and as many changes of state and stops.
  static constexpr std::size_t kCapacity = 2048;

  /// Forgets those of the cycle before.
  void begin_cycle(std::int64_t cycle) {
    size_ = 0;
    cycle_ = cycle;
  }
  /// Of this cycle, whatever the event says.
  void add(const Event& event) {
    if (size_ < kCapacity) {
      events_[size_] = event;
      events_[size_++].cycle = cycle_;
    } else {
      ++dropped_;
    }
  }
  void state(NetId net, NetState state, const net::Cause& cause) {
    add({.kind = Event::Kind::kState, .state = state, .net = net, .request = 0, .cause = cause});
  }
  [[nodiscard]] std::span<const Event> view() const { return {events_.data(), size_}; }
  [[nodiscard]] std::int64_t dropped() const { return dropped_; }

 private:
  std::int64_t cycle_ = -1;
  std::array<Event, kCapacity> events_{};
  std::size_t size_ = 0;
  std::int64_t dropped_ = 0;
};

}  // namespace takt::rcc
