#include "core/command/cancel_scope.h"

#include <algorithm>
#include <map>

namespace takt::command {
namespace {

/// The state holds because the command is cancelled. @param value  of the part of a formula that counts
bool needs_cancel_of(const expression::ExpressionPtr& state, const expression::SubjectPtr& command, bool value) {
  if (state->subject) return value && state->subject == command && state->output == "cancelled";
  const bool inverts = state->primitive.type == "Not";
  return std::ranges::any_of(state->inputs, [&](const auto& input) {
    return needs_cancel_of(input.second, command, inverts ? !value : value);
  });
}

}  // namespace

CancelScope::CancelScope(const CommandTree& tree)
    : tree_(tree),
      may_clean_up_(static_cast<std::size_t>(tree.size()), false),
      is_exempt_(static_cast<std::size_t>(tree.size()), false) {
  find_clean_up();
  // What is around a command comes before it.
  for (int i = 1; i < tree_.size(); ++i)
    is_exempt_[static_cast<std::size_t>(i)] = is_exempt(tree_.at(i).parent) || may_clean_up(i) || !is_forwarded(i);
}

bool CancelScope::is_forwarded(int i) const {
  const CancelPolicy& policy = tree_.at(tree_.at(i).parent).node->cancel_policy;
  return policy.kind == CancelPolicy::Kind::kForward ||
         (policy.kind == CancelPolicy::Kind::kForwardTo &&
          std::ranges::find(policy.targets, tree_.at(i).node->subject) != policy.targets.end());
}

bool CancelScope::waits_for_cancel(const CommandTree::Handler& h) const {
  return needs_cancel_of(h.handler->state.node(), tree_.at(h.owner).node->subject, h.handler->entered);
}

/// The commands directly inside of the handler's transaction that it speaks of, or of something in them.
std::vector<int> CancelScope::branches_of(const CommandTree::Handler& h) const {
  std::vector<int> branches;
  for (const expression::SubjectPtr& subject : expression::subjects_of(h.handler->state.node())) {
    int branch = tree_.find(subject);
    if (branch <= h.owner || !tree_.is_inside(branch, h.owner)) continue;
    while (tree_.at(branch).parent != h.owner) branch = tree_.at(branch).parent;
    branches.push_back(branch);
  }
  return branches;
}

std::vector<int> CancelScope::cleaners_of(const CommandTree::Handler& h) const {
  std::vector<int> cleaners = branches_of(h);
  std::erase_if(cleaners, [this](int i) { return !may_clean_up(i); });
  return cleaners;
}

/// From what the cancels start to what that leads to.
void CancelScope::find_clean_up() {
  std::vector<int> found;
  const auto add = [&](const CommandTree::Handler& h) {
    const int target = tree_.find(h.handler->effect.target);
    if (target < 0 || tree_.at(target).parent != h.owner || may_clean_up(target) || !is_forwarded(target)) return;
    may_clean_up_[static_cast<std::size_t>(target)] = true;
    found.push_back(target);
  };
  std::map<int, std::vector<int>> spoken_of;  // handlers that speak of a command
  for (std::size_t h = 0; h < tree_.handlers().size(); ++h) {
    const CommandTree::Handler& handler = tree_.handlers()[h];
    if (handler.handler->effect.kind != Effect::Kind::kStart) continue;
    if (waits_for_cancel(handler)) add(handler);
    for (const int branch : branches_of(handler)) spoken_of[branch].push_back(static_cast<int>(h));
  }
  while (!found.empty()) {
    const int cleaner = found.back();
    found.pop_back();
    for (const int h : spoken_of[cleaner]) add(tree_.handler(h));
  }
}

}  // namespace takt::command
