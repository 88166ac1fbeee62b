#pragma once

#include <cmath>
#include <cstdint>

#include "core/net/primitive.h"

namespace takt::primitives {

/// Notices that a Boolean becomes true. What was before the first cycle counts as false, so true there is an edge; null
/// counts as false. Realtime: cyclic.
class Trigger {
 public:
  /// To be called once in every cycle.
  bool rises(const net::Cycle& cycle, const net::In<net::Boolean>& in) {
    const bool now = in.value_or(false);
    const bool edge = now && (cycle.first || !before_);
    before_ = now;
    return edge;
  }

 private:
  bool before_ = false;
};

/// Whole periods that last at least `seconds`; a hair less counts as reached (0.1 s are 100 cycles of 1 ms).
inline std::int64_t cycles_of(double seconds, double dt) {
  return static_cast<std::int64_t>(std::ceil(seconds / dt - 1e-9));
}

/// Ports that act where they are true; null counts as false, and a reset may be left out.
inline net::PortSpec trigger_spec(std::string_view doc) { return {.doc = doc, .on_null = net::OnNull::kCountsAsFalse}; }
inline net::PortSpec reset_spec(std::string_view doc) {
  return {.doc = doc, .on_null = net::OnNull::kCountsAsFalse, .optional = true};
}

}  // namespace takt::primitives
