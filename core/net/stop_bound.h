#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/net/compiled_net.h"

namespace takt::net {

/// How long a net takes at most from a request to cancel to its end (row L6).
struct StopBound {
  double seconds = 0.0;     ///< of everything that needs time to stop: path clocks
  std::int64_t cycles = 0;  ///< of the way from Cancel to Termination
  bool declared = false;    ///< the net says so itself: `seconds` is all of it

  /// Whole cycles until the net has ended: it hears of the request one cycle later, and stands at the end of a cycle.
  [[nodiscard]] std::int64_t in_cycles(Nanoseconds period) const;
};

/// What the net says of itself (Cancel, `bound`), else what follows from its structure: a Cancel that reaches a
/// Termination on ways whose latency does not depend on data, plus the time that each primitive needs to stop.
/// Nothing: the net has no such way. Realtime: setup.
[[nodiscard]] std::optional<StopBound> find_stop_bound(const FlatNet& flat, const std::vector<Primitive*>& primitives,
                                                       const NetReport& report);

/// What comes to rest by itself when a net is asked to stop (Cycle::stop_requested, row S1).
struct PathStop {
  double seconds = 0.0;  ///< at most: the times of all that brakes, one after the other
  /// Devices all of whose drivers are fed, maybe through others, by something that brakes.
  std::vector<const Resource*> devices;
};
/// @param primitives  by their number in the flat net; null where there is none
/// @param drivers     devices with the number of who drives them. Realtime: setup.
[[nodiscard]] PathStop find_path_stop(const FlatNet& flat, std::span<Primitive* const> primitives,
                                      std::span<const std::pair<Resource*, int>> drivers);

}  // namespace takt::net
