#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "record/sample_ring.h"

namespace takt::record {

/// The entries of the last seconds, in memory, as they came off the ring; the oldest go in blocks of a fifth of a
/// second. After keep() they are given away, and what comes within a second after it too; then a new history begins.
/// Thread: one at a time.
class EntryHistory {
 public:
  using Take = std::function<void(const SampleRing::Entry&)>;

  /// @param span  how much is held at least
  /// @param take  gets what is kept, in the order in which it came
  EntryHistory(Nanoseconds span, Take take) : span_(span), take_(std::move(take)) {}

  /// A cycle begins: entries up to the next call belong to it.
  void begin_cycle(Nanoseconds time);
  void add(const SampleRing::Entry& entry);
  void keep();
  /// keep() has been called.
  [[nodiscard]] bool kept() const { return kept_; }

 private:
  struct Block {
    Nanoseconds begin = 0;
    std::vector<std::uint64_t> words;  ///< per entry: tag and count, then its words
  };
  void give(const Block& block) const;

  Nanoseconds span_;
  Take take_;
  Nanoseconds now_ = 0, last_ = -1;  ///< last: of what is still given away after keep()
  bool kept_ = false;
  std::deque<Block> blocks_;
};

}  // namespace takt::record
