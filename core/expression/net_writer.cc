#include "core/expression/net_writer.h"

#include <algorithm>
#include <iterator>
#include <ranges>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/net/digraph.h"

namespace takt::expression {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLongestId = 100;

/// Mostly one that was added not long ago.
net::PrimitiveDescription& primitive_in(net::NetDescription& net, const std::string& id) {
  return *std::ranges::find(net.primitives.rbegin(), net.primitives.rend(), id, &net::PrimitiveDescription::id);
}

/// "GreaterThan" -> "greater_than": what a primitive without a name of its own is called.
std::string lower_snake(std::string_view type) {
  std::string name;
  for (const char c : type) {
    const bool upper = c >= 'A' && c <= 'Z';
    if (upper && !name.empty()) name += '_';
    name += upper ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return name;
}

}  // namespace

std::string NetWriter::node_of(const std::string& port) { return port.substr(0, port.find_first_of("./")); }

std::string NetWriter::unique(std::string_view preferred) {
  std::string id(preferred.substr(0, kLongestId));
  for (char& c : id) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte <= 0x20 || byte == 0x7f || c == '.' || c == '/') c = '_';
  }
  if (id.empty()) id = "_";
  if (ids_.insert(id).second) return id;
  std::string free;
  int& n = next_number_.try_emplace(id, 2).first->second;
  do free = fmt::format("{}_{}", id, n++);
  while (!ids_.insert(free).second);
  return free;
}

void NetWriter::add(const std::string& id, std::string type, Json parameters, Json on_null) {
  net.primitives.push_back(
      {.id = id, .type = std::move(type), .parameters = std::move(parameters), .on_null = std::move(on_null)});
}

void NetWriter::link(std::string from, std::string to) {
  const int source = number_of(node_of(from)), target = number_of(node_of(to));
  followers_[static_cast<std::size_t>(source)].push_back(target);
  net.link(std::move(from), std::move(to));
}

void NetWriter::feed(const Signal& signal, const std::string& to) {
  if (signal.constant) return set_parameter(to, *signal.constant);
  if (signal.delayed) {
    net.link_delayed(signal.port, to, false);
  } else {
    link(signal.port, to);
  }
}

void NetWriter::feed(const ExpressionPtr& node, const std::string& to) { link(port_of(node), to); }

void NetWriter::feed_without_cycles(const std::vector<Feed>& feeds) {
  std::vector<std::pair<int, int>> links;
  for (const auto& [signal, to] : feeds) {
    const bool reacts = !signal.constant && !signal.delayed;
    links.emplace_back(reacts ? number_of(node_of(signal.port)) : -1, number_of(node_of(to)));
  }
  const std::vector<int> component = components_with(links);
  for (std::size_t i = 0; i < feeds.size(); ++i) {
    const auto& [signal, to] = feeds[i];
    const auto [source, target] = links[i];
    feed(source >= 0 && reaches(target, source, component) ? signal.one_cycle_ago() : signal, to);
  }
}

int NetWriter::number_of(const std::string& node) {
  const auto [known, is_new] = numbers_.try_emplace(node, static_cast<int>(followers_.size()));
  if (is_new) followers_.emplace_back();
  return known->second;
}

/// The strong components of the net together with links that may come.
std::vector<int> NetWriter::components_with(const std::vector<std::pair<int, int>>& more) const {
  std::vector<std::pair<int, int>> from_to;
  for (std::size_t source = 0; source < followers_.size(); ++source)
    for (const int target : followers_[source]) from_to.emplace_back(static_cast<int>(source), target);
  std::ranges::copy_if(more, std::back_inserter(from_to), [](const auto& link) { return link.first >= 0; });
  return net::strong_components(net::Digraph(static_cast<int>(followers_.size()), from_to)).of;
}

bool NetWriter::reaches(int from, int to, const std::vector<int>& component) const {
  const auto component_of = [&](int node) { return component[static_cast<std::size_t>(node)]; };
  if (component_of(from) != component_of(to)) return false;
  std::unordered_set<int> seen{from};
  std::vector<int> open{from};
  while (!open.empty()) {
    const int node = open.back();
    open.pop_back();
    if (node == to) return true;
    for (const int follower : followers_[static_cast<std::size_t>(node)])
      if (component_of(follower) == component_of(to) && seen.insert(follower).second) open.push_back(follower);
  }
  return false;
}

/// "id.port" at the outermost level, "fragment/id.port" inside of one.
void NetWriter::set_parameter(const std::string& to, Json value) {
  const auto slash = to.find('/');
  const std::string inner = slash == std::string::npos ? to : to.substr(slash + 1);
  const auto dot = inner.find('.');
  net::NetDescription& owner = slash == std::string::npos
                                   ? net
                                   : std::ranges::find(net.fragments.rbegin(), net.fragments.rend(),
                                                       to.substr(0, slash), &net::FragmentDescription::id)
                                         ->net;
  primitive_in(owner, inner.substr(0, dot)).parameters[inner.substr(dot + 1)] = std::move(value);
}

// -- Gates -----------------------------------------------------------------------------------------------------------

Signal NetWriter::gate(const std::string& id, const char* type, const Signal& a, const Signal& b) {
  const std::string key = fmt::format("{} {}{} {}{}", type, a.port, a.delayed, b.port, b.delayed);
  auto [place, is_new] = primitives_.try_emplace(key);
  if (is_new) {
    const std::string own = place->second = unique(id);
    add(own, type);
    feed(a, own + ".a");
    feed(b, own + ".b");
  }
  return Signal::at(place->second + ".value");
}

Signal NetWriter::both(const std::string& id, const Signal& a, const Signal& b) {
  if (a.is(false) || b.is(true)) return a;
  if (b.is(false) || a.is(true)) return b;
  return gate(id, "And", a, b);
}

Signal NetWriter::either(const std::string& id, const Signal& a, const Signal& b) {
  if (a.is(true) || b.is(false)) return a;
  if (b.is(true) || a.is(false)) return b;
  return gate(id, "Or", a, b);
}

Signal NetWriter::opposite(const Signal& a) {
  if (a.constant) return Signal::always(!*a.constant);
  const std::string key = fmt::format("Not {} {}", a.delayed, a.port);
  auto [place, is_new] = primitives_.try_emplace(key);
  if (is_new) {
    const std::string own = place->second = unique("not_" + node_of(a.port));
    add(own, "Not");
    feed(a, own + ".input");
  }
  return Signal::at(place->second + ".value");
}

Signal NetWriter::any(const std::string& id, const std::vector<Signal>& signals) {
  Signal result = Signal::always(false);
  for (const Signal& signal : signals) result = either(id, result, signal);
  return result;
}

Signal NetWriter::only_while(const std::string& id, const Signal& condition, const Signal& a) {
  if (condition.is(true) || a.is(false)) return a;
  if (condition.is(false)) return condition;
  if (a.is(true)) return condition;
  const std::string key = fmt::format("While {}{} {}{}", condition.port, condition.delayed, a.port, a.delayed);
  auto [place, is_new] = primitives_.try_emplace(key);
  if (is_new) {
    const std::string own = place->second = unique(id);
    add(own, "SelectBoolean", {{"if_false", false}});
    feed(condition, own + ".condition");
    feed(a, own + ".if_true");
  }
  return Signal::at(place->second + ".value");
}

Signal NetWriter::latch(const std::string& id, const Signal& set, bool null_sets) {
  if (set.constant) return set;
  const std::string key = fmt::format("Latch {} {}{}", null_sets, set.port, set.delayed);
  auto [place, is_new] = primitives_.try_emplace(key);
  if (is_new) {
    const std::string own = place->second = unique(id);
    add(own, "SetResetLatch", {{"reset", false}}, null_sets ? Json::object() : Json{{"set", false}});
    feed(set, own + ".set");
  }
  return Signal::at(place->second + ".value");
}

// -- Formulas --------------------------------------------------------------------------------------------------------

std::string NetWriter::port_of_signal(const Signal& signal) {
  if (!signal.constant) return signal.port;
  const std::string key = fmt::format("Constant {}", *signal.constant);
  auto [place, is_new] = primitives_.try_emplace(key);
  if (is_new) {
    place->second = unique(*signal.constant ? "always" : "never");
    add(place->second, "ConstantBoolean", {{"value", *signal.constant}});
  }
  return place->second + ".value";
}

std::string NetWriter::port_of(const ExpressionPtr& node) {
  return node->subject ? port_of_signal(leaves_(*node)) : write(node);
}

Signal NetWriter::signal_of(const ExpressionPtr& node) {
  return node->subject ? leaves_(*node) : Signal::at(write(node));
}

/// Equal primitives with equal inputs give equal values, with state too: one is enough.
std::string NetWriter::write(const ExpressionPtr& node) {
  if (const auto found = written_.find(node.get()); found != written_.end()) return found->second;
  std::vector<std::pair<std::string, Signal>> inputs;
  std::string key = node->primitive.type + node->primitive.parameters.dump() + node->primitive.on_null.dump();
  for (const auto& [port, input] : node->inputs) {
    const bool truth = input->type == net::ValueType::kBoolean;
    inputs.emplace_back(port, truth ? signal_of(input) : Signal::at(port_of(input)));
    const Signal& signal = inputs.back().second;
    key += fmt::format(" {}={}", port, signal.constant ? (*signal.constant ? "true" : "false") : signal.port);
  }
  auto [place, is_new] = primitives_.try_emplace(std::move(key));
  if (is_new) {
    const std::string preferred = node->primitive.id.empty() ? lower_snake(node->primitive.type) : node->primitive.id;
    place->second = unique(preferred);
    add(place->second, node->primitive.type, node->primitive.parameters, node->primitive.on_null);
    for (const auto& [port, signal] : inputs) feed(signal, place->second + "." + port);
  }
  kept_.push_back(node);
  return written_[node.get()] = place->second + "." + node->output;
}

// -- Fragments -------------------------------------------------------------------------------------------------------

FragmentWriter::FragmentWriter(NetWriter& outside, std::string id, Signal cancel)
    : outside_(outside), id_(std::move(id)), cancel_(std::move(cancel)), place_(outside.net.fragments.size()) {
  net::FragmentDescription fragment;
  fragment.id = id_;
  fragment.when_inactive = net::WhenInactive::kReset;
  outside_.net.fragments.push_back(std::move(fragment));
}

void FragmentWriter::add(const std::string& id, std::string type, Json parameters) {
  net().add(id, std::move(type), std::move(parameters));
}
void FragmentWriter::link(const std::string& from, const std::string& to) { net().link(from, to); }
void FragmentWriter::link_all(const std::string& from, const std::string& to,
                              std::initializer_list<const char*> ports) {
  for (const char* port : ports) link(from + "." + port, to + "." + port);
}
void FragmentWriter::feed(const Signal& signal, const std::string& to) { outside_.feed(signal, outer(to)); }
void FragmentWriter::feed(const ExpressionPtr& node, const std::string& to) { outside_.feed(node, outer(to)); }

std::string FragmentWriter::gate_with_cancel(const std::string& id, const char* type, const std::string& port) {
  add(id, type);
  link(port, id + ".a");
  feed(cancel_, id + ".b");
  return id + ".value";
}

void FragmentWriter::link_delayed(const std::string& from, const std::string& to, Json initial) {
  net().link_delayed(from, to, std::move(initial));
}

void FragmentWriter::set_parameter(const std::string& id, const std::string& name, Json value) {
  primitive_in(net(), id).parameters[name] = std::move(value);
}

std::string FragmentWriter::add_null_test(const std::string& input, net::ValueType type) {
  std::string id = "no_" + input;
  std::ranges::replace(id, '.', '_');
  if (has(id)) return id + ".value";
  const auto inner = std::ranges::find(net().links, input, &net::LinkDescription::to);
  const auto from_outside = std::ranges::find(outside_.net.links, outer(input), &net::LinkDescription::to);
  if (inner == net().links.end() && from_outside == outside_.net.links.end()) {
    add(id, "ConstantBoolean", {{"value", false}});
    return id + ".value";
  }
  add(id, "IsNull" + std::string(net::name_of(type)));
  if (inner != net().links.end()) {
    link(inner->from, id + ".input");
  } else {
    outside_.link(from_outside->from, outer(id + ".input"));
  }
  return id + ".value";
}

std::string FragmentWriter::take_link(const std::string& to) {
  auto& links = net().links;
  const auto link = std::ranges::find(links, to, &net::LinkDescription::to);
  std::string from = link->from;
  links.erase(link);
  return from;
}

void FragmentWriter::nest(net::FragmentDescription fragment) { net().fragments.push_back(std::move(fragment)); }

std::string_view FragmentWriter::type_of(const std::string& id) const {
  const auto& primitives = outside_.net.fragments[place_].net.primitives;
  const auto found = std::ranges::find(primitives, id, &net::PrimitiveDescription::id);
  return found == primitives.end() ? std::string_view() : std::string_view(found->type);
}

}  // namespace takt::expression
