#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace takt::rcc {

/// A bit for each slot of the net table, set by any thread and taken by the cycle: a request that needs no room and so
/// can never be refused. A bit that is set twice before the cycle takes it counts once.
class NetBits {
 public:
  explicit NetBits(std::size_t slots) : words_((slots + kBits - 1) / kBits) {}

  /// Any thread, wait-free.
  void set(std::size_t slot) {
    words_[slot / kBits].fetch_or(std::uint64_t{1} << slot % kBits, std::memory_order_release);
    any_.store(true, std::memory_order_release);
  }

  /// Calls take_one(slot) for each bit that is set and clears it. The cycle thread, wait-free.
  template <class TakeOne>
  void take(TakeOne take_one) {
    if (!any_.load(std::memory_order_relaxed)) return;
    (void)any_.exchange(false, std::memory_order_acq_rel);
    for (std::size_t word = 0; word < words_.size(); ++word) {
      if (words_[word].load(std::memory_order_relaxed) == 0) continue;
      std::uint64_t bits = words_[word].exchange(0, std::memory_order_acq_rel);
      for (; bits != 0; bits &= bits - 1) take_one(word * kBits + static_cast<std::size_t>(std::countr_zero(bits)));
    }
  }

 private:
  static constexpr std::size_t kBits = 64;
  std::vector<std::atomic<std::uint64_t>> words_;
  std::atomic<bool> any_ = false;  ///< saves the cycle the look at all words
};

}  // namespace takt::rcc
