#include "core/command/command_tree.h"

#include <algorithm>
#include <array>
#include <functional>
#include <queue>
#include <string_view>

#include "core/base/diagnostics.h"

namespace takt::command {

CommandTree::CommandTree(const Command& root) {
  enter(*root.node(), -1, true, pointer_segment(root.name()));
  starts_.resize(entries_.size());
  enter_starts();
}

/// Recursion ends where a command comes for another time; depth is that of the tree that a person built.
void CommandTree::enter(CommandNode& node, int parent, bool with_parent, const std::string& path) {
  if (!seen_.insert(&node).second) return doubles_.push_back(path);
  const int own = size();
  entries_.push_back({.node = &node, .parent = parent, .children = {}, .with_parent = with_parent, .path = path});
  if (parent >= 0) entries_[static_cast<std::size_t>(parent)].children.push_back(own);
  subjects_[node.subject.get()].push_back(own);
  if (node.action) subjects_[node.action->subject().get()].push_back(own);
  for (const RaisedState& raised : node.raised) raised_[raised.subject().get()] = own;
  for (std::size_t i = 0; i < node.handlers.size(); ++i) {
    handlers_.push_back({&node.handlers[i], own, path + "/handlers" + pointer_segment(i)});
  }
  for (const std::string& name : node.circular) doubles_.push_back(path + pointer_segment(name));
  for (std::size_t i = 0; i < node.children.size(); ++i) {
    enter(*node.children[i], own, node.started_with[i], path + pointer_segment(node.children[i]->name));
  }
}

int CommandTree::find(const SubjectPtr& subject) const {
  const auto found = subjects_.find(subject.get());
  return found == subjects_.end() || found->second.size() != 1 ? -1 : found->second.front();
}

int CommandTree::find_raised(const SubjectPtr& subject) const {
  const auto found = raised_.find(subject.get());
  return found == raised_.end() ? -1 : found->second;
}

bool CommandTree::is_inside(int inner, int outer) const {
  while (inner >= 0 && inner != outer) inner = at(inner).parent;
  return inner == outer;
}

bool CommandTree::implies_end(const ExpressionPtr& state, int of) const {
  if (state->subject) {
    const int speaks_of = find(state->subject);
    return speaks_of >= 0 && is_inside(of, speaks_of) &&
           (state->output == "completed" || state->output == "failed" || state->output == "timed_out" ||
            (state->output == "stopped" && speaks_of == of));
  }
  return state->primitive.type == "And" &&
         std::ranges::any_of(state->inputs, [&](const auto& input) { return implies_end(input.second, of); });
}

std::string CommandTree::name_of(int i, const Observation& observation) const {
  std::string part;
  for (; i > 0; i = at(i).parent) part = at(i).node->part + part;
  return scoped_name(part, observation.name);
}

bool CommandTree::can_fail(int i) const {
  const CommandNode& node = *at(i).node;
  return node.fails_if || (node.until && node.seconds) ||
         std::ranges::any_of(at(i).children, [this](int child) { return can_fail(child); });
}

void CommandTree::add_inside(int i, std::set<int>& all) const {
  for (int other = 0; other < size(); ++other) {
    if (is_inside(other, i)) all.insert(other);
  }
}

void CommandTree::enter_starts() {
  for (const Handler& handler : handlers_) {
    if (handler.handler->effect.kind != Effect::Kind::kStart) continue;
    const int target = find(handler.handler->effect.target);
    if (target < 0) continue;
    std::set<int> sources, targets;
    add_inside(target, targets);
    if (!at(handler.owner).node->is_transaction()) sources.insert(handler.owner);
    for (const SubjectPtr& subject : subjects_of(handler.handler->state.node())) {
      const int source = find(subject);
      // What a transaction has begun says nothing of what is inside; what is around the target does not come first.
      if (source >= 0 && !is_inside(target, source)) add_inside(source, sources);
      if (source == target) sources.insert(source);
    }
    for (const int source : sources) starts_[static_cast<std::size_t>(source)].insert(targets.begin(), targets.end());
  }
}

std::vector<int> CommandTree::cycle_of_starts() const {
  std::vector<int> state(entries_.size(), 0), way;  // 0: new, 1: being visited, 2: done
  std::vector<int> cycle;
  const std::function<bool(int)> visit = [&](int i) {
    const auto place = static_cast<std::size_t>(i);
    if (state[place] == 1) {
      cycle.assign(std::ranges::find(way, i), way.end());
      return true;
    }
    if (state[place] == 2) return false;
    state[place] = 1;
    way.push_back(i);
    for (const int next : starts_[place]) {
      if (visit(next)) return true;
    }
    way.pop_back();
    state[place] = 2;
    return false;
  };
  for (int i = 0; i < size(); ++i) {
    if (visit(i)) break;
  }
  return cycle;
}

std::vector<int> CommandTree::ranks() const {
  std::vector<int> before(entries_.size(), 0), rank(entries_.size(), 0);
  for (const auto& followers : starts_) {
    for (const int follower : followers) ++before[static_cast<std::size_t>(follower)];
  }
  std::priority_queue<int, std::vector<int>, std::greater<>> free;
  for (int i = 0; i < size(); ++i) {
    if (before[static_cast<std::size_t>(i)] == 0) free.push(i);
  }
  for (int next = 0; !free.empty(); ++next) {
    const auto i = static_cast<std::size_t>(free.top());
    free.pop();
    rank[i] = next;
    for (const int follower : starts_[i]) {
      if (--before[static_cast<std::size_t>(follower)] == 0) free.push(follower);
    }
  }
  return rank;
}

bool is_lasting(const Expression& leaf) {
  constexpr std::array<std::string_view, 6> kLasting = {"started", "completed", "failed",
                                                        "stopped", "cancelled", "timed_out"};
  return leaf.subject->kind == Subject::Kind::kRaised || std::ranges::find(kLasting, leaf.output) != kLasting.end();
}

bool is_decided(const ExpressionPtr& state) {
  if (state->subject) return false;
  const std::string& type = state->primitive.type;
  if (type == "SnapshotBoolean" && state->inputs.size() == 1) return true;  // the trigger is a constant
  return (type == "And" || type == "Or" || type == "Not") &&
         std::ranges::all_of(state->inputs, [](const auto& input) { return is_decided(input.second); });
}

bool drives(const Actuator& actuator, const std::string& name) {
  const auto devices = actuator.model().devices();
  return actuator.name() == name || std::ranges::find(devices, name) != devices.end();
}

}  // namespace takt::command
