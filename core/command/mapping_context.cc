#include "core/command/mapping_context.h"

#include <algorithm>

namespace takt::command {
namespace {

std::string preferred_id(const CommandTree& tree, int i) {
  std::string id = tree.at(i).node->name;
  for (int p = tree.at(i).parent; p > 0; p = tree.at(p).parent) id = tree.at(p).node->name + "-" + id;
  return id;
}

}  // namespace

MappingContext::MappingContext(const CommandTree& commands, NetWriter& net)
    : tree(commands), writer(net), latches(net) {
  // Those of the primitives Termination and Cancel.
  (void)writer.unique("end");
  (void)writer.unique("cancel");
  for (int i = 0; i < tree.size(); ++i) ids.push_back(writer.unique(preferred_id(tree, i)));
}

bool MappingContext::has_event(Effect::Kind kind, int i) const {
  return std::ranges::any_of(tree.handlers(), [&](const CommandTree::Handler& h) {
    return h.handler->effect.kind == kind && tree.find(h.handler->effect.target) == i;
  });
}

void MappingContext::trace(const std::string& name, const Signal& signal) {
  const bool known = std::ranges::any_of(traced, [&](const auto& t) { return t.port == signal.port; });
  if (!signal.constant && !known) traced.push_back({name, signal.port});
}

}  // namespace takt::command
