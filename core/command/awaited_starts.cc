#include "core/command/awaited_starts.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <vector>

namespace takt::command {
namespace {

using Kind = Effect::Kind;

bool is_gate(const expression::Expression& node, std::string_view type) {
  return !node.subject && node.primitive.type == type;
}

/// Adds the commands with which a part of the formula ends, so that the formula changes then.
/// @param falling  the change from true to false counts
void add_falling(const CommandTree& tree, const expression::ExpressionPtr& state, bool falling,
                 std::vector<int>& commands) {
  if (state->subject) {
    const int of = tree.find(state->subject);
    if (falling && of >= 0 && !is_lasting(*state)) commands.push_back(of);
    return;
  }
  const bool inverts = is_gate(*state, "Not");
  for (const auto& [port, input] : state->inputs) add_falling(tree, input, inverts ? !falling : falling, commands);
}

}  // namespace

expression::Signal AwaitedStarts::awaited(int i) {
  if (const auto known = awaited_.find(i); known != awaited_.end()) return known->second;
  if (!open_.insert(i).second) return expression::Signal::always(false);
  std::vector<expression::Signal> ways;
  for (const int h : tree_.acting_on(Kind::kStart, i)) {
    const CommandTree::Handler& handler = tree_.handler(h);
    ways.push_back(writer_.both("may_start", may_happen(handler), writer_.opposite(life_.called_off(handler))));
  }
  const expression::Signal any = writer_.any("may_start", ways);
  open_.erase(i);
  return awaited_[i] = writer_.both("awaited", any, writer_.opposite(life_.started(i)));
}

expression::Signal AwaitedStarts::may_happen(const CommandTree::Handler& h) {
  const expression::ExpressionPtr& state = h.handler->state.node();
  if (is_decided(state)) return expression::Signal::always(false);  // what it starts has begun with its transaction
  if (h.handler->entered) return may_be(state, true, h.owner);
  const expression::Signal may_hold = writer_.either("may_hold", life_.held(h), may_be(state, true, h.owner));
  return writer_.both("may_leave", may_hold, may_be(state, false, h.owner));
}

/// @param transaction  whose end is asked for: nothing inside of it runs
expression::Signal AwaitedStarts::may_be(const expression::ExpressionPtr& state, bool value, int transaction) {
  if (state->subject) return leaf_may_be(*state, value, transaction);
  if (is_gate(*state, "And")) return may_gate(*state, value, transaction, value);
  if (is_gate(*state, "Or")) return may_gate(*state, value, transaction, !value);
  if (is_gate(*state, "Not")) return may_gate(*state, !value, transaction, true);
  if (is_gate(*state, "OnDelay") || is_gate(*state, "DefaultToBoolean"))
    return may_gate(*state, value, transaction, true);
  if (is_decided(state)) return value ? writer_.signal_of(state) : writer_.opposite(writer_.signal_of(state));
  // A formula over numbers of actions has a value only while those run.
  expression::Signal may = expression::Signal::always(true);
  for (const expression::SubjectPtr& subject : expression::subjects_of(state))
    may = writer_.both("may_be_known", may, speaker_alive(subject, transaction));
  return may;
}

/// @param all  all inputs have to be able to; else one is enough
expression::Signal AwaitedStarts::may_gate(const expression::Expression& gate, bool value, int transaction, bool all) {
  expression::Signal may = expression::Signal::always(all);
  for (const auto& [port, input] : gate.inputs) {
    const expression::Signal one = may_be(input, value, transaction);
    may = all ? writer_.both("may_all", may, one) : writer_.either("may_any", may, one);
  }
  return may;
}

expression::Signal AwaitedStarts::leaf_may_be(const expression::Expression& leaf, bool value, int transaction) {
  const bool lasting = is_lasting(leaf);
  const auto now = [&] { return writer_.signal_of(std::make_shared<const expression::Expression>(leaf)); };
  if (!value) return lasting ? writer_.opposite(now()) : expression::Signal::always(true);
  if (leaf.subject->kind == expression::Subject::Kind::kRaised)
    return writer_.either("may_be_raised", now(), may_be_raised(leaf, transaction));
  const int of = tree_.find(leaf.subject);
  if (of >= 0 && tree_.is_inside(transaction, of))
    return lasting ? now() : expression::Signal::always(true);  // it lives till then
  const expression::Signal comes = speaker_alive(leaf.subject, transaction);
  return lasting ? writer_.either("may_come", now(), comes) : comes;
}

/// Some handler may raise it.
expression::Signal AwaitedStarts::may_be_raised(const expression::Expression& leaf, int transaction) {
  if (!raising_.insert(leaf.subject.get()).second) return expression::Signal::always(false);
  std::vector<expression::Signal> ways;
  for (const auto& handler : tree_.handlers()) {
    if (handler.handler->effect.kind != Kind::kRaise || handler.handler->effect.target != leaf.subject) continue;
    ways.push_back(tree_.is_inside(transaction, handler.owner) ? may_happen(handler)
                                                               : alive(handler.owner, transaction));
  }
  raising_.erase(leaf.subject.get());
  return writer_.any("may_raise", ways);
}

/// The command runs beside the transaction, or can still be started. One inside of it does not run.
expression::Signal AwaitedStarts::alive(int i, int transaction) {
  if (i < 0 || tree_.is_inside(transaction, i))
    return expression::Signal::always(false);  // its own end starts nothing in here
  const bool inside = tree_.is_inside(i, transaction);
  int branch = i;  // below what both are in
  while (tree_.at(branch).parent != transaction && !tree_.is_inside(transaction, tree_.at(branch).parent))
    branch = tree_.at(branch).parent;
  const expression::Signal comes = awaited(branch);
  return inside ? comes : writer_.either("alive", comes, life_.running(branch));
}

expression::Signal AwaitedStarts::speaker_alive(const expression::SubjectPtr& subject, int transaction) {
  if (subject->kind != expression::Subject::Kind::kActuator) return alive(tree_.find(subject), transaction);
  expression::Signal any = expression::Signal::always(false);
  for (int i = 0; i < tree_.size(); ++i) {
    if (!tree_.at(i).node->is_runtime() || !drives(*tree_.at(i).node->actuator, subject->name)) continue;
    any = writer_.either("driven", any, alive(i, transaction));
  }
  return any;
}

std::set<int> AwaitedStarts::heard_ends(const CommandTree& tree) {
  std::set<int> heard;
  for (const CommandTree::Handler& h : tree.handlers()) {
    const Effect::Kind kind = h.handler->effect.kind;
    const bool acts_then = kind == Kind::kExternal || kind == Kind::kRaise || kind == Kind::kStart;
    if (!acts_then || h.handler->trigger.delay > 0.0) continue;
    std::vector<int> falling;
    add_falling(tree, h.handler->state.node(), !h.handler->entered, falling);
    std::ranges::copy_if(falling, std::inserter(heard, heard.end()),
                         [&](int i) { return tree.is_inside(i, h.owner) && (i > 0 || kind == Kind::kExternal); });
  }
  return heard;
}

}  // namespace takt::command
