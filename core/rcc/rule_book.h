#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/rcc/event_buffer.h"
#include "core/rcc/executor.h"
#include "core/rcc/rules.h"

namespace takt::rcc {

/// The requests and rules that wait, and the one pass over them in each cycle (row L2). Cycle thread only.
class RuleBook {
 public:
  static constexpr std::size_t kMostWaiting = 256;
  /// Requests without a condition are carried out in the cycle that takes them in; rules that wait leave this room.
  static constexpr std::size_t kMostRequests = 512;

  RuleBook(Executor& executor, EventBuffer& events);

  /// Takes a request or rule in. @return false if there is no room: kMostWaiting rules wait. Realtime: cyclic.
  [[nodiscard]] bool add(RequestId id, const Rule& rule);

  /// One pass: all conditions are read on the same snapshot, then aborts that nothing can refuse are carried out
  /// (Executor::abort_asked), then what holds, rules with aborts first,
  /// then those with cancels, then the rest, each in the order of posting. A cancel of a net whose start was posted
  /// before and is carried out now, or waits for a device, comes after the starts: it finds the net in its first cycle,
  /// or takes the start back. A rule whose condition can never hold any
  /// more, since a net in it has ended or is not known, is dropped and told as refused. Realtime: cyclic.
  void apply(std::int64_t cycle);

 private:
  struct Entry {
    RequestId id = 0;
    Rule rule;
    bool fires = false, over = false;
    int turn = -1;
    NetId hopeless = 0;  ///< the net because of which it can never fire; 0: it may
    /// Cycle from which the other transaction waits for rest: the action was refused, and the nets that the rule is
    /// about have ended.
    std::int64_t refused_in = -1;
    std::int64_t later_since = -1;  ///< cycle since which it waits for devices that change their state
    net::Text refusal = {};         ///< why
  };
  [[nodiscard]] bool holds(const Condition& condition) const;
  [[nodiscard]] bool holds(const Term& term) const;
  /// A net of the condition that has come to its end without what is asked of it; 0: none.
  [[nodiscard]] NetId hopeless_net(const Condition& condition) const;
  /// The turn in which an entry that fires is carried out.
  [[nodiscard]] int turn_of(std::size_t entry) const;
  /// The start of the net was posted before this entry and has not been carried out; -1: there is none.
  [[nodiscard]] int start_before(std::size_t entry, NetId net) const;
  /// Takes back the starts that wait for a device and whose nets are cancelled. @return false if nothing is left to do.
  bool take_back_starts(std::size_t entry, std::int64_t cycle);
  /// True if the entry is to be looked at in this cycle.
  [[nodiscard]] bool is_due(const Entry& entry, std::int64_t cycle) const;
  /// A net of the condition, or one that the rule was to end, is still active.
  [[nodiscard]] bool waits_for_end(const Rule& rule) const;
  [[nodiscard]] bool is_active_net(NetId net) const;
  /// The action can never be: the other transaction's turn. @return false if the entry stays, to wait for rest.
  bool give_up(Entry& entry, std::int64_t cycle);
  bool try_otherwise(Entry& entry, const net::Text& refusal, std::int64_t cycle);
  /// @return false if the entry stays, to wait for rest.
  bool carry_out(Entry& entry, std::int64_t cycle);

  Executor& executor_;
  EventBuffer& events_;
  std::vector<Entry> entries_;
};

}  // namespace takt::rcc
