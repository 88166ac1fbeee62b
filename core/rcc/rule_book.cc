#include "core/rcc/rule_book.h"

#include <algorithm>

namespace takt::rcc {

namespace {

/// Abort over cancel over start.
int rank(const Transaction& transaction) {
  if (transaction.abort.size > 0) return 0;
  return transaction.cancel.size > 0 ? 1 : 2;
}

}  // namespace

RuleBook::RuleBook(Executor& executor, EventBuffer& events) : executor_(executor), events_(events) {
  entries_.reserve(kCapacity);
}

bool RuleBook::add(RequestId id, const Rule& rule) {
  if (entries_.size() == kCapacity) return false;
  entries_.push_back({.id = id, .rule = rule});
  return true;
}

bool RuleBook::holds(const Term& term) const {
  const NetEntry* entry = executor_.find(term.net);
  if (entry == nullptr) return false;
  const NetState state = entry->state.load(std::memory_order_acquire);
  if (term.states != 0) return ((term.states >> static_cast<unsigned>(state)) & 1u) != 0;
  const bool evaluated = entry->net != nullptr && entry->net->cycles() > 0;
  return term.port != nullptr && evaluated && term.port->null == 0 && term.port->value;
}

bool RuleBook::holds(const Condition& condition) const {
  for (int i = 0; i < condition.size; ++i)
    if (!holds(condition.terms[static_cast<std::size_t>(i)])) return false;
  return true;
}

void RuleBook::apply(std::int64_t cycle) {
  bool any = false;
  for (Entry& entry : entries_) any |= entry.fires = holds(entry.rule.condition);
  if (!any) return;
  for (int turn = 0; turn < 3; ++turn)
    for (const Entry& entry : entries_)
      if (entry.fires && rank(entry.rule.action) == turn) carry_out(entry, cycle);
  std::erase_if(entries_, [](const Entry& entry) { return entry.fires; });
}

void RuleBook::carry_out(const Entry& entry, std::int64_t cycle) {
  Event event{.kind = Event::Kind::kDone, .state = {}, .net = 0, .request = entry.id, .cause = {}};
  event.cause.cycle = cycle;
  if (const auto refusal = executor_.check(entry.rule.action)) {
    event.kind = Event::Kind::kRefused;
    event.net = refusal->net;
    event.cause.code = net::Cause::Code::kConflict;
    event.cause.text = refusal->text;
  } else {
    executor_.carry_out(entry.rule.action, cycle);
  }
  events_.add(event);
}

}  // namespace takt::rcc
