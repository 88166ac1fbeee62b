#include "core/rcc/rule_book.h"

#include <algorithm>
#include <span>

namespace takt::rcc {

namespace {

/// Abort over cancel over start.
int rank(const Transaction& transaction) {
  if (transaction.abort.size > 0) return 0;
  return transaction.cancel.size > 0 ? 1 : 2;
}

constexpr int kLastTurn = 3;  ///< of cancels that come after the starts that they are about

/// A net never leaves these.
bool is_final(NetState state) { return state == NetState::kRejected || state == NetState::kTerminated; }

}  // namespace

RuleBook::RuleBook(Executor& executor, EventBuffer& events) : executor_(executor), events_(events) {
  entries_.reserve(kMostWaiting + kMostRequests);
}

bool RuleBook::add(RequestId id, const Rule& rule) {
  const bool waits = rule.condition.size > 0;
  if (entries_.size() >= kMostWaiting + (waits ? 0 : kMostRequests)) return false;
  entries_.push_back({.id = id, .rule = rule});
  return true;
}

bool RuleBook::holds(const Term& term) const {
  const NetEntry* entry = executor_.find(term.net);
  if (entry == nullptr) return false;
  const NetState state = entry->state.load(std::memory_order_acquire);
  if (term.states != 0) return ((term.states >> static_cast<unsigned>(state)) & 1u) != 0;
  const bool compiled = state != NetState::kLoading && entry->net != nullptr;
  if (!compiled || entry->net->cycles() == 0) return false;
  if (term.port != nullptr) return term.port->null == 0 && term.port->value;
  return term.real != nullptr && term.real->null == 0 && term.real->value >= term.lower &&
         term.real->value <= term.upper;
}

bool RuleBook::holds(const Condition& condition) const {
  for (int i = 0; i < condition.size; ++i)
    if (!holds(condition.terms[static_cast<std::size_t>(i)])) return false;
  return true;
}

NetId RuleBook::hopeless_net(const Condition& condition) const {
  for (int i = 0; i < condition.size; ++i) {
    const Term& term = condition.terms[static_cast<std::size_t>(i)];
    const NetEntry* entry = executor_.find(term.net);
    const bool final = entry == nullptr || is_final(entry->state.load(std::memory_order_acquire));
    if (final && !holds(term)) return term.net;
  }
  return 0;
}

void RuleBook::apply(std::int64_t cycle) {
  bool any = false;
  for (Entry& entry : entries_) {
    entry.fires = is_due(entry, cycle);
    const bool waits_for_rest = entry.refused_in >= 0;
    if (waits_for_rest && waits_for_end(entry.rule)) entry.refused_in = cycle;
    const bool waits = waits_for_rest || entry.later_since >= 0;
    entry.hopeless = entry.fires || waits ? 0 : hopeless_net(entry.rule.condition);
    any = any || entry.fires || entry.hopeless != 0;
  }
  executor_.abort_asked(cycle);
  if (!any) return;
  for (Entry& entry : entries_) entry.turn = -1;
  for (std::size_t i = 0; i < entries_.size(); ++i)
    if (entries_[i].fires) entries_[i].turn = turn_of(i);
  for (int turn = 0; turn <= kLastTurn; ++turn) {
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      Entry& entry = entries_[i];
      if (entry.turn != turn) continue;
      entry.over = turn == kLastTurn && !take_back_starts(i, cycle) ? true : carry_out(entry, cycle);
    }
  }
  for (Entry& entry : entries_)
    if (entry.hopeless != 0) entry.over = give_up(entry, cycle);
  std::erase_if(entries_, [](const Entry& entry) { return entry.over; });
}

int RuleBook::turn_of(std::size_t entry) const {
  const Transaction& action = entries_[entry].rule.action;
  const int own = rank(action);
  const bool is_later = std::ranges::any_of(action.cancel, [&](NetId id) { return start_before(entry, id) >= 0; });
  return own == 1 && is_later ? kLastTurn : own;
}

int RuleBook::start_before(std::size_t entry, NetId net) const {
  for (std::size_t i = 0; i < entry; ++i) {
    const Entry& one = entries_[i];
    if (!one.over && one.fires && one.rule.action.start.contains(net)) return static_cast<int>(i);
  }
  return -1;
}

bool RuleBook::take_back_starts(std::size_t entry, std::int64_t cycle) {
  Transaction& action = entries_[entry].rule.action;
  NetSet left;
  for (const NetId id : action.cancel) {
    const int start = start_before(entry, id);
    if (start < 0 || is_active_net(id)) {
      (void)left.add(id);
      continue;
    }
    Entry& waiting = entries_[static_cast<std::size_t>(start)];
    waiting.over = true;
    Event refused{.kind = Event::Kind::kRefused, .state = {}, .net = id, .request = waiting.id, .cause = {}};
    refused.cause = {
        .code = net::Cause::Code::kCancelled, .text = net::Text("cancelled before it began"), .cycle = cycle};
    events_.add(refused);
  }
  action.cancel = left;
  if (!action.empty()) return true;
  Event done{.kind = Event::Kind::kDone, .state = {}, .net = 0, .request = entries_[entry].id, .cause = {}};
  done.cause.cycle = cycle;
  events_.add(done);
  return false;
}

bool RuleBook::is_active_net(NetId id) const {
  const NetEntry* entry = executor_.find(id);
  return entry != nullptr && is_active(entry->state.load(std::memory_order_acquire));
}

bool RuleBook::waits_for_end(const Rule& rule) const {
  const auto terms = std::span(rule.condition.terms).first(static_cast<std::size_t>(rule.condition.size));
  return std::ranges::any_of(terms, [this](const Term& term) { return is_active_net(term.net); }) ||
         std::ranges::any_of(rule.action.end, [this](NetId id) { return is_active_net(id); });
}

bool RuleBook::give_up(Entry& entry, std::int64_t cycle) {
  const net::Text why("its condition can never hold");
  if (!entry.rule.otherwise.empty()) return try_otherwise(entry, why, cycle);
  Event event{.kind = Event::Kind::kRefused, .state = {}, .net = entry.hopeless, .request = entry.id, .cause = {}};
  event.cause = {.code = net::Cause::Code::kConflict, .text = why, .cycle = cycle};
  events_.add(event);
  return true;
}

bool RuleBook::try_otherwise(Entry& entry, const net::Text& refusal, std::int64_t cycle) {
  entry.refused_in = cycle;
  entry.refusal = refusal;
  return executor_.can_rest(entry.rule.otherwise) && carry_out(entry, cycle);
}

bool RuleBook::is_due(const Entry& entry, std::int64_t cycle) const {
  if (entry.later_since >= 0) return true;
  if (entry.refused_in < 0) return holds(entry.rule.condition);
  return executor_.can_rest(entry.rule.otherwise) || cycle - entry.refused_in >= Rule::kAnswerTimeout;
}

bool RuleBook::carry_out(Entry& entry, std::int64_t cycle) {
  Event event{.kind = Event::Kind::kDone, .state = {}, .net = 0, .request = entry.id, .cause = {}};
  event.cause.cycle = cycle;
  event.cause.text = entry.refusal;
  const bool second = entry.refused_in >= 0;
  const Transaction& transaction = second ? entry.rule.otherwise : entry.rule.action;
  const auto refusal = executor_.check(transaction);
  // What is to be taken over in motion cannot change its state before.
  const bool may_wait = refusal && refusal->later && transaction.end.size == 0;
  if (!refusal) {
    executor_.carry_out(transaction, cycle);
  } else if (may_wait && (entry.later_since < 0 || cycle - entry.later_since < Rule::kAnswerTimeout)) {
    if (entry.later_since < 0) entry.later_since = cycle;
    executor_.prepare(transaction);
    return false;
  } else if (!second && !entry.rule.otherwise.empty()) {
    entry.later_since = -1;
    return try_otherwise(entry, refusal->text, cycle);
  } else {
    event.kind = Event::Kind::kRefused;
    event.net = refusal->net;
    event.cause.code = net::Cause::Code::kConflict;
    event.cause.text = refusal->text;
  }
  events_.add(event);
  return true;
}

}  // namespace takt::rcc
