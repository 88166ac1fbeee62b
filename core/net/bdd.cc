#include "core/net/bdd.h"

#include <algorithm>

namespace takt::net {
namespace {

/// References stay below 2^24 and levels below 2^16.
constexpr std::size_t kMostNodes = std::size_t{1} << 24;

std::uint64_t packed(std::uint64_t head, std::uint64_t a, std::uint64_t b) { return head << 48 | a << 24 | b; }

}  // namespace

Bdd::Bdd(std::size_t most_nodes) : most_nodes_(std::min(most_nodes, kMostNodes)) {
  nodes_.push_back({kLeaf, kFalse, kFalse});
  nodes_.push_back({kLeaf, kTrue, kTrue});
}

Bdd::Ref Bdd::variable() {
  if (variables_ >= kMostVariables) {
    overflowed_ = true;
    return kTrue;
  }
  return make(variables_++, kFalse, kTrue);
}

Bdd::Ref Bdd::make(std::uint32_t level, Ref low, Ref high) {
  if (low == high) return low;
  if (nodes_.size() >= most_nodes_) {
    overflowed_ = true;
    return kTrue;
  }
  const auto [known, fresh] = unique_.try_emplace(packed(level, low, high), static_cast<Ref>(nodes_.size()));
  if (fresh) nodes_.push_back({level, low, high});
  return known->second;
}

bool Bdd::decided(Operator op, Ref a, Ref b, Ref& result) {
  if (op == Operator::kXor) {
    result = a == b ? kFalse : a == kFalse ? b : a;
    return a == b || a == kFalse || b == kFalse || (a == kTrue && b == kTrue);
  }
  const Ref strong = op == Operator::kAnd ? kFalse : kTrue;
  result = a == strong || b == strong ? strong : a == 1 - strong ? b : a;
  return a <= kTrue || b <= kTrue || a == b;
}

Bdd::Ref Bdd::apply(Operator op, Ref a, Ref b) {
  Ref result = kFalse;
  if (overflowed_ || decided(op, a, b, result)) return overflowed_ ? kTrue : result;
  if (a > b) std::swap(a, b);
  const std::uint64_t key = packed(static_cast<std::uint64_t>(op), a, b);
  if (const auto known = done_.find(key); known != done_.end()) return known->second;
  const Node x = nodes_[a], y = nodes_[b];
  const std::uint32_t level = std::min(x.level, y.level);
  const Ref low = apply(op, x.level == level ? x.low : a, y.level == level ? y.low : b);
  const Ref high = apply(op, x.level == level ? x.high : a, y.level == level ? y.high : b);
  result = make(level, low, high);
  overflowed_ = overflowed_ || done_.size() >= most_nodes_;
  done_.emplace(key, result);
  return result;
}

std::vector<std::pair<int, bool>> Bdd::example(Ref f) const {
  std::vector<std::pair<int, bool>> assignment;
  while (f > kTrue) {
    const Node& node = nodes_[f];
    const bool value = node.low == kFalse;
    assignment.emplace_back(static_cast<int>(node.level), value);
    f = value ? node.high : node.low;
  }
  return assignment;
}

}  // namespace takt::net
