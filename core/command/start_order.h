#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/command/command_tree.h"

namespace takt::command {

/// What is certain before the run of the order in which the commands of a tree start and end: a set of bits for each
/// command. Made once for a tree whose graph of starts has no cycle. Realtime: setup.
class StartOrder {
 public:
  explicit StartOrder(const CommandTree& tree);

  /// `second` can only start because of `first`, or of what `first` has led to.
  [[nodiscard]] bool leads_to(int first, int second) const { return led_to_.has(first, second); }
  /// `before` has ended, in this cycle at the latest, whenever `i` starts.
  [[nodiscard]] bool has_ended(int before, int i) const { return ended_.has(i, before); }

 private:
  /// A set of commands for each command.
  class Rows {
   public:
    using Word = std::uint64_t;
    explicit Rows(int size)
        : words_((static_cast<std::size_t>(size) + 63) / 64), bits_(static_cast<std::size_t>(size) * words_, 0) {}
    [[nodiscard]] bool has(int row, int column) const {
      return (of(row)[static_cast<std::size_t>(column) / 64] >> (static_cast<unsigned>(column) % 64) & 1U) != 0;
    }
    [[nodiscard]] std::span<const Word> of(int row) const {
      return std::span(bits_).subspan(static_cast<std::size_t>(row) * words_, words_);
    }
    [[nodiscard]] std::span<Word> of(int row) {
      return std::span(bits_).subspan(static_cast<std::size_t>(row) * words_, words_);
    }
    [[nodiscard]] std::size_t words() const { return words_; }

   private:
    std::size_t words_;
    std::vector<Word> bits_;
  };
  using Set = std::vector<Rows::Word>;

  void close_starts();
  void close_ends();
  [[nodiscard]] std::vector<int> in_order_of_reasons() const;
  [[nodiscard]] std::vector<int> reasons_of(int i) const;
  [[nodiscard]] Set ended_at_start(int i) const;
  [[nodiscard]] Set ended_when(const expression::ExpressionPtr& state) const;
  [[nodiscard]] Set ended_by(const expression::Expression& leaf) const;

  const CommandTree& tree_;
  Rows led_to_, ended_;
};

}  // namespace takt::command
