#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <boost/lockfree/spsc_queue.hpp>

#include "core/device/channel.h"
#include "core/net/value.h"

namespace takt::rcc {

/// How a value is watched.
struct WatchOptions {
  int every = 1;     ///< cycles from one value to the next; 0: none until it is changed
  int capacity = 0;  ///< of the ring of all values; 0: only the newest one is kept
};

/// What a watched port or channel was in a cycle.
struct WatchedValue {
  std::int64_t cycle = -1;
  std::optional<device::ChannelValue> value = {};  ///< empty: null
};

/// A value on its way out of the core: every n-th cycle into a ring that holds all of them, and into a slot that holds
/// the newest (docs/channels.md). Made by ControlCore::watch(). The cycle thread writes; one other thread reads.
/// Neither ever waits, and nothing is torn: a ring that is full drops the new value and counts it.
class Watch {
 public:
  /// @param source  the slot that is read in the cycle; it must stay while the watch is attached
  Watch(std::string name, net::ValueType type, const void* source, const WatchOptions& options);
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  // -- Any thread, wait-free -----------------------------------------------------------------------------------------
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] net::ValueType type() const { return type_; }
  /// From the next cycle on: cycles whose number is a multiple of `every`; 0: none.
  void set_every(int every) { every_.store(every < 0 ? 0 : every, std::memory_order_relaxed); }
  [[nodiscard]] int every() const { return every_.load(std::memory_order_relaxed); }
  /// Values that the ring had no room for.
  [[nodiscard]] std::int64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }
  /// Asks the cycle to let go of it; it says ended() then. Needs no room and is never refused.
  void give_up() { given_up_.store(true, std::memory_order_release); }
  /// The net has ended, or the watch was given up: no value comes any more.
  [[nodiscard]] bool ended() const { return ended_.load(std::memory_order_acquire); }

  // -- The reader's thread, wait-free --------------------------------------------------------------------------------
  /// The newest value; nothing before the first. The same value as often as it is asked for.
  [[nodiscard]] std::optional<WatchedValue> newest();
  /// Takes the oldest values out of the ring. @return how many.
  std::size_t take(std::span<WatchedValue> values);

  // -- The cycle thread. Realtime: cyclic ----------------------------------------------------------------------------
  void sample(std::int64_t cycle);
  [[nodiscard]] bool given_up() const { return given_up_.load(std::memory_order_acquire); }
  /// The last that the cycle does with it.
  void end() { ended_.store(true, std::memory_order_release); }

 private:
  static constexpr std::size_t kBytes = 160;
  struct Sample {
    std::int64_t cycle = -1;
    std::array<std::byte, kBytes> bytes{};
  };
  [[nodiscard]] WatchedValue value_of(const Sample& sample) const;

  std::string name_;
  net::ValueType type_;
  const std::byte* source_;
  std::size_t size_;
  std::atomic<int> every_;
  std::atomic<std::int64_t> dropped_ = 0;
  std::atomic<bool> ended_ = false, given_up_ = false;
  std::unique_ptr<boost::lockfree::spsc_queue<Sample>> ring_;

  // The newest: one place is the writer's, one the reader's, the one between them changes hands.
  static constexpr std::uint8_t kFresh = 4;
  std::array<Sample, 3> places_;
  std::atomic<std::uint8_t> between_ = 1;
  std::uint8_t writers_ = 0, readers_ = 2;
};

/// The watches that the cycle samples: attached, sampled and forgotten by the cycle thread alone; other threads post a
/// request to attach one and Watch::give_up() to forget it. Realtime: cyclic, no allocation, unless said otherwise.
class WatchList {
 public:
  static constexpr std::size_t kCapacity = 256;

  WatchList() { entries_.reserve(kCapacity); }
  /// `net` 0: the value of a channel, which never ends. @return false if the list is full.
  [[nodiscard]] bool attach(std::uint32_t net, Watch& watch) {
    if (entries_.size() == kCapacity) return false;
    entries_.push_back({net, &watch});
    return true;
  }
  /// `is_active(net)`: the net was evaluated in this cycle.
  template <class IsActive>
  void sample(std::int64_t cycle, IsActive is_active) {
    for (Entry& entry : entries_)
      if (entry.net == 0 || is_active(entry.net)) entry.watch->sample(cycle);
  }
  /// Lets go of watches that were given up, and of those whose net has ended. `has_ended(net)`: it will not be
  /// evaluated any more.
  template <class HasEnded>
  void forget_ended(HasEnded has_ended) {
    std::erase_if(entries_, [&](const Entry& entry) {
      const bool over = entry.watch->given_up() || (entry.net != 0 && has_ended(entry.net));
      if (over) entry.watch->end();
      return over;
    });
  }

 private:
  struct Entry {
    std::uint32_t net;
    Watch* watch;
  };
  std::vector<Entry> entries_;
};

}  // namespace takt::rcc
