#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/net/condition_graph.h"

namespace takt::net {

/// Which of several primitives never run in one cycle, as far as unit propagation shows it (row O4): what makes a
/// fragment active makes both inputs of an And true and those of an Or that is false false, and so on through the
/// gates. Two whose activations need a condition to be true and to be false exclude each other.
///
/// All primitives are propagated at once, as sets of bits per condition, so fragments that take turns along a chain
/// cost in proportion to what their activations depend on. What this does not show may still exclude each other:
/// Activation knows numbers and null, and looks into the cycles before. Private to core/net. Realtime: setup.
class Implications {
 public:
  Implications(const FlatNet& flat, std::span<const int> primitives);

  /// Pairs (places in `primitives`, the smaller first) that are not shown to exclude each other, by the second.
  [[nodiscard]] const std::vector<std::pair<std::size_t, std::size_t>>& open_pairs() const { return open_; }
  /// There are more such pairs than are listed.
  [[nodiscard]] bool has_more() const { return has_more_; }

 private:
  using Condition = ConditionGraph::Condition;
  using Word = std::uint64_t;
  static constexpr std::size_t kWordBits = 64;
  static constexpr std::size_t kBlock = 1024;        ///< primitives that are propagated at once
  static constexpr int kMostSweeps = 4;              ///< in both directions; conditions of a mapped command need one
  static constexpr std::size_t kMostOpen = 200'000;  ///< pairs that are listed

  /// A condition that has to be true, or false.
  struct Literal {
    int condition;
    bool value;
  };

  void solve(std::size_t begin, std::size_t end);
  bool sweep_to_operands();
  bool sweep_from_operands();
  bool add(int condition, bool value, std::span<const Word> primitives);
  bool add_common(int condition, bool value, std::span<const Word> a, std::span<const Word> b);
  [[nodiscard]] std::span<Word> needing(int condition, bool value);
  void list_open(std::size_t primitive, std::size_t begin, std::size_t end);
  [[nodiscard]] std::vector<Word> earlier(std::size_t primitive, std::size_t begin, std::size_t end) const;
  void exclude_by(std::size_t primitive, std::vector<Word>& left);
  void visit(const Literal& literal);
  void follow(const Literal& literal);

  ConditionGraph graph_;
  std::vector<int> running_;  ///< condition of each primitive
  std::vector<int> order_;
  std::size_t words_ = 0;   ///< of a set of bits
  std::vector<Word> sets_;  ///< per condition: who needs it to be true, who false
  std::vector<std::uint32_t> seen_;
  std::uint32_t round_ = 0;
  std::vector<Literal> queue_;
  std::vector<std::pair<std::size_t, std::size_t>> open_;
  bool has_more_ = false;
};

}  // namespace takt::net
