#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/command/mapping.h"
#include "core/net/compiled_net.h"

namespace takt::activity {

/// What was in the net in one cycle, as text: names and values of what matters.
struct TracedCycle {
  std::int64_t cycle = -1;
  std::vector<std::pair<std::string, std::string>> values;
};

/// The last cycles of one net: states of commands, set points, states of events. Kept as bytes; text is made only
/// on request. Thread: the program's, between cycles. Realtime: setup; note() allocates nothing.
class RunTrace {
 public:
  static constexpr std::size_t kCycles = 16;
  static constexpr std::size_t kMostPorts = 24;

  /// Once, after LOAD. The net must live as long as note() is called.
  void attach(const net::CompiledNet& net, const std::vector<command::TracedPort>& ports);
  /// After a cycle in which the net was evaluated; each cycle counts once.
  void note(std::int64_t cycle);
  /// Oldest first.
  [[nodiscard]] std::vector<TracedCycle> cycles() const;

 private:
  struct Port {
    std::string name;
    net::ValueType type;
    std::size_t offset, size;  ///< in the slots of the net
    std::size_t at;            ///< in a row of the trace
  };
  const net::CompiledNet* net_ = nullptr;
  std::vector<Port> ports_;
  std::size_t row_bytes_ = 0;
  std::vector<std::byte> rows_;  ///< kCycles rows; each value is aligned as operator new aligns
  std::array<std::int64_t, kCycles> noted_{};
  std::size_t count_ = 0;  ///< of all that were noted
};

}  // namespace takt::activity
