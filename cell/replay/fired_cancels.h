#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/net/compiled_net.h"
#include "core/rcc/control_core.h"

namespace takt::cell {

/// A port whose value changed, and the changes that made it change, down to what comes from outside the net.
struct TracedChange {
  std::string port;           ///< "id.port"
  std::int64_t cycle = 0;     ///< of the core, in which it changed
  std::string before, after;  ///< as JSON texts
  bool source = false;        ///< its primitive reads something outside the net: a sensor, an arm, a channel
  bool seen = false;          ///< is in the tree already, with what made it change
  std::vector<TracedChange> from;
};

/// A cancel that fired: in this cycle something in a net, or somebody outside of it, began to end a motion.
struct FiredCancel {
  std::string net;
  TracedChange change;
};

/// Watches all nets of a core for cancels that fire, and traces each back: from the gate at which the net's own reasons
/// meet a cancel from outside, through the outputs that changed in that cycle, to the samples. Which of the changed
/// inputs of a primitive mattered nobody knows but the primitive: all of them are followed, of a Boolean the Boolean
/// ones first. For runs that somebody looks at; the core has to keep its blocks. Realtime: setup.
class FiredCancels {
 public:
  /// After each cycle.
  void look(rcc::ControlCore& core);
  [[nodiscard]] const std::vector<FiredCancel>& fired() const { return fired_; }

 private:
  /// Aligned as slots have to be.
  struct alignas(64) Line {
    std::byte bytes[64];
  };
  struct Moment {
    std::int64_t cycle = 0;
    std::vector<Line> slots;
  };
  /// A net while it runs.
  struct Watched {
    rcc::NetHandle net;
    std::vector<std::size_t> gates;              ///< ports that rise when a cancel fires
    std::map<std::string, std::size_t> numbers;  ///< of the ports, by name
    std::deque<Moment> moments;                  ///< the newest last
  };
  struct Trace;

  static Watched watch(rcc::NetHandle net);
  void look_at(Watched& watched, std::int64_t cycle);

  std::map<rcc::NetId, Watched> nets_;
  std::vector<FiredCancel> fired_;
};

/// {"port", "cycle", "before", "after", "source", "from": [...]}, and for a cancel "net" beside "change".
[[nodiscard]] nlohmann::ordered_json to_json(const FiredCancel& fired);
/// A tree for people, a line a change.
[[nodiscard]] std::string to_text(const FiredCancel& fired, double period_s);

}  // namespace takt::cell
