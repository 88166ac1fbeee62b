#include "core/net/condition_graph.h"

#include <algorithm>
#include <cstdint>

#include <nlohmann/json.hpp>

namespace takt::net {

ConditionGraph::ConditionGraph(const FlatNet& flat)
    : flat_(flat),
      signals_(static_cast<std::size_t>(flat.output_base.back()), -1),
      fragments_(flat.fragments.size(), -1) {}

int ConditionGraph::add(const Condition& condition) {
  conditions_.push_back(condition);
  return static_cast<int>(conditions_.size()) - 1;
}

int ConditionGraph::running(int primitive) {
  const int condition = running_fragment(flat_.fragment_of(primitive));
  expand_pending();
  return condition;
}

/// Fragments nest a few levels deep only.
int ConditionGraph::running_fragment(int fragment) {
  int& known = fragments_[static_cast<std::size_t>(fragment)];
  if (known >= 0) return known;
  const FlatFragment& own = flat_.fragments[static_cast<std::size_t>(fragment)];
  if (!own.gated) return known = constant(true);
  const int outer = running_fragment(own.parent), active = input(flat_.primitive_count() + fragment, 0);
  return known = add({.kind = Kind::kActive, .a = outer, .b = active});
}

int ConditionGraph::signal(int output) {
  int& known = signals_[static_cast<std::size_t>(output)];
  if (known >= 0) return known;
  pending_.push_back(output);
  return known = add({});
}

int ConditionGraph::input(int node, int port) {
  const int number =
      flat_.input_link[static_cast<std::size_t>(flat_.input_base[static_cast<std::size_t>(node)] + port)];
  if (number < 0) {
    if (flat_.is_gate(node)) return constant(true);
    const auto* given = flat_.constant(node, port);
    return given != nullptr && given->is_boolean() ? constant(given->get<bool>()) : add({});
  }
  const FlatLink& link = flat_.links[static_cast<std::size_t>(number)];
  if (link.from < 0 || flat_.output(link.from, link.from_port).type != ValueType::kBoolean) return add({});  // reported
  if (link.delayed) return memory(link);
  return signal(flat_.output_base[static_cast<std::size_t>(link.from)] + link.from_port);
}

/// What delayed links of one fragment from one source with one initial value give is the same.
int ConditionGraph::memory(const FlatLink& link) {
  const int source = flat_.output_base[static_cast<std::size_t>(link.from)] + link.from_port;
  const auto [place, fresh] =
      memories_.try_emplace({{source, link.fragment}, flat_.description(link).initial.dump()}, -1);
  if (fresh) place->second = add({});
  return place->second;
}

void ConditionGraph::expand_pending() {
  while (!pending_.empty()) {
    const int output = pending_.back();
    pending_.pop_back();
    expand(output);
  }
}

void ConditionGraph::expand(int output) {
  const int node =
      static_cast<int>(std::ranges::upper_bound(flat_.output_base, output) - flat_.output_base.begin()) - 1;
  const Formula* meaning = formula_of(node, output - flat_.output_base[static_cast<std::size_t>(node)]);
  if (meaning == nullptr) return;
  const int value = formula(*meaning, node), fragment = flat_.fragment_of(node);
  const bool gated = flat_.fragments[static_cast<std::size_t>(fragment)].gated;
  const int running = gated ? running_fragment(fragment) : -1;
  conditions_[static_cast<std::size_t>(signals_[static_cast<std::size_t>(output)])] = {
      .kind = gated ? Kind::kWhile : Kind::kSame, .a = value, .b = running};
}

const Formula* ConditionGraph::formula_of(int node, int port) {
  const PrimitiveInfo* info = flat_.primitives[static_cast<std::size_t>(node)].info;
  if (info == nullptr) return nullptr;
  const auto [known, fresh] = formulas_.try_emplace({info, port});
  if (fresh) {
    const std::string& name = info->outputs[static_cast<std::size_t>(port)].name;
    const auto found = std::ranges::find(info->meanings, name, &PrimitiveInfo::Meaning::output);
    if (found != info->meanings.end()) known->second = parse_formula(found->formula, *info);
  }
  return known->second ? &*known->second : nullptr;
}

int ConditionGraph::formula(const Formula& formula, int node) {
  std::vector<int> stack;
  for (const Formula::Step& one : formula.steps) stack.push_back(step(one, node, stack));
  return stack.back();
}

/// Takes the operands of the step off the stack. What is no gate may be anything.
int ConditionGraph::step(const Formula::Step& step, int node, std::vector<int>& stack) {
  using Step = Formula::Step::Kind;
  const auto pop = [&stack] {
    const int top = stack.back();
    stack.pop_back();
    return top;
  };
  switch (step.kind) {
    case Step::kInput:
      return input(node, step.input);
    case Step::kConstant:
      return constant(step.constant);
    case Step::kNot:
      return add({.kind = Kind::kNot, .a = pop()});
    case Step::kAnd:
    case Step::kOr:
    case Step::kXor:
    case Step::kElse:
      break;
    default:
      return add({});
  }
  const int b = pop(), a = pop();
  if (step.kind == Step::kAnd) return add({.kind = Kind::kAnd, .a = a, .b = b});
  return step.kind == Step::kOr ? add({.kind = Kind::kOr, .a = a, .b = b}) : add({});
}

std::vector<int> ConditionGraph::in_order() const {
  std::vector<int> order, open;
  std::vector<std::uint8_t> visits(conditions_.size(), 0);
  order.reserve(conditions_.size());
  for (int root = 0; root < static_cast<int>(conditions_.size()); ++root) {
    open.push_back(root);
    while (!open.empty()) {
      const int top = open.back();
      std::uint8_t& visited = visits[static_cast<std::size_t>(top)];
      if (visited++ == 0) {
        const Condition& condition = conditions_[static_cast<std::size_t>(top)];
        for (const int operand : {condition.a, condition.b})
          if (operand >= 0 && visits[static_cast<std::size_t>(operand)] == 0) open.push_back(operand);
        continue;
      }
      open.pop_back();
      if (visited == 2) order.push_back(top);
      visited = 3;
    }
  }
  return order;
}

}  // namespace takt::net
