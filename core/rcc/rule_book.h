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
  /// then those with cancels, then the rest, each in the order of posting. Realtime: cyclic.
  void apply(std::int64_t cycle);

 private:
  struct Entry {
    RequestId id = 0;
    Rule rule;
    bool fires = false;
  };
  [[nodiscard]] bool holds(const Condition& condition) const;
  [[nodiscard]] bool holds(const Term& term) const;
  void carry_out(const Entry& entry, std::int64_t cycle);

  Executor& executor_;
  EventBuffer& events_;
  std::vector<Entry> entries_;
};

}  // namespace takt::rcc
