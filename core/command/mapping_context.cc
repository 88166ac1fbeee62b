#include "core/command/mapping_context.h"

namespace takt::command {
namespace {

std::string preferred_id(const CommandTree& tree, int i) {
  std::string id = tree.at(i).node->name;
  for (int p = tree.at(i).parent; p > 0; p = tree.at(p).parent) id = tree.at(p).node->name + "-" + id;
  return id;
}

}  // namespace

MappingContext::MappingContext(const CommandTree& commands, expression::NetWriter& net)
    : tree(commands), writer(net), latches(net), order(commands), scope(commands) {
  // Those of the primitives Termination and Cancel.
  (void)writer.unique("end");
  (void)writer.unique("cancel");
  for (int i = 0; i < tree.size(); ++i) ids.push_back(writer.unique(preferred_id(tree, i)));
}

bool MappingContext::has_event(Effect::Kind kind, int i) const { return !tree.acting_on(kind, i).empty(); }

void MappingContext::trace(const std::string& name, const expression::Signal& signal) {
  if (!signal.constant && traced_ports_.insert(signal.port).second) traced.push_back({name, signal.port});
}

}  // namespace takt::command
