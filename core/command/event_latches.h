#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/command/command.h"
#include "core/expression/net_writer.h"

namespace takt::command {

/// What a latch that event handlers set is for, in the order in which their events are linked.
enum class LatchKind : std::uint8_t { kStart, kCleanUp, kRaise, kStop, kCancel };

/// The latches of a net that event handlers set: of starts, stops, cancels and raised states. A latch is added when
/// something first reads it; its events are linked when all of them are known. Part of the mapping. Realtime: setup.
class EventLatches {
 public:
  explicit EventLatches(expression::NetWriter& writer) : writer_(writer) {}

  /// A latch that events of this kind for the target set. @param null_sets  what an event that is null counts as
  [[nodiscard]] expression::Signal add(const std::string& preferred_id, LatchKind kind,
                                       const expression::Subject* target, bool null_sets);
  /// The latch of a raised state.
  expression::Signal raised(const expression::SubjectPtr& state);

  void add_event(LatchKind kind, const expression::Subject* target, const expression::Signal& event);

  /// Links the events to their latches. What would close a cycle is delayed by one cycle (row O7); starts come first,
  /// so that an end is delayed rather than a start.
  void link_events();

 private:
  struct Latch {
    std::string set;  ///< its input
    LatchKind kind;
    const expression::Subject* target;
  };
  struct Event {
    LatchKind kind;
    const expression::Subject* target;
    expression::Signal signal;
  };
  void add_feeds(const Latch& latch, const std::vector<const Event*>& events,
                 std::vector<expression::NetWriter::Feed>& feeds);

  expression::NetWriter& writer_;
  std::vector<Latch> latches_;
  std::vector<Event> events_;
  std::map<const expression::Subject*, expression::Signal> raised_;
};

}  // namespace takt::command
