#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/net/compiled_net.h"

namespace takt::tools {

/// Times of one thing in ns, what it costs to look at the clock taken off. Percentiles are over single cycles; the mean
/// leaves the slowest hundredth out.
struct Times {
  double mean = 0, p50 = 0, p99 = 0, largest = 0;
};

/// What a net costs on this machine.
struct NetBench {
  struct Primitive {
    std::string id, type;
    Times ns;
    double share = 0;  ///< of the sum over all primitives
  };
  std::string processor;
  std::int64_t cycles = 0;       ///< that were measured, all together
  double clock_ns = 0;           ///< what a look at the clock costs, twice
  double cycle_ns = 0;           ///< a cycle in batches that look at the clock once: their median, the figure to trust
  Times cycle;                   ///< single cycles
  std::vector<Primitive> parts;  ///< the dearest first
  std::string ended;             ///< why the net failed before the time was over; empty: it did not
};

/// Evaluates the net again and again for about `seconds`, first in batches, then cycle by cycle, then with a look at
/// few primitives in each cycle. Diagnostics: it fails in its first cycle. Realtime: setup.
[[nodiscard]] Result<NetBench> bench_net(net::CompiledNet& net, double seconds);

[[nodiscard]] std::string to_text(const NetBench& bench, std::size_t most_lines);
[[nodiscard]] nlohmann::ordered_json to_json(const NetBench& bench);

}  // namespace takt::tools
