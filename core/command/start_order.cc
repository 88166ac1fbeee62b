#include "core/command/start_order.h"

#include <algorithm>
#include <optional>

namespace takt::command {
namespace {

using Bits = std::uint64_t;

void set_bit(std::span<Bits> set, int i) {
  set[static_cast<std::size_t>(i) / 64] |= Bits{1} << (static_cast<unsigned>(i) % 64);
}

void unite(std::span<Bits> set, std::span<const Bits> more) {
  for (std::size_t w = 0; w < set.size(); ++w) set[w] |= more[w];
}

void intersect(std::span<Bits> set, std::span<const Bits> other) {
  for (std::size_t w = 0; w < set.size(); ++w) set[w] &= other[w];
}

}  // namespace

StartOrder::StartOrder(const CommandTree& tree) : tree_(tree), led_to_(tree.size()), ended_(tree.size()) {
  close_starts();
  close_ends();
}

/// The last ranks first: what they lead to is known when those before them need it.
void StartOrder::close_starts() {
  const std::vector<int> ranks = tree_.ranks();
  std::vector<int> order(ranks.size());
  for (std::size_t i = 0; i < ranks.size(); ++i) order[static_cast<std::size_t>(ranks[i])] = static_cast<int>(i);
  std::ranges::reverse(order);
  for (const int i : order) {
    for (const int next : tree_.starts()[static_cast<std::size_t>(i)]) {
      set_bit(led_to_.of(i), next);
      unite(led_to_.of(i), led_to_.of(next));
    }
  }
}

void StartOrder::close_ends() {
  for (const int i : in_order_of_reasons()) std::ranges::copy(ended_at_start(i), ended_.of(i).begin());
}

/// The commands that a start needs: what its handlers speak of, and what is around it.
std::vector<int> StartOrder::reasons_of(int i) const {
  std::vector<int> reasons;
  if (tree_.at(i).parent >= 0) reasons.push_back(tree_.at(i).parent);
  for (const int h : tree_.acting_on(Effect::Kind::kStart, i)) {
    for (const expression::SubjectPtr& subject : expression::subjects_of(tree_.handler(h).handler->state.node()))
      if (const int of = tree_.find(subject); of >= 0) reasons.push_back(of);
  }
  return reasons;
}

/// Each command after its reasons, as far as those do not need it themselves.
std::vector<int> StartOrder::in_order_of_reasons() const {
  enum class Visit : std::uint8_t { kNone, kOpen, kDone };
  std::vector<int> order, open;
  std::vector<Visit> visits(static_cast<std::size_t>(tree_.size()), Visit::kNone);
  for (int root = 0; root < tree_.size(); ++root) {
    open.push_back(root);
    while (!open.empty()) {
      const int top = open.back();
      Visit& visit = visits[static_cast<std::size_t>(top)];
      if (visit == Visit::kNone) {
        visit = Visit::kOpen;
        for (const int reason : reasons_of(top))
          if (visits[static_cast<std::size_t>(reason)] == Visit::kNone) open.push_back(reason);
        continue;
      }
      open.pop_back();
      if (visit == Visit::kOpen) order.push_back(top);
      visit = Visit::kDone;
    }
  }
  return order;
}

/// Whatever starts it, and whatever is around it, started then or before.
StartOrder::Set StartOrder::ended_at_start(int i) const {
  std::optional<Set> ended;
  for (const int h : tree_.acting_on(Effect::Kind::kStart, i)) {
    const EventHandler& handler = *tree_.handler(h).handler;
    const Set by_this = handler.entered ? ended_when(handler.state.node()) : Set(ended_.words(), 0);
    if (ended) {
      intersect(*ended, by_this);
    } else {
      ended = by_this;
    }
  }
  // With its transaction: whatever handlers say besides, which the check refuses.
  if (!ended || tree_.at(i).with_parent) ended = Set(ended_.words(), 0);
  if (tree_.at(i).parent >= 0) unite(*ended, ended_.of(tree_.at(i).parent));
  return *ended;
}

/// The commands that have ended for certain when the state holds.
StartOrder::Set StartOrder::ended_when(const expression::ExpressionPtr& state) const {
  if (state->subject) return ended_by(*state);
  const std::string& type = state->primitive.type;
  const bool is_all = type == "And" || type == "OnDelay";
  Set ended(ended_.words(), 0);
  if ((!is_all && type != "Or") || state->inputs.empty()) return ended;
  ended = ended_when(state->inputs.front().second);
  for (std::size_t k = 1; k < state->inputs.size(); ++k) {
    const Set other = ended_when(state->inputs[k].second);
    is_all ? unite(ended, other) : intersect(ended, other);
  }
  return ended;
}

/// A state of a command says that it has started; some say that it has ended.
StartOrder::Set StartOrder::ended_by(const expression::Expression& leaf) const {
  Set ended(ended_.words(), 0);
  const int of = leaf.subject->kind == expression::Subject::Kind::kRaised ? -1 : tree_.find(leaf.subject);
  if (of < 0 || leaf.type != net::ValueType::kBoolean) return ended;
  unite(ended, ended_.of(of));
  if (leaf.output == "completed" || leaf.output == "timed_out") {
    for (int i = of; i < tree_.at(of).end; ++i) set_bit(ended, i);
  } else if (leaf.output == "stopped") {
    set_bit(ended, of);
  }
  return ended;
}

}  // namespace takt::command
