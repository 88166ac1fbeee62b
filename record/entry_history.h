#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <vector>

#include "core/base/time.h"
#include "record/sample_ring.h"

namespace takt::record {

/// The entries of the last seconds, in memory, as they came off the ring; the oldest go in blocks of a fifth of a
/// second. After keep() nothing goes any more, and what comes is added for a second. Thread: one at a time.
class EntryHistory {
 public:
  /// @param span  how much is kept at least
  explicit EntryHistory(Nanoseconds span) : span_(span) {}

  /// A cycle begins: entries up to the next call belong to it.
  void begin_cycle(Nanoseconds time);
  void add(const SampleRing::Entry& entry);
  void keep();
  [[nodiscard]] bool kept() const { return kept_; }
  /// Gives all entries, the oldest first.
  void replay(const std::function<void(const SampleRing::Entry&)>& take) const;

 private:
  struct Block {
    Nanoseconds begin = 0;
    std::vector<std::uint64_t> words;  ///< per entry: tag and count, then its words
  };

  Nanoseconds span_;
  Nanoseconds now_ = 0, last_ = 0;  ///< last: of what is still added after keep()
  bool kept_ = false;
  std::deque<Block> blocks_;
};

}  // namespace takt::record
