#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace takt::rcc {

/// The digest of a run: one XXH3 (128 bit) over every block of every cycle, in order, each with its number and length
/// (row D4). Equal digests mean equal runs. Used by the cycle thread only; adding a block is setup.
class Digest {
 public:
  Digest();
  ~Digest();
  Digest(const Digest&) = delete;
  Digest& operator=(const Digest&) = delete;

  /// Memory outside the core that belongs to every cycle, such as the state of a simulation; must stay where it is and
  /// hold no padding. Realtime: setup. @return its number.
  int add_block(std::string name, std::span<const std::byte> bytes);

  /// One block of one cycle by itself: when two runs differ, the first that differs says where to look.
  struct BlockValue {
    std::uint64_t block = 0;
    std::uint64_t value = 0;  ///< XXH3 (64 bit) of the bytes
    bool operator==(const BlockValue&) const = default;
  };
  /// From now on the value of each block is kept for a cycle, of at most `capacity` blocks; costs as much again as the
  /// digest. Realtime: setup.
  void keep_blocks(std::size_t capacity);
  /// The blocks of the newest cycle in the order in which they were taken; empty unless they are kept.
  [[nodiscard]] std::span<const BlockValue> blocks() const { return kept_; }
  /// A new cycle: the blocks of the last one are forgotten. Realtime: cyclic.
  void begin_cycle() { kept_.clear(); }
  /// Name of a block that was added; nullptr: it is not one of these.
  [[nodiscard]] const std::string* name_of(std::uint64_t block) const;

  /// Takes a block into the digest. Realtime: cyclic.
  void take(std::uint64_t block, std::span<const std::byte> bytes);
  /// Takes all added blocks. Realtime: cyclic.
  void take_added_blocks();

  /// The digest of all that was taken so far; goes on afterwards. Realtime: cyclic.
  struct Value {
    std::uint64_t high = 0, low = 0;
    bool operator==(const Value&) const = default;
  };
  [[nodiscard]] Value value() const;

 private:
  struct State;
  struct Block {
    std::string name;
    std::span<const std::byte> bytes;
  };
  std::unique_ptr<State> state_;
  std::vector<Block> blocks_;
  std::vector<BlockValue> kept_;  ///< never grows beyond its capacity
  bool keeps_blocks_ = false;
};

/// 32 hexadecimal digits.
[[nodiscard]] std::string to_string(const Digest::Value& value);

}  // namespace takt::rcc
