#include "core/net/implications.h"

#include <algorithm>
#include <bit>
#include <ranges>

namespace takt::net {

using Gate = ConditionGraph::Condition::Kind;

Implications::Implications(const FlatNet& flat, std::span<const int> primitives) : graph_(flat) {
  for (const int primitive : primitives) running_.push_back(graph_.running(primitive));
  order_ = graph_.in_order();
  seen_.assign(2 * graph_.conditions().size(), 0);
  for (std::size_t begin = 0; begin < running_.size(); begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, running_.size());
    solve(begin, end);
    for (std::size_t i = begin + 1; i < running_.size(); ++i) list_open(i, begin, end);
  }
  std::ranges::sort(open_, {}, [](const auto& pair) { return std::pair(pair.second, pair.first); });
}

std::span<Implications::Word> Implications::needing(int condition, bool value) {
  return std::span(sets_).subspan((2 * static_cast<std::size_t>(condition) + (value ? 1 : 0)) * words_, words_);
}

/// What each of these primitives needs. Operands come before what they are operands of.
void Implications::solve(std::size_t begin, std::size_t end) {
  words_ = (end - begin + kWordBits - 1) / kWordBits;
  sets_.assign(2 * graph_.conditions().size() * words_, 0);
  for (std::size_t c = 0; c < graph_.conditions().size(); ++c) {
    const Gate kind = graph_.conditions()[c].kind;
    if (kind == Gate::kTrue || kind == Gate::kFalse)
      std::ranges::fill(needing(static_cast<int>(c), kind == Gate::kTrue), ~Word{0});
  }
  for (std::size_t i = begin; i < end; ++i)
    needing(running_[i], true)[(i - begin) / kWordBits] |= Word{1} << (i - begin) % kWordBits;
  bool changed = true;
  for (int sweep = 0; changed && sweep < kMostSweeps; ++sweep) {
    changed = sweep_to_operands();
    changed = sweep_from_operands() || changed;
  }
}

bool Implications::add(int condition, bool value, std::span<const Word> primitives) {
  return add_common(condition, value, primitives, primitives);
}

/// Those in both sets need it.
bool Implications::add_common(int condition, bool value, std::span<const Word> a, std::span<const Word> b) {
  const std::span<Word> set = needing(condition, value);
  bool changed = false;
  for (std::size_t w = 0; w < words_; ++w) {
    const Word grown = set[w] | (a[w] & b[w]);
    changed = changed || grown != set[w];
    set[w] = grown;
  }
  return changed;
}

bool Implications::sweep_to_operands() {
  bool changed = false;
  for (const int c : order_ | std::views::reverse) {
    const auto [kind, a, b] = graph_.conditions()[static_cast<std::size_t>(c)];
    const std::span<const Word> yes = needing(c, true), no = needing(c, false);
    const auto both = [&](bool value, std::span<const Word> who) {
      changed = add(a, value, who) || changed;
      changed = add(b, value, who) || changed;
    };
    // One operand is as it has to be for the other value, so the other one decides.
    const auto other = [&](bool value, std::span<const Word> who) {
      changed = add_common(a, value, who, needing(b, !value)) || changed;
      changed = add_common(b, value, who, needing(a, !value)) || changed;
    };
    if (kind == Gate::kSame || kind == Gate::kNot) {
      changed = add(a, kind == Gate::kSame, yes) || changed;
      changed = add(a, kind != Gate::kSame, no) || changed;
    } else if (kind == Gate::kAnd) {
      both(true, yes);
      other(false, no);
    } else if (kind == Gate::kOr) {
      both(false, no);
      other(true, yes);
    } else if (kind == Gate::kWhile) {
      both(true, yes);
      changed = add(a, false, no) || changed;
      changed = add(b, true, no) || changed;
    } else if (kind == Gate::kActive) {
      both(true, yes);
    }
  }
  return changed;
}

bool Implications::sweep_from_operands() {
  bool changed = false;
  for (const int c : order_) {
    const auto [kind, a, b] = graph_.conditions()[static_cast<std::size_t>(c)];
    const auto either = [&](bool value) {
      changed = add(c, value, needing(a, value)) || changed;
      changed = add(c, value, needing(b, value)) || changed;
      changed = add_common(c, !value, needing(a, !value), needing(b, !value)) || changed;
    };
    if (kind == Gate::kSame || kind == Gate::kNot) {
      changed = add(c, kind == Gate::kSame, needing(a, true)) || changed;
      changed = add(c, kind != Gate::kSame, needing(a, false)) || changed;
    } else if (kind == Gate::kAnd || kind == Gate::kActive) {
      either(false);
    } else if (kind == Gate::kOr) {
      either(true);
    } else if (kind == Gate::kWhile) {
      changed = add_common(c, true, needing(a, true), needing(b, true)) || changed;
      changed = add_common(c, false, needing(a, false), needing(b, true)) || changed;
    }
  }
  return changed;
}

/// Those before the primitive that are propagated at present.
std::vector<Implications::Word> Implications::earlier(std::size_t primitive, std::size_t begin, std::size_t end) const {
  std::vector<Word> left(words_, 0);
  for (std::size_t i = begin; i < std::min(end, primitive); ++i)
    left[(i - begin) / kWordBits] |= Word{1} << (i - begin) % kWordBits;
  return left;
}

void Implications::list_open(std::size_t primitive, std::size_t begin, std::size_t end) {
  std::vector<Word> left = earlier(primitive, begin, end);
  exclude_by(primitive, left);
  for (std::size_t w = 0; w < words_; ++w) {
    for (Word rest = left[w]; rest != 0; rest &= rest - 1) {
      const std::size_t one = begin + w * kWordBits + static_cast<std::size_t>(std::countr_zero(rest));
      has_more_ = has_more_ || open_.size() == kMostOpen;
      if (has_more_) return;
      open_.emplace_back(one, primitive);
    }
  }
}

/// Takes out those that need the opposite of something that the primitive needs; nearest conditions first, until
/// nothing is left.
void Implications::exclude_by(std::size_t primitive, std::vector<Word>& left) {
  ++round_;
  queue_.clear();
  visit({running_[primitive], true});
  for (std::size_t head = 0; head < queue_.size(); ++head) {
    const Literal literal = queue_[head];
    const std::span<const Word> against = needing(literal.condition, !literal.value);
    bool any = false;
    for (std::size_t w = 0; w < words_; ++w) {
      left[w] &= ~against[w];
      any = any || left[w] != 0;
    }
    if (!any) return;
    follow(literal);
  }
}

void Implications::visit(const Literal& literal) {
  std::uint32_t& seen = seen_[2 * static_cast<std::size_t>(literal.condition) + (literal.value ? 1 : 0)];
  if (seen == round_) return;
  seen = round_;
  queue_.push_back(literal);
}

/// What has to hold for a condition to be as it is.
void Implications::follow(const Literal& literal) {
  const auto [kind, a, b] = graph_.conditions()[static_cast<std::size_t>(literal.condition)];
  const bool value = literal.value;
  if (kind == Gate::kSame || kind == Gate::kNot) {
    visit({a, kind == Gate::kSame ? value : !value});
  } else if (kind == Gate::kWhile) {
    visit({a, value});
    visit({b, true});
  } else if (value ? kind == Gate::kAnd || kind == Gate::kActive : kind == Gate::kOr) {
    visit({a, value});
    visit({b, value});
  }
}

}  // namespace takt::net
