#pragma once

#include <cstdint>
#include <vector>

#include "core/rcc/event_buffer.h"
#include "core/rcc/executor.h"
#include "core/rcc/rules.h"

namespace takt::rcc {

/// The requests and rules that wait, and the one pass over them in each cycle (row L2). Cycle thread only.
class RuleBook {
 public:
  static constexpr int kCapacity = 256;

  RuleBook(Executor& executor, EventBuffer& events);

  /// Takes a request or rule in. @return false if there is no room. Realtime: cyclic.
  bool add(RequestId id, const Rule& rule);

  /// One pass: all conditions are read on the same snapshot, then what holds is carried out, rules with aborts first,
  /// then those with cancels, then the rest, each in the order of posting. A rule whose condition can never hold any
  /// more, since a net in it has ended or is not known, is dropped and told as refused. Realtime: cyclic.
  void apply(std::int64_t cycle);

 private:
  struct Entry {
    RequestId id = 0;
    Rule rule;
    bool fires = false;
    NetId hopeless = 0;  ///< the net because of which it can never fire; 0: it may
  };
  [[nodiscard]] bool holds(const Condition& condition) const;
  [[nodiscard]] bool holds(const Term& term) const;
  /// A net of the condition that has come to its end without what is asked of it; 0: none.
  [[nodiscard]] NetId hopeless_net(const Condition& condition) const;
  void give_up(const Entry& entry, std::int64_t cycle);
  void carry_out(const Entry& entry, std::int64_t cycle);

  Executor& executor_;
  EventBuffer& events_;
  std::vector<Entry> entries_;
};

}  // namespace takt::rcc
