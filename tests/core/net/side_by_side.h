#pragma once

#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/net/compiled_net.h"
#include "core/net/value_json.h"
#include "tests/core/net/reference_net.h"

namespace takt::net {

/// Runs a compiled net and the plain reading of its description side by side and compares, after every cycle, every
/// byte of every output (null flags and padding included) and whether the net asks to end.
class SideBySide {
 public:
  /// Both must live as long as this.
  SideBySide(CompiledNet& compiled, ReferenceNet& reference) : compiled_(compiled), reference_(reference) {
    for (ReferenceNet::Output& output : reference.output_slots()) {
      const void* slot = compiled.find_slot(output.port, output.type);
      const std::size_t size = visit_type(output.type, []<class T>(std::type_identity<T>) { return sizeof(Slot<T>); });
      pairs_.push_back({std::move(output), slot, size});
    }
  }

  /// Runs cycles until something differs. @return what, where and when; empty: equal in all cycles.
  [[nodiscard]] std::string first_difference(int cycles, std::int64_t first_cycle = 100) {
    for (std::int64_t index = first_cycle; index < first_cycle + cycles; ++index) {
      Cycle cycle;
      cycle.index = index;
      cycle.time = index * cycle.period;
      compiled_.evaluate(cycle);
      reference_.evaluate(cycle);
      if (compiled_.signals().terminate != reference_.signals().terminate) {
        return fmt::format("cycle {}: only one of both asks to end", index - first_cycle);
      }
      for (const Pair& pair : pairs_) {
        count(pair);
        if (pair.compiled != nullptr && std::memcmp(pair.compiled, pair.reference.slot, pair.size) == 0) continue;
        return fmt::format("cycle {}: {} is {}, wanted {}", index - first_cycle, pair.reference.port,
                           text(pair.reference.type, pair.compiled), text(pair.reference.type, pair.reference.slot));
      }
    }
    return {};
  }

  std::int64_t nulls = 0, values = 0;  ///< compared so far

 private:
  struct Pair {
    ReferenceNet::Output reference;
    const void* compiled;
    std::size_t size;
  };

  void count(const Pair& pair) {
    visit_type(pair.reference.type, [&]<class T>(std::type_identity<T>) {
      ++(static_cast<const Slot<T>*>(pair.reference.slot)->null != 0 ? nulls : values);
    });
  }
  static std::string text(ValueType type, const void* slot) {
    return slot == nullptr ? "not there" : slot_to_json(type, slot).dump();
  }

  CompiledNet& compiled_;
  ReferenceNet& reference_;
  std::vector<Pair> pairs_;
};

}  // namespace takt::net
