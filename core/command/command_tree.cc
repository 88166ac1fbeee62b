#include "core/command/command_tree.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <queue>
#include <string_view>

#include "core/base/diagnostics.h"

namespace takt::command {

CommandTree::CommandTree(const Command& root) {
  enter(*root.node(), -1, true, pointer_segment(root.name()));
  starts_.resize(entries_.size());
  enter_effects();
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
  entries_[static_cast<std::size_t>(own)].end = size();
}

void CommandTree::enter_effects() {
  for (auto& of_commands : acting_on_) of_commands.resize(entries_.size());
  for (std::size_t h = 0; h < handlers_.size(); ++h) {
    const Effect& effect = handlers_[h].handler->effect;
    const int target = find(effect.target);
    const auto kind = static_cast<std::size_t>(effect.kind);
    if (target >= 0 && kind < acting_on_.size())
      acting_on_[kind][static_cast<std::size_t>(target)].push_back(static_cast<int>(h));
  }
}

int CommandTree::find(const expression::SubjectPtr& subject) const {
  const auto found = subjects_.find(subject.get());
  return found == subjects_.end() || found->second.size() != 1 ? -1 : found->second.front();
}

int CommandTree::find_raised(const expression::SubjectPtr& subject) const {
  const auto found = raised_.find(subject.get());
  return found == raised_.end() ? -1 : found->second;
}

bool CommandTree::implies_end(const expression::ExpressionPtr& state, int of) const {
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
  for (int other = i; other < at(i).end; ++other) all.insert(all.end(), other);
}

void CommandTree::enter_starts() {
  for (const Handler& handler : handlers_) {
    if (handler.handler->effect.kind != Effect::Kind::kStart) continue;
    const int target = find(handler.handler->effect.target);
    if (target < 0) continue;
    std::set<int> sources, targets;
    add_inside(target, targets);
    if (!at(handler.owner).node->is_transaction()) sources.insert(handler.owner);
    for (const expression::SubjectPtr& subject : expression::subjects_of(handler.handler->state.node())) {
      const int source = find(subject);
      // What a transaction has begun says nothing of what is inside; what is around the target does not come first.
      if (source >= 0 && !is_inside(target, source)) add_inside(source, sources);
      if (source == target) sources.insert(source);
    }
    for (const int source : sources) starts_[static_cast<std::size_t>(source)].insert(targets.begin(), targets.end());
  }
}

std::vector<int> CommandTree::cycle_of_starts() const {
  struct Step {
    int command;
    std::set<int>::const_iterator next;
  };
  enum class Visit : std::uint8_t { kNone, kOpen, kDone };
  std::vector<Visit> visits(entries_.size(), Visit::kNone);
  std::vector<Step> way;
  const auto enter = [&](int i) {
    visits[static_cast<std::size_t>(i)] = Visit::kOpen;
    way.push_back({i, starts_[static_cast<std::size_t>(i)].begin()});
  };
  for (int root = 0; root < size(); ++root) {
    if (visits[static_cast<std::size_t>(root)] == Visit::kNone) enter(root);
    while (!way.empty()) {
      auto& [command, next] = way.back();
      if (next == starts_[static_cast<std::size_t>(command)].end()) {
        visits[static_cast<std::size_t>(command)] = Visit::kDone;
        way.pop_back();
        continue;
      }
      const int to = *next++;
      if (visits[static_cast<std::size_t>(to)] == Visit::kNone) {
        enter(to);
      } else if (visits[static_cast<std::size_t>(to)] == Visit::kOpen) {
        std::vector<int> cycle;
        for (auto step = std::ranges::find(way, to, &Step::command); step != way.end(); ++step)
          cycle.push_back(step->command);
        return cycle;
      }
    }
  }
  return {};
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

bool is_lasting(const expression::Expression& leaf) {
  constexpr std::array<std::string_view, 6> kLasting = {"started", "completed", "failed",
                                                        "stopped", "cancelled", "timed_out"};
  return leaf.subject->kind == expression::Subject::Kind::kRaised ||
         std::ranges::find(kLasting, leaf.output) != kLasting.end();
}

bool is_decided(const expression::ExpressionPtr& state) {
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
