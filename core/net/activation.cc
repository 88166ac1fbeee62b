#include "core/net/activation.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::net {

using Kind = Formula::Step::Kind;
using Ref = Bdd::Ref;

Activation::Activation(const FlatNet& flat) : flat_(flat), bdd_(kMostNodes) {}

Ref Activation::running(int primitive) { return resolve({What::kRunning, flat_.fragment_of(primitive), 0}).yes; }

Ref Activation::present_at(int primitive, int port) {
  for (;;) {
    missing_.clear();
    const Ref present = present_input(primitive, port, 0);
    if (missing_.empty()) return present;
    const std::vector<Item> wanted = missing_;
    for (const Item& item : wanted) (void)resolve(item);
  }
}

bool Activation::exclude(Ref a, Ref b) {
  const Ref together = bdd_.both(bdd_.both(a, b), world_);
  return together == Bdd::kFalse && !bdd_.overflowed();
}

std::string Activation::example(Ref a, Ref b) {
  constexpr std::size_t kMostShown = 4;
  std::vector<std::string> parts;
  for (const auto& [variable, value] : bdd_.example(bdd_.both(bdd_.both(a, b), world_))) {
    const auto found = words_.find(variable);
    if (found == words_.end()) continue;
    const std::string& text = value ? found->second.first : found->second.second;
    if (!text.empty() && parts.size() < kMostShown) parts.push_back(text);
  }
  return fmt::format("{}", fmt::join(parts, " and "));
}

// Evaluation on demand with a stack of its own: an item that needs others waits until they are known.

const Activation::Tristate& Activation::resolve(const Item& item) {
  std::vector<Item> open{item};
  std::map<Item, int> visits;
  while (!open.empty()) {
    const Item top = open.back();
    if (memo_.contains(top)) {
      open.pop_back();
      continue;
    }
    missing_.clear();
    const Tristate value = evaluate(top);
    // An item that is asked for again while it waits stands in a cycle: it may be anything.
    if (missing_.empty() || visits[top]++ > 1 || gave_up()) {
      memo_[top] = missing_.empty() && !gave_up() ? value : Tristate{};
      open.pop_back();
      continue;
    }
    open.insert(open.end(), missing_.begin(), missing_.end());
  }
  return memo_[item];
}

const Activation::Tristate& Activation::look(const Item& item) {
  static const Tristate kAnything;
  const auto found = memo_.find(item);
  if (found != memo_.end()) return found->second;
  missing_.push_back(item);
  return kAnything;
}

Activation::Tristate Activation::evaluate(const Item& item) {
  switch (item.what) {
    case What::kSignal:
      return signal(item.index, item.back);
    case What::kRunning:
      return running_fragment(item.index, item.back);
    case What::kPresent:
      break;
  }
  return present(item.index, item.back);
}

Activation::Tristate Activation::signal(int output, int back) {
  const int node = node_of(output), port = output - flat_.output_base[static_cast<std::size_t>(node)];
  const PrimitiveInfo& info = *flat_.primitives[static_cast<std::size_t>(node)].info;
  Tristate value;
  if (const Formula* formula = formula_of(node, port)) {
    value = meaning(*formula, node, output, back);
  } else if (info.merge) {
    value = merged(node, back);
  } else {
    const Origin origin{.output = output, .back = back, .initial = {}};
    value = atom(origin);
    keep_exclusive(origin);
  }
  const int fragment = flat_.fragment_of(node);
  return ever_rests(fragment) ? gated(value, look({What::kRunning, fragment, back})) : value;
}

Activation::Tristate Activation::running_fragment(int fragment, int back) {
  if (!ever_rests(fragment)) return constant(true);
  const int parent = flat_.fragments[static_cast<std::size_t>(fragment)].parent;
  const Tristate outer = look({What::kRunning, parent, back});
  const Tristate own = read(flat_.primitive_count() + fragment, 0, back);
  return {bdd_.both(outer.yes, own.yes), bdd_.either(outer.no, bdd_.either(own.no, own.null)), Bdd::kFalse};
}

/// Null in, null out: a value needs its fragment and all inputs that do not handle null themselves.
Activation::Tristate Activation::present(int output, int back) {
  const int node = node_of(output);
  const PrimitiveInfo& info = *flat_.primitives[static_cast<std::size_t>(node)].info;
  Ref there = look({What::kRunning, flat_.fragment_of(node), back}).yes;
  Ref any = info.merge ? Bdd::kFalse : Bdd::kTrue;
  for (int port = 0; port < flat_.input_count(node); ++port) {
    if (info.merge) {
      any = bdd_.either(any, present_input(node, port, back));
    } else if (flat_.input(node, port).spec.on_null == OnNull::kPropagate) {
      there = bdd_.both(there, present_input(node, port, back));
    }
  }
  return {bdd_.both(there, any), Bdd::kTrue, Bdd::kTrue};
}

// What arrives at inputs.

const FlatLink* Activation::link_into(int node, int port) const {
  const int link = flat_.input_link[static_cast<std::size_t>(flat_.input_base[static_cast<std::size_t>(node)] + port)];
  return link < 0 ? nullptr : &flat_.links[static_cast<std::size_t>(link)];
}

Activation::Tristate Activation::read(int node, int port, int back) {
  const FlatLink* link = link_into(node, port);
  if (link == nullptr) {
    if (flat_.is_gate(node)) return constant(true);
    const auto* given = flat_.constant(node, port);
    if (given != nullptr && given->is_boolean()) return constant(given->get<bool>());
    return {Bdd::kFalse, Bdd::kFalse, Bdd::kTrue};
  }
  if (link->from < 0 || flat_.output(link->from, link->from_port).type != ValueType::kBoolean) return {};  // reported
  const int from = output_number(link->from, link->from_port);
  if (!link->delayed) return look({What::kSignal, from, back});
  if (ever_rests(link->fragment) || back >= kMostCyclesBack) return atom(memory(*link, back));
  const auto& initial = flat_.description(*link).initial;
  const Tristate begin =
      initial.is_boolean() ? constant(initial.get<bool>()) : Tristate{Bdd::kFalse, Bdd::kFalse, Bdd::kTrue};
  const Tristate before = look({What::kSignal, from, back + 1});
  const Ref now = first(back), later = bdd_.opposite(now);
  const auto choose = [&](Ref a, Ref b) { return bdd_.either(bdd_.both(now, a), bdd_.both(later, b)); };
  return {choose(begin.yes, before.yes), choose(begin.no, before.no), choose(begin.null, before.null)};
}

Ref Activation::present_input(int node, int port, int back) {
  const FlatLink* link = link_into(node, port);
  if (link == nullptr) {
    const auto* given = flat_.constant(node, port);
    return given != nullptr && !given->is_null() ? Bdd::kTrue : Bdd::kFalse;
  }
  if (link->from < 0) return Bdd::kTrue;
  const int from = output_number(link->from, link->from_port);
  if (!link->delayed) return look({What::kPresent, from, back}).yes;
  if (ever_rests(link->fragment) || back >= kMostCyclesBack) return Bdd::kTrue;
  const bool begins = !flat_.description(*link).initial.is_null();
  const Ref now = first(back), before = look({What::kPresent, from, back + 1}).yes;
  return bdd_.either(bdd_.both(now, begins ? Bdd::kTrue : Bdd::kFalse), bdd_.both(bdd_.opposite(now), before));
}

Activation::Origin Activation::memory(const FlatLink& link, int back) const {
  return {output_number(link.from, link.from_port), back, link.fragment, flat_.description(link).initial.dump()};
}

/// A Merge hands on one of its inputs.
Activation::Tristate Activation::merged(int node, int back) {
  Tristate value{Bdd::kFalse, Bdd::kFalse, Bdd::kTrue};
  for (int port = 0; port < flat_.input_count(node); ++port) {
    const Tristate input = read(node, port, back);
    value = {bdd_.either(value.yes, input.yes), bdd_.either(value.no, input.no), bdd_.both(value.null, input.null)};
  }
  return value;
}

// Meanings.

const Formula* Activation::formula_of(int node, int port) {
  const PrimitiveInfo& info = *flat_.primitives[static_cast<std::size_t>(node)].info;
  const auto [known, fresh] = formulas_.try_emplace({&info, port});
  if (fresh) {
    const std::string& name = info.outputs[static_cast<std::size_t>(port)].name;
    const auto found = std::ranges::find(info.meanings, name, &PrimitiveInfo::Meaning::output);
    if (found != info.meanings.end()) known->second = parse_formula(found->formula, info);
  }
  return known->second ? &*known->second : nullptr;
}

Activation::Tristate Activation::meaning(const Formula& formula, int node, int output, int back) {
  std::vector<Tristate> stack;
  for (const Formula::Step& one : formula.steps) stack.push_back(step(one, node, output, back, stack));
  return stack.back();
}

Activation::Tristate Activation::step(const Formula::Step& step, int node, int output, int back,
                                      std::vector<Tristate>& stack) {
  const auto pop = [&stack] {
    const Tristate top = stack.back();
    stack.pop_back();
    return top;
  };
  switch (step.kind) {
    case Kind::kInput:
      return read(node, step.input, back);
    case Kind::kConstant:
      return constant(step.constant);
    case Kind::kUnknown:
      return atom({output, back, kPart, {}});
    case Kind::kIsNull:
      return is_null(node, step.input, back);
    case Kind::kEqual:
    case Kind::kLess:
    case Kind::kLessEqual:
      return compare(step, node, back);
    case Kind::kNot:
      return opposite(pop());
    default:
      break;
  }
  const Tristate b = pop(), a = pop();
  if (step.kind == Kind::kAnd) return both(a, b);
  if (step.kind == Kind::kOr) return either(a, b);
  if (step.kind == Kind::kElse) return otherwise(a, b);
  return either(both(a, opposite(b)), both(opposite(a), b));
}

Activation::Tristate Activation::both(const Tristate& a, const Tristate& b) {
  const Ref null = bdd_.either(bdd_.both(a.null, bdd_.either(b.null, b.yes)), bdd_.both(a.yes, b.null));
  return {bdd_.both(a.yes, b.yes), bdd_.either(a.no, b.no), null};
}

Activation::Tristate Activation::either(const Tristate& a, const Tristate& b) {
  return opposite(both(opposite(a), opposite(b)));
}

Activation::Tristate Activation::otherwise(const Tristate& a, const Tristate& b) {
  return {bdd_.either(a.yes, bdd_.both(a.null, b.yes)), bdd_.either(a.no, bdd_.both(a.null, b.no)),
          bdd_.both(a.null, b.null)};
}

Activation::Tristate Activation::gated(Tristate value, const Tristate& running) {
  return {bdd_.both(value.yes, running.yes), bdd_.both(value.no, running.yes), bdd_.either(value.null, running.no)};
}

Activation::Tristate Activation::is_null(int node, int port, int back) {
  if (flat_.input(node, port).type == ValueType::kBoolean) {
    const Tristate value = read(node, port, back);
    return {value.null, bdd_.either(value.yes, value.no), Bdd::kFalse};
  }
  const FlatLink* link = link_into(node, port);
  const Ref present = present_input(node, port, back);
  if (link == nullptr) return {bdd_.opposite(present), present, Bdd::kFalse};
  if (link->from < 0 || link->delayed) return {Bdd::kTrue, present, Bdd::kFalse};
  // The same unknown as in comparisons of this value.
  const Origin origin{.output = output_number(link->from, link->from_port), .back = back, .initial = {}};
  const Ref null = cuts({origin, {}}).null;
  const Tristate& running = look({What::kRunning, flat_.fragment_of(link->from), back});
  return {bdd_.either(null, running.no), bdd_.both(bdd_.opposite(null), present), Bdd::kFalse};
}

Activation::Operand Activation::operand(const FormulaNumber& number, int node, int back) {
  if (number.input < 0) return {.constant = number.literal, .origin = {}};
  const bool integer = flat_.input(node, number.input).type == ValueType::kInteger;
  const FlatLink* link = link_into(node, number.input);
  if (link == nullptr) {
    const auto* given = flat_.constant(node, number.input);
    if (given != nullptr && given->is_number()) return {.constant = given->get<double>(), .origin = {}};
    return {.constant = {}, .origin = {}};
  }
  if (link->from < 0) return {.constant = {}, .origin = {}};
  if (link->delayed) return {.constant = {}, .origin = memory(*link, back), .integer = integer};
  const Origin origin{.output = output_number(link->from, link->from_port), .back = back, .initial = {}};
  return {.constant = {}, .origin = origin, .node = link->from, .integer = integer};
}

/// Two numbers: one of them constant, or their difference against zero.
Activation::Tristate Activation::compare(const Formula::Step& step, int node, int back) {
  Operand a = operand(step.a, node, back), b = operand(step.b, node, back);
  if ((!a.constant && !a.origin) || (!b.constant && !b.origin)) return {Bdd::kFalse, Bdd::kFalse, Bdd::kTrue};
  if (a.constant && b.constant) {
    const bool equal = *a.constant == *b.constant, less = *a.constant < *b.constant;
    return constant(step.kind == Kind::kEqual ? equal : step.kind == Kind::kLess ? less : less || equal);
  }
  // Beyond this, integers and the doubles that stand for them part ways.
  constexpr double kMostExact = 9007199254740992.0;
  if (std::abs(a.constant.value_or(0.0)) >= kMostExact || std::abs(b.constant.value_or(0.0)) >= kMostExact) return {};
  bool turned = a.constant.has_value();  // c OP x is asked as x against c
  double limit = turned ? *a.constant : b.constant.value_or(0.0);
  Number number{turned ? *b.origin : *a.origin, {}};
  if (!a.constant && !b.constant) {
    turned = *b.origin < *a.origin;
    number = turned ? Number{*b.origin, *a.origin} : Number{*a.origin, *b.origin};
  }
  Cuts& known = cuts(number);
  const bool integer = a.integer || b.integer;
  const Ref under = cut(known, {limit, 0}, integer), up_to = cut(known, {limit, 1}, integer);
  Ref holds = step.kind == Kind::kLess ? under : up_to;
  if (turned) holds = bdd_.opposite(step.kind == Kind::kLess ? up_to : under);
  if (step.kind == Kind::kEqual) holds = bdd_.both(up_to, bdd_.opposite(under));
  const Ref there = bdd_.opposite(known.null);
  Tristate value{bdd_.both(holds, there), bdd_.both(bdd_.opposite(holds), there), known.null};
  for (const int from : {a.node, b.node}) {
    if (from >= 0 && ever_rests(flat_.fragment_of(from))) {
      value = gated(value, look({What::kRunning, flat_.fragment_of(from), back}));
    }
  }
  return value;
}

// What LOAD cannot look into.

Activation::Tristate Activation::atom(const Origin& origin) {
  auto found = atoms_.find(origin);
  if (found == atoms_.end()) {
    found = atoms_.emplace(origin, std::pair{bdd_.variable(), bdd_.variable()}).first;
    if (bdd_.overflowed()) return {};
    if (origin.owner != kPart) {
      const int node = node_of(origin.output);
      const std::string name =
          flat_.output_name(node, origin.output - flat_.output_base[static_cast<std::size_t>(node)]);
      const std::string when = origin.back == 0   ? ""
                               : origin.back == 1 ? " one cycle before"
                                                  : fmt::format(" {} cycles before", origin.back);
      words_[bdd_.variable_of(found->second.first)] = {fmt::format("'{}' is null{}", name, when), ""};
      words_[bdd_.variable_of(found->second.second)] = {fmt::format("'{}' is true{}", name, when),
                                                        fmt::format("'{}' is false{}", name, when)};
    }
  }
  const auto [null, value] = found->second;
  const Ref there = bdd_.opposite(null);
  return {bdd_.both(there, value), bdd_.both(there, bdd_.opposite(value)), null};
}

/// The outputs of a group that are in play: no two are true.
void Activation::keep_exclusive(const Origin& origin) {
  const int node = node_of(origin.output), base = flat_.output_base[static_cast<std::size_t>(node)];
  const PrimitiveInfo& info = *flat_.primitives[static_cast<std::size_t>(node)].info;
  const std::string& name = info.outputs[static_cast<std::size_t>(origin.output - base)].name;
  for (const auto& group : info.exclusive_outputs) {
    if (std::ranges::find(group, name) == group.end()) continue;
    for (std::size_t port = 0; port < info.outputs.size(); ++port) {
      const Origin other{.output = base + static_cast<int>(port), .back = origin.back, .initial = {}};
      if (info.outputs[port].name == name || std::ranges::find(group, info.outputs[port].name) == group.end() ||
          !atoms_.contains(other)) {
        continue;
      }
      world_ = bdd_.both(world_, bdd_.opposite(bdd_.both(atom(origin).yes, atom(other).yes)));
    }
  }
}

Activation::Cuts& Activation::cuts(const Number& number) {
  const auto [found, fresh] = numbers_.try_emplace(number);
  if (fresh) found->second.null = bdd_.variable();
  return found->second;
}

/// Whether a number is below a cut. Cuts of one number are nested.
Ref Activation::cut(Cuts& cuts, Cut at, bool integer) {
  if (integer && at.second == 1 && at.first == std::floor(at.first)) at = {at.first + 1.0, 0};
  const auto [place, fresh] = cuts.below.try_emplace(at);
  if (!fresh) return place->second;
  place->second = bdd_.variable();
  const auto implies = [this](Ref a, Ref b) { world_ = bdd_.both(world_, bdd_.either(bdd_.opposite(a), b)); };
  if (place != cuts.below.begin()) implies(std::prev(place)->second, place->second);
  if (std::next(place) != cuts.below.end()) implies(place->second, std::next(place)->second);
  return place->second;
}

/// Whether the net began so many cycles ago.
Ref Activation::first(int back) {
  const auto [found, fresh] = first_.try_emplace(back);
  if (fresh) found->second = bdd_.variable();
  return found->second;
}

int Activation::node_of(int output) const {
  return static_cast<int>(std::ranges::upper_bound(flat_.output_base, output) - flat_.output_base.begin()) - 1;
}

}  // namespace takt::net
