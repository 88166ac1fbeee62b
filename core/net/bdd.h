#pragma once

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

namespace takt::net {

/// Boolean functions as reduced ordered binary decision diagrams: two functions are equal exactly if their references
/// are. Bounded: beyond `most_nodes`, as many steps of work, or kMostVariables overflowed() is true and results mean
/// nothing any more.
/// Source: Bryant, "Graph-based algorithms for Boolean function manipulation", 1986. Private to core/net.
class Bdd {
 public:
  using Ref = std::uint32_t;
  static constexpr Ref kFalse = 0, kTrue = 1;
  static constexpr std::size_t kMostVariables = 256;  ///< also the depth of the recursion

  explicit Bdd(std::size_t most_nodes);

  /// A new variable, behind all others in the order. @return kTrue after an overflow.
  Ref variable();
  Ref both(Ref a, Ref b) { return apply(Operator::kAnd, a, b); }
  Ref either(Ref a, Ref b) { return apply(Operator::kOr, a, b); }
  Ref opposite(Ref a) { return apply(Operator::kXor, a, kTrue); }
  [[nodiscard]] bool overflowed() const { return overflowed_; }
  /// Steps of work so far.
  [[nodiscard]] std::size_t work() const { return done_.size(); }
  [[nodiscard]] int variable_of(Ref variable) const { return static_cast<int>(nodes_[variable].level); }

  /// One assignment that makes `f` true, false rather than true where both do: (variable, value). Empty for constants.
  [[nodiscard]] std::vector<std::pair<int, bool>> example(Ref f) const;

 private:
  enum class Operator : std::uint8_t { kAnd, kOr, kXor };
  struct Node {
    std::uint32_t level;
    Ref low, high;  ///< for the variable being false and true
  };
  static constexpr std::uint32_t kLeaf = ~std::uint32_t{0};

  Ref make(std::uint32_t level, Ref low, Ref high);
  Ref apply(Operator op, Ref a, Ref b);
  static bool decided(Operator op, Ref a, Ref b, Ref& result);

  std::vector<Node> nodes_;
  std::unordered_map<std::uint64_t, Ref> unique_, done_;  ///< looked up only, never walked
  std::size_t most_nodes_;                                ///< and most entries of done_
  std::uint32_t variables_ = 0;
  bool overflowed_ = false;
};

}  // namespace takt::net
