#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace takt::device {

/// Carries the newest of what many threads put in to the one thread that takes it out. Nobody ever waits and nothing
/// is torn: a writer fills a cell of its own and exchanges it for the newest one, the reader takes the newest away.
///
/// There are kCells cells: one may be the newest, one with the reader, the rest with writers. A writer that finds none
/// free, because that many others were stopped half way, is told so.
template <std::size_t kBytes>
class Mailbox {
 public:
  static constexpr int kCells = 16;

  /// fill(std::byte*) writes a whole value. Any thread, wait-free. @return false if no cell is free.
  template <class Fill>
  [[nodiscard]] bool put(Fill fill) {
    for (int i = 0; i < kCells; ++i) {
      Cell& cell = cells_[static_cast<std::size_t>(i)];
      if (cell.taken.exchange(true, std::memory_order_acquire)) continue;
      fill(cell.bytes.data());
      free(newest_.exchange(i, std::memory_order_acq_rel));
      return true;
    }
    return false;
  }

  /// read(const std::byte*) sees the newest value, if one came since the last call. One thread, wait-free.
  /// @return false if none came.
  template <class Read>
  [[nodiscard]] bool take(Read read) {
    if (newest_.load(std::memory_order_relaxed) == kNone) return false;
    const int newest = newest_.exchange(kNone, std::memory_order_acq_rel);
    read(static_cast<const std::byte*>(cells_[static_cast<std::size_t>(newest)].bytes.data()));
    free(newest);
    return true;
  }

 private:
  static constexpr int kNone = -1;
  struct alignas(64) Cell {
    std::array<std::byte, kBytes> bytes{};
    std::atomic<bool> taken = false;
  };
  void free(int cell) {
    if (cell != kNone) cells_[static_cast<std::size_t>(cell)].taken.store(false, std::memory_order_release);
  }

  std::array<Cell, kCells> cells_;
  std::atomic<int> newest_ = kNone;
};

}  // namespace takt::device
