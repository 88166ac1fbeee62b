#pragma once

#include <cstdint>

#include "core/activity/step.h"
#include "core/net/description.h"

namespace takt::activity {

/// A net from LOAD to its end, as a step that is advanced between cycles: load at once, start `program_latency_cycles`
/// later (row D2), wait for Terminated, unload when destroyed by the core's owner. Used by steps that act on devices.
class NetRun {
 public:
  [[nodiscard]] bool begun() const { return id_ != 0; }
  Progress begin(Context& context, const net::NetDescription& description, Findings& findings);
  Progress advance(Context& context, Findings& findings);
  void cancel(Context& context);
  /// The net, to read ports after it has ended; null before begin().
  [[nodiscard]] const net::CompiledNet* net(const Context& context) const;

 private:
  rcc::NetId id_ = 0;
  std::int64_t start_cycle_ = 0;
  rcc::RequestId start_request_ = 0;
  bool cancelled_ = false;
};

}  // namespace takt::activity
