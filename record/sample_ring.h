#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace takt::record {

/// A bounded queue of entries between one producer and one consumer, wait-free on both sides. An entry is a run of
/// 8-byte words whose first word the ring uses; entries never wrap, so both sides see plain memory. What the producer
/// reserves becomes visible with publish(), all at once, or vanishes with roll_back().
/// Realtime: cyclic but for the constructor.
class SampleRing {
 public:
  explicit SampleRing(std::size_t bytes) : words_(std::bit_ceil(bytes / 8 < 64 ? 64 : bytes / 8)) {}

  /// The largest entry that always fits once the ring has been emptied.
  [[nodiscard]] std::size_t max_words() const { return words_.size() / 4; }

  /// Producer: room for an entry of `words` words after the ring's own first one, or nullptr while the ring is full.
  /// `tag` is handed to the consumer.
  std::uint64_t* reserve(std::uint32_t tag, std::uint32_t words) {
    const std::size_t need = words + 1;
    const std::size_t index = staged_ & mask();
    const std::size_t to_end = words_.size() - index;
    const std::size_t skip = need > to_end ? to_end : 0;
    if (staged_ + skip + need - tail_seen_ > words_.size()) {
      tail_seen_ = tail_.load(std::memory_order_acquire);
      if (staged_ + skip + need - tail_seen_ > words_.size()) return nullptr;
    }
    if (skip != 0) words_[index] = head_word(kSkip, static_cast<std::uint32_t>(skip - 1));
    const std::size_t at = (staged_ + skip) & mask();
    words_[at] = head_word(tag, words);
    staged_ += skip + need;
    return &words_[at + 1];
  }
  /// Producer: everything reserved is now the consumer's.
  void publish() {
    if (staged_ == published_) return;
    published_ = staged_;
    head_.store(published_, std::memory_order_release);
  }
  /// Producer: forgets what was reserved since the last publish().
  void roll_back() { staged_ = published_; }

  struct Entry {
    std::uint32_t tag = 0;
    std::span<const std::uint64_t> words;
    bool valid = false;
  };
  /// Consumer: the oldest entry, until release(); not valid if there is none.
  Entry front() {
    for (;;) {
      if (read_ == head_seen_) {
        head_seen_ = head_.load(std::memory_order_acquire);
        if (read_ == head_seen_) return {};
      }
      const std::size_t index = read_ & mask();
      const auto tag = static_cast<std::uint32_t>(words_[index] >> 32);
      const auto count = static_cast<std::uint32_t>(words_[index]);
      next_ = read_ + count + 1;
      if (tag != kSkip) return {tag, {words_.data() + index + 1, count}, true};
      read_ = next_;
    }
  }
  void release() {
    read_ = next_;
    tail_.store(read_, std::memory_order_release);
  }

 private:
  static constexpr std::uint32_t kSkip = 0xFFFFFFFF;
  static constexpr std::uint64_t head_word(std::uint32_t tag, std::uint32_t words) {
    return (static_cast<std::uint64_t>(tag) << 32) | words;
  }
  [[nodiscard]] std::size_t mask() const { return words_.size() - 1; }

  std::vector<std::uint64_t> words_;
  // Positions count words and never wrap. Each side's own on a cache line of its own.
  alignas(64) std::size_t staged_ = 0;
  std::size_t published_ = 0;
  std::size_t tail_seen_ = 0;
  alignas(64) std::size_t read_ = 0;
  std::size_t next_ = 0;
  std::size_t head_seen_ = 0;
  alignas(64) std::atomic<std::size_t> head_{0};
  alignas(64) std::atomic<std::size_t> tail_{0};
};

}  // namespace takt::record
