#pragma once

#include <set>
#include <string>
#include <vector>

#include "core/command/cancel_scope.h"
#include "core/command/command_tree.h"
#include "core/command/event_latches.h"
#include "core/command/mapping.h"
#include "core/command/start_order.h"
#include "core/expression/net_writer.h"

namespace takt::command {

/// What the parts of the mapping share: the tree, the net that is being written, the ids of the commands in it.
/// Realtime: setup.
class MappingContext {
 public:
  MappingContext(const CommandTree& tree, expression::NetWriter& writer);

  const CommandTree& tree;
  expression::NetWriter& writer;
  EventLatches latches;
  std::vector<std::string> ids;    ///< of each command; inside of others with the names around it, but for the root's
  std::vector<TracedPort> traced;  ///< each port once
  StartOrder order;
  CancelScope scope;

  [[nodiscard]] const CommandNode& node(int i) const { return *tree.at(i).node; }
  [[nodiscard]] const std::string& id(int i) const { return ids[static_cast<std::size_t>(i)]; }
  /// For a part of command i.
  [[nodiscard]] std::string id(int i, const char* what) const { return id(i) + "-" + what; }
  /// Some handler has this effect on command i.
  [[nodiscard]] bool has_event(Effect::Kind kind, int i) const;

  void trace(const std::string& name, const expression::Signal& signal);

 private:
  std::set<std::string> traced_ports_;
};

/// Whether an event that is null counts as true (row N3).
[[nodiscard]] inline bool acts_on_null(Effect::Kind kind) {
  return kind == Effect::Kind::kStop || kind == Effect::Kind::kCancel;
}

}  // namespace takt::command
