#include "core/command/handler_check.h"

#include <algorithm>

#include <fmt/format.h>

namespace takt::command {
namespace {

using Kind = Effect::Kind;
using Handler = CommandTree::Handler;

bool is_not(const expression::Expression& node) { return !node.subject && node.primitive.type == "Not"; }
bool is_and(const expression::Expression& node) { return !node.subject && node.primitive.type == "And"; }

class HandlerCheck {
 public:
  HandlerCheck(const CommandTree& tree, Diagnostics& diagnostics) : tree_(tree), diagnostics_(diagnostics) {}

  void check(const Handler& h) {
    const expression::ExpressionPtr& state = h.handler->state.node();
    const bool is_told = h.handler->effect.kind == Kind::kExternal && h.handler->trigger.delay <= 0.0;
    if (!h.handler->entered && !can_change(state, false, is_told)) {
      if (can_change(state, false, true)) {
        diagnostics_.error(
            Code::kNeverFires, h.path,
            fmt::format("C11: this state is left when all of '{}' has ended: nothing in it acts then", name(0)),
            "Use an external effect without a delay, or put both into a transaction around them");
        return;
      }
      diagnostics_.error(Code::kNeverFires, h.path,
                         "C11: this state is never left: what has happened stays so until the net ends",
                         "Use `active` of a command, a state of an action, or a sensor");
    } else if (const int late = begins_too_late(h); late >= 0) {
      diagnostics_.error(
          Code::kNeverFires, h.path,
          fmt::format("C11: it never acts: '{}' begins only when '{}' has ended", name(late), name(h.owner)),
          "Put the handler on a transaction around both");
    } else if (h.handler->effect.kind == Kind::kStart && waits_for_sensors(h)) {
      diagnostics_.note(h.path,
                        fmt::format("'{}' does not end before '{}' has started: it waits for what sensors say",
                                    name(h.owner), h.handler->effect.target->name),
                        "together with `active` of a command, if it counts only while that runs");
    }
  }

 private:
  [[nodiscard]] const std::string& name(int i) const { return tree_.at(i).node->name; }

  /// The state can become `value` after it was not. What lasts changes once, from false to true.
  /// @param with_the_tree  the end of the whole tree counts too
  [[nodiscard]] bool can_change(const expression::ExpressionPtr& state, bool value, bool with_the_tree) const {
    if (state->subject) {
      const bool ends_with_tree = tree_.find(state->subject) == 0;
      return value || !(is_lasting(*state) || (ends_with_tree && !with_the_tree));
    }
    if (is_not(*state)) return can_change(state->inputs.front().second, !value, with_the_tree);
    if (state->type != net::ValueType::kBoolean || state->inputs.empty()) return true;
    const bool of_states = std::ranges::all_of(
        state->inputs, [](const auto& input) { return input.second->type == net::ValueType::kBoolean; });
    return !of_states || std::ranges::any_of(state->inputs, [&](const auto& input) {
      return can_change(input.second, value, with_the_tree);
    });
  }

  /// A command that the state needs and that begins only when the owner of the handler has ended; -1: none.
  [[nodiscard]] int begins_too_late(const Handler& h) const {
    if (h.owner == 0 || mentions(h.handler->state.node(), h.owner)) return -1;
    return needed_too_late(h.handler->state.node(), h.owner);
  }
  [[nodiscard]] int needed_too_late(const expression::ExpressionPtr& state, int owner) const {
    if (state->subject) {
      const int of = tree_.find(state->subject);
      return of >= 0 && begins_after(of, owner) ? of : -1;
    }
    if (!is_and(*state)) return -1;
    for (const auto& [port, input] : state->inputs)
      if (const int late = needed_too_late(input, owner); late >= 0) return late;
    return -1;
  }
  /// Whatever starts it, or what is around it, waits for the end of `before`.
  [[nodiscard]] bool begins_after(int i, int before) const {
    for (int at = i; at > 0 && !tree_.is_inside(before, at); at = tree_.at(at).parent) {
      if (tree_.at(at).with_parent) continue;
      const auto& starts = tree_.acting_on(Kind::kStart, at);
      const auto waits = [&](int h) {
        const EventHandler& handler = *tree_.handler(h).handler;
        return handler.entered && tree_.implies_end(handler.state.node(), before);
      };
      if (!starts.empty() && std::ranges::all_of(starts, waits)) return true;
    }
    return false;
  }
  [[nodiscard]] bool mentions(const expression::ExpressionPtr& state, int i) const {
    return std::ranges::any_of(expression::subjects_of(state),
                               [&](const expression::SubjectPtr& one) { return tree_.find(one) == i; });
  }

  /// It may be entered, by a sensor, when nothing runs any more.
  [[nodiscard]] bool waits_for_sensors(const Handler& h) const {
    const expression::ExpressionPtr& state = h.handler->state.node();
    return !is_decided(state) && has_sensor(state) && stays_open(state);
  }
  [[nodiscard]] bool has_sensor(const expression::ExpressionPtr& state) const {
    if (state->subject) return false;
    return expression::subjects_of(state).empty() ||
           std::ranges::any_of(state->inputs, [&](const auto& input) { return has_sensor(input.second); });
  }
  /// It does not need something that is over when nothing runs any more.
  [[nodiscard]] bool stays_open(const expression::ExpressionPtr& state) const {
    if (state->subject) return is_lasting(*state);
    if (expression::subjects_of(state).empty() || is_not(*state)) return true;
    const auto open = [&](const auto& input) { return stays_open(input.second); };
    return is_and(*state) ? std::ranges::all_of(state->inputs, open) : std::ranges::any_of(state->inputs, open);
  }

  const CommandTree& tree_;
  Diagnostics& diagnostics_;
};

}  // namespace

void check_acting(const CommandTree& tree, Diagnostics& diagnostics) {
  HandlerCheck check(tree, diagnostics);
  for (const Handler& handler : tree.handlers()) {
    const expression::ExpressionPtr& state = handler.handler->state.node();
    if (state && state->depth <= expression::kMostDepth && !expression::faults_of(state).has_errors())
      check.check(handler);
  }
}

}  // namespace takt::command
