#pragma once

#include <array>
#include <atomic>
#include <cstddef>

namespace takt::rcc {

/// A bounded queue from any number of threads to one: D. Vyukov's bounded queue, in which each cell carries the number
/// of the turn that it is ready for, reduced to one reader. Everything of a value is written before its turn is
/// published and read after it, so no value is torn and nothing is allocated or freed.
///
/// push() is lock-free for any thread; pop() is wait-free and for one thread. A writer that is preempted between its
/// claim and its publication delays those who came after it; the reader sees an empty queue until then and never waits.
template <class T, std::size_t kSize>
class RequestQueue {
 public:
  static constexpr std::size_t kCapacity = kSize;

  RequestQueue() {
    for (std::size_t i = 0; i < kCapacity; ++i) cells_[i].turn.store(i, std::memory_order_relaxed);
  }

  /// @return false if the queue is full: `value` was not taken.
  [[nodiscard]] bool push(const T& value) {
    std::size_t at = tail_.load(std::memory_order_relaxed);
    for (;;) {
      Cell& cell = cells_[at % kCapacity];
      const std::size_t turn = cell.turn.load(std::memory_order_acquire);
      if (turn < at) return false;  // its value of one round ago was not read yet
      if (turn > at) {
        at = tail_.load(std::memory_order_relaxed);
      } else if (tail_.compare_exchange_weak(at, at + 1, std::memory_order_relaxed)) {
        cell.value = value;
        cell.turn.store(at + 1, std::memory_order_release);
        return true;
      }
    }
  }

  /// @return false if there is none; `value` is then untouched.
  [[nodiscard]] bool pop(T& value) {
    Cell& cell = cells_[head_ % kCapacity];
    if (cell.turn.load(std::memory_order_acquire) != head_ + 1) return false;
    value = cell.value;
    cell.turn.store(head_ + kCapacity, std::memory_order_release);
    ++head_;
    return true;
  }

 private:
  struct Cell {
    std::atomic<std::size_t> turn = 0;  ///< i: free for value number i; i + 1: value number i is in it
    T value{};
  };
  std::array<Cell, kCapacity> cells_;
  alignas(64) std::atomic<std::size_t> tail_ = 0;
  alignas(64) std::size_t head_ = 0;
};

}  // namespace takt::rcc
