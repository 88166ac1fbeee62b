#pragma once

#include <map>

#include "core/command/mapping_context.h"

namespace takt::command {

class CommandSignals;

/// The events of handlers as signals of the net: when they occur, when they act after their delay, and whether a start
/// is still due. Part of the mapping. Realtime: setup.
class HandlerSignals {
 public:
  /// @param commands  may not be constructed yet
  HandlerSignals(MappingContext& context, CommandSignals& commands) : context_(context), commands_(commands) {}

  /// The event, before any delay: true as long as the state is as it has to be while the handler is armed.
  [[nodiscard]] expression::Signal occurrence(const CommandTree::Handler& h);
  /// True from the event, after its delay, on.
  [[nodiscard]] expression::Signal delayed(const CommandTree::Handler& h);
  /// The state has held while the handler was armed.
  [[nodiscard]] expression::Signal held(const CommandTree::Handler& h);
  /// A start is due, and nothing has called it off.
  [[nodiscard]] expression::Signal pending(const CommandTree::Handler& h);
  /// The transaction around the target was cancelled, and this handler is not what it does then (rule C4).
  [[nodiscard]] expression::Signal called_off(const CommandTree::Handler& h);
  /// Of a start after a cancel of its transaction: it is what the transaction does then, or what that leads to.
  [[nodiscard]] expression::Signal clears(const CommandTree::Handler& h);

 private:
  [[nodiscard]] expression::Signal armed(const CommandTree::Handler& h);
  [[nodiscard]] bool speaks_of(const EventHandler& handler, int i) const;

  MappingContext& context_;
  CommandSignals& commands_;
  std::map<const EventHandler*, expression::Signal> delayed_, begun_;
};

}  // namespace takt::command
