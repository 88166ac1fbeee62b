#include "core/rcc/executor.h"

#include <algorithm>
#include <cassert>

#include "core/net/format_text.h"

namespace takt::rcc {

namespace {

using net::format_text;

bool holds(const net::Slot<net::Boolean>* flag) { return flag != nullptr && flag->null == 0 && flag->value; }

net::Cause cause_of(net::Cause::Code code, const net::Text& text, std::int64_t cycle) {
  return {.code = code, .text = text, .cycle = cycle};
}

}  // namespace

Executor::Executor(NetTable& nets, ResourceTable& resources, EventBuffer& events, int capacity)
    : nets_(nets), resources_(resources), events_(events) {
  active_.reserve(static_cast<std::size_t>(capacity));
}

void Executor::evaluate(const net::Cycle& cycle) {
  cycle_ = cycle.index;
  for (NetEntry* entry : active_) {
    net::Cycle own = cycle;
    own.cancel_requested = entry->cancel_cycle >= 0;
    own.stop_requested = entry->stop_cycle >= 0;
    current_.store(entry->id, std::memory_order_relaxed);
    entry->net->evaluate(own);
  }
  current_.store(0, std::memory_order_relaxed);
}

void Executor::end_finished(std::int64_t cycle) {
  for (NetEntry* entry : active_) {
    const net::NetSignals& signals = entry->net->signals();
    const bool canceling = entry->state.load(std::memory_order_relaxed) == NetState::kCanceling;
    if (canceling && holds(entry->goes_on)) entry->cancel_counts_from = cycle;
    if (entry->stop_cycle >= 0) {
      go_on_stopping(*entry, cycle);
    } else if (signals.fail) {
      abort(*entry, signals.cause, cycle);
    } else if (const device::Actuator* lost = lost_actuator(*entry)) {
      abort(*entry, cause_of_loss(*lost, cycle), cycle);
    } else if (signals.terminate) {
      const bool early = canceling || holds(entry->stopped);
      const auto code = early ? net::Cause::Code::kCancelled : net::Cause::Code::kTerminated;
      end(*entry, cause_of(code, signals.cause.text, cycle), cycle);
    } else if (canceling && cycle - entry->cancel_counts_from >= entry->cancel_bound_cycles) {
      const auto why = format_text("did not end within {} cycles of its cancel", entry->cancel_bound_cycles);
      abort(*entry, cause_of(net::Cause::Code::kAborted, why, cycle), cycle);
    }
  }
  forget_ended();
}

const device::Actuator* Executor::lost_actuator(const NetEntry& entry) const {
  for (const int place : entry.claims) {
    const device::Actuator* actuator = resources_[place].actuator;
    if (actuator != nullptr && actuator->lost()) return actuator;
  }
  return nullptr;
}

/// A device that is lost in an emergency was stopped by it: the latch is the cause, the device says what it did.
net::Cause Executor::cause_of_loss(const device::Actuator& lost, std::int64_t cycle) const {
  const bool by_latch = emergency_ && lost.stops_in_emergency();
  const net::Text text = by_latch ? format_text("{}; {}", emergency_->view(), lost.fault().view()) : lost.fault();
  return cause_of(net::Cause::Code::kDevice, text, cycle);
}

void Executor::move_to(NetEntry& entry, NetState state) {
  assert(is_legal(entry.state.load(std::memory_order_relaxed), state));
  entry.state.store(state, std::memory_order_release);
  events_.state(entry.id, state, entry.cause);
}

void Executor::end(NetEntry& entry, const net::Cause& cause, std::int64_t cycle) {
  entry.cause = cause;
  entry.last_cycle.store(cycle, std::memory_order_relaxed);
  for (const int place : entry.claims) {
    auto& held = resources_[place];
    held.owner = 0;
    if (held.actuator != nullptr && held.actuator->held()) held.actuator->release();
  }
  load_ns_.store(load_ns() - entry.cost_ns, std::memory_order_relaxed);
  move_to(entry, NetState::kTerminated);
}

void Executor::abort(NetEntry& entry, const net::Cause& cause, std::int64_t cycle) {
  for (const int place : entry.claims) {
    if (resources_[place].channel != nullptr) resources_[place].channel->drop();
    device::Actuator* actuator = resources_[place].actuator;
    if (actuator == nullptr) continue;
    const bool moving = actuator->held() && !actuator->at_rest();
    actuator->stop();
    if (!moving) continue;
    const auto what = cause_of(cause.code, format_text("{}: stop reaction", actuator->name()), cycle);
    events_.add({.kind = Event::Kind::kStopped, .state = {}, .net = entry.id, .request = 0, .cause = what});
  }
  end(entry, cause, cycle);
}

void Executor::abort_asked(std::int64_t cycle) {
  nets_.take_aborts([&](NetEntry& entry) {
    entry.abort_cycle = cycle;
    if (is_active(entry.state.load(std::memory_order_relaxed)))
      abort(entry, cause_of(net::Cause::Code::kAborted, format_text("abort was asked for"), cycle), cycle);
  });
  forget_ended();
}

bool Executor::stops_in_emergency(const NetEntry& entry) const {
  return std::ranges::any_of(entry.claims, [this](int place) {
    const device::Actuator* actuator = resources_[place].actuator;
    return actuator != nullptr && actuator->stops_in_emergency();
  });
}

void Executor::stop_where_lost(std::int64_t cycle) {
  for (NetEntry* entry : active_) {
    const device::Actuator* lost = lost_actuator(*entry);
    if (lost != nullptr) begin_stop(*entry, cause_of_loss(*lost, cycle), cycle);
  }
}

void Executor::stop_on_path(const net::Cause& cause, std::int64_t cycle) {
  for (NetEntry* entry : active_)
    if (stops_in_emergency(*entry)) begin_stop(*entry, cause, cycle);
}

void Executor::begin_stop(NetEntry& entry, const net::Cause& cause, std::int64_t cycle) {
  const bool can =
      std::ranges::any_of(entry.on_path, [this](int place) { return !resources_[place].actuator->lost(); });
  if (!can || entry.stop_cycle >= 0) return;
  entry.stop_cycle = cycle;
  entry.stop_cause = cause;
  if (entry.state.load(std::memory_order_relaxed) == NetState::kCanceling) return;
  entry.state.store(NetState::kCanceling, std::memory_order_release);
  events_.state(entry.id, NetState::kCanceling, cause);
}

/// What is not on a path stops at once; what is follows the net until it rests.
void Executor::go_on_stopping(NetEntry& entry, std::int64_t cycle) {
  bool rests = true;
  for (const int place : entry.claims) {
    device::Actuator* actuator = resources_[place].actuator;
    if (actuator == nullptr) continue;
    const bool follows = !actuator->lost() && std::ranges::count(entry.on_path, place) > 0;
    if (!follows && actuator->held()) actuator->stop();
    rests = rests && (!follows || actuator->will_rest());
  }
  if (entry.net->signals().fail || cycle - entry.stop_cycle >= entry.stop_bound_cycles) {
    abort(entry, entry.stop_cause, cycle);
  } else if (rests || entry.net->signals().terminate) {
    end(entry, entry.stop_cause, cycle);
  }
}

void Executor::stop_for_emergency(const net::Cause& cause, bool those_on_path, std::int64_t cycle) {
  stopped_by_ = cause.text;
  for (NetEntry* entry : active_)
    if (stops_in_emergency(*entry) && (those_on_path || entry->stop_cycle < 0)) abort(*entry, cause, cycle);
  forget_ended();
}

void Executor::stop_all(const net::Cause& cause, std::int64_t cycle) {
  stopped_by_ = cause.text;
  for (NetEntry* entry : active_) abort(*entry, cause, cycle);
  forget_ended();
}

void Executor::forget_ended() {
  std::erase_if(active_,
                [](const NetEntry* entry) { return !is_active(entry->state.load(std::memory_order_relaxed)); });
}

void Executor::start(NetEntry& entry, std::int64_t cycle) {
  entry.first_cycle.store(cycle + 1, std::memory_order_relaxed);
  for (const auto& [place, state] : entry.needs) resources_[place].actuator->enter(state);
  for (const int place : entry.claims) {
    resources_[place].owner = entry.id;
    if (resources_[place].actuator != nullptr) resources_[place].actuator->hold();
  }
  const auto by_number = [](const NetEntry* a, const NetEntry* b) { return a->id < b->id; };
  active_.insert(std::upper_bound(active_.begin(), active_.end(), &entry, by_number), &entry);
  load_ns_.store(load_ns() + entry.cost_ns, std::memory_order_relaxed);
  move_to(entry, NetState::kRunning);
}

std::optional<net::Text> Executor::refuse_end(const NetEntry& entry, const Transaction& transaction) const {
  const auto is_taken = [&](int place) {
    return std::ranges::any_of(transaction.start, [&](NetId id) {
      const NetEntry* successor = nets_.find(id);
      return successor != nullptr && std::ranges::count(successor->claims, place) > 0;
    });
  };
  if (entry.stop_cycle >= 0) return format_text("net {} is stopping", entry.id);
  for (const int place : entry.claims) {
    const device::Actuator* actuator = resources_[place].actuator;
    if (actuator != nullptr && !actuator->will_rest() && !is_taken(place))
      return format_text("{} would move on, and no net takes it over", actuator->name());
  }
  return std::nullopt;
}

device::StateAnswer Executor::answer_of(const device::Actuator& actuator, const NetEntry& entry, int place) {
  const auto need = std::ranges::find(entry.needs, place, &NetEntry::NeededState::place);
  return actuator.answer(need == entry.needs.end() ? std::string_view{} : need->state);
}

std::optional<Executor::Refusal> Executor::refuse_start(const NetEntry& entry, const Transaction& transaction) const {
  const auto refused = [&entry](const net::Text& why) { return Refusal{.net = entry.id, .text = why}; };
  if (stopped_by_) return refused(format_text("stopped by {}", stopped_by_->view()));
  if (entry.abort_cycle == cycle_) return refused(format_text("an abort of net {} was asked for", entry.id));
  if (active_.size() == active_.capacity()) return refused(format_text("too many nets are running"));
  std::optional<Refusal> later;
  for (const int place : entry.claims) {
    const auto& wanted = resources_[place];
    const bool freed = wanted.owner != 0 && transaction.abort.contains(wanted.owner);
    const bool taken_over = wanted.owner != 0 && transaction.end.contains(wanted.owner);
    if (wanted.owner != 0 && !freed && !taken_over)
      return refused(format_text("{} is held by net {}", wanted.name, wanted.owner));
    if (wanted.actuator == nullptr) continue;
    if (freed && !wanted.actuator->at_rest())
      return refused(format_text("{} moves; its abort leaves it braking", wanted.actuator->name()));
    const device::StateAnswer answer = answer_of(*wanted.actuator, entry, place);
    if (answer.kind == device::StateAnswer::Kind::kRefused) return refused(answer.why);
    if (answer.kind == device::StateAnswer::Kind::kLater) {
      later = Refusal{.net = entry.id, .text = answer.why, .later = true};
    } else if (const auto why = wanted.actuator->refusal()) {
      return refused(*why);
    }
  }
  if (later) return later;
  if (const auto why = refuse_seam(entry)) return refused(*why);
  // Two nets of one transaction may not want the same thing.
  for (const NetId other : transaction.start) {
    if (other == entry.id) break;
    const NetEntry* before = nets_.find(other);
    for (const int place : entry.claims)
      if (before != nullptr && std::count(before->claims.begin(), before->claims.end(), place) > 0)
        return refused(format_text("net {} of the same start wants the same device", other));
  }
  return std::nullopt;
}

std::optional<Executor::Refusal> Executor::refuse_cost(const Transaction& transaction) const {
  if (budget_ns_ <= 0.0) return std::nullopt;
  double load = load_ns();
  for (const NetEntry* entry : active_)
    if (transaction.abort.contains(entry->id) || transaction.end.contains(entry->id)) load -= entry->cost_ns;
  for (const NetId* one = transaction.start.begin(); one != transaction.start.end(); ++one) {
    const NetEntry& entry = *nets_.find(*one);
    const bool runs = is_active(entry.state.load(std::memory_order_acquire));
    if (runs || std::count(transaction.start.begin(), one, *one) > 0) continue;  // its cost is in the sum already
    load += entry.cost_ns;
    if (load > budget_ns_)
      return Refusal{
          .net = *one,
          .text = format_text("{:.1f} us a cycle with it, but the budget is {:.1f}", 1e-3 * load, 1e-3 * budget_ns_)};
  }
  return std::nullopt;
}

/// A net that the transaction starts and ends at once, in whichever way.
std::optional<Executor::Refusal> Executor::refuse_contradiction(const Transaction& transaction) {
  const auto both = [](NetId id, std::string_view what) {
    return Refusal{.net = id, .text = format_text("net {} is to be started and {} at once", id, what)};
  };
  for (const NetId id : transaction.start) {
    if (transaction.abort.contains(id)) return both(id, "aborted");
    if (transaction.cancel.contains(id)) return both(id, "cancelled");
    if (transaction.end.contains(id)) return both(id, "ended");
  }
  return std::nullopt;
}

void Executor::prepare(const Transaction& transaction) {
  for (const NetId id : transaction.start) {
    const NetEntry* entry = nets_.find(id);
    if (entry == nullptr || entry->state.load(std::memory_order_acquire) != NetState::kReady) continue;
    for (const auto& [place, state] : entry->needs) {
      device::Actuator& actuator = *resources_[place].actuator;
      if (actuator.answer(state).kind == device::StateAnswer::Kind::kLater) actuator.enter(state);
    }
  }
}

std::optional<net::Text> Executor::refuse_seam(const NetEntry& entry) const {
  for (const auto& [place, begin] : entry.begins) {
    const device::Actuator& actuator = *resources_[place].actuator;
    const auto why = actuator.seam_mismatch(actuator.seam(), begin);
    const auto fits = [&](const NetEntry::DeclaredSeam& other) {
      return other.place == place && !actuator.seam_mismatch(actuator.seam(), other.seam);
    };
    if (why && std::ranges::none_of(entry.begins, fits)) return why;
  }
  return std::nullopt;
}

bool Executor::can_rest(const Transaction& transaction) const {
  for (const NetId id : transaction.start) {
    const NetEntry* entry = nets_.find(id);
    if (entry == nullptr) continue;
    for (const int place : entry->claims) {
      const auto& wanted = resources_[place];
      if (wanted.owner != 0) return false;
      if (wanted.actuator != nullptr && (!wanted.actuator->will_rest() || wanted.actuator->refusal())) return false;
    }
  }
  return true;
}

std::optional<Executor::Refusal> Executor::check(const Transaction& transaction) const {
  for (const NetSet* set : {&transaction.abort, &transaction.cancel, &transaction.end, &transaction.start})
    for (const NetId id : *set)
      if (nets_.find(id) == nullptr) return Refusal{.net = id, .text = format_text("net {} is not loaded", id)};
  if (auto contradiction = refuse_contradiction(transaction)) return contradiction;
  const auto state_of = [this](NetId id) { return nets_.find(id)->state.load(std::memory_order_acquire); };
  for (const NetSet* set : {&transaction.abort, &transaction.cancel, &transaction.end})
    for (const NetId id : *set)
      if (!is_active(state_of(id)) && state_of(id) != NetState::kTerminated)
        return Refusal{.net = id, .text = format_text("net {} is not running, it is {}", id, name_of(state_of(id)))};
  for (const NetId id : transaction.end) {
    if (!is_active(state_of(id))) continue;
    if (const auto why = refuse_end(*nets_.find(id), transaction)) return Refusal{.net = id, .text = *why};
  }
  std::optional<Refusal> later;
  for (const NetId id : transaction.start) {
    const NetState state = state_of(id);
    if (is_active(state)) continue;
    if (state != NetState::kReady)
      return Refusal{.net = id, .text = format_text("net {} is not Ready, it is {}", id, name_of(state))};
    const auto refusal = refuse_start(*nets_.find(id), transaction);
    if (refusal && !refusal->later) return refusal;
    if (refusal) later = refusal;
  }
  return later ? later : refuse_cost(transaction);
}

void Executor::carry_out(const Transaction& transaction, std::int64_t cycle) {
  for (const NetId id : transaction.abort) {
    NetEntry& entry = *nets_.find(id);
    if (is_active(entry.state.load(std::memory_order_relaxed)))
      abort(entry, cause_of(net::Cause::Code::kAborted, format_text("abort was asked for"), cycle), cycle);
  }
  forget_ended();
  for (const NetId id : transaction.cancel) {
    NetEntry& entry = *nets_.find(id);
    if (entry.state.load(std::memory_order_relaxed) != NetState::kRunning) continue;
    entry.cancel_cycle = entry.cancel_counts_from = cycle;
    move_to(entry, NetState::kCanceling);
  }
  for (const NetId id : transaction.end) {
    NetEntry& entry = *nets_.find(id);
    if (is_active(entry.state.load(std::memory_order_relaxed)))
      end(entry, cause_of(net::Cause::Code::kTakenOver, {}, cycle), cycle);
  }
  forget_ended();
  for (const NetId id : transaction.start) {
    NetEntry& entry = *nets_.find(id);
    if (entry.state.load(std::memory_order_relaxed) == NetState::kReady) start(entry, cycle);
  }
}

}  // namespace takt::rcc
