#include "core/net/flat_net.h"

#include <algorithm>
#include <ranges>
#include <unordered_map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace takt::net {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxIdBytes = 128;
constexpr int kMostBridgedCycles = 1000;

bool valid_id(std::string_view id) {
  return !id.empty() && id.size() <= kMaxIdBytes &&
         std::ranges::all_of(id, [](unsigned char c) { return c > ' ' && c != '.' && c != '/' && c != 0x7F; });
}

/// Whether a declaration at an input that may be bridged is malformed.
bool bridge_error(const Json& value) {
  if (value.is_string()) return value != "stop";
  if (!value.is_object() || value.size() != 1) return true;
  const auto cycles = value.find("bridge_cycles");
  return cycles == value.end() || !cycles->is_number_integer() || *cycles < 0 || *cycles > kMostBridgedCycles;
}

int find_port(const std::vector<PrimitiveInfo::Port>& ports, std::string_view name) {
  for (std::size_t i = 0; i < ports.size(); ++i) {
    if (ports[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

std::vector<std::string> port_names(const std::vector<PrimitiveInfo::Port>& ports) {
  std::vector<std::string> names;
  for (const auto& port : ports) names.push_back(port.name);
  return names;
}

using PortIndex = std::vector<std::pair<std::string_view, int>>;

std::pair<PortIndex::const_iterator, PortIndex::const_iterator> ports_named(const PortIndex& ports,
                                                                            std::string_view name) {
  const auto range = std::ranges::equal_range(ports, name, {}, &PortIndex::value_type::first);
  return {range.begin(), range.end()};
}

std::vector<std::string> names_in(const PortIndex& ports) {
  std::vector<std::string> names;
  for (const auto& [name, index] : ports) names.emplace_back(name);
  return names;
}

struct Endpoint {
  int node, port;
};

/// One walk over a description: collects nodes and names, then resolves the links.
class Flattener {
 public:
  Flattener(FlatNet& flat, LoadReport& report) : flat_(flat), report_(report) {}

  void run(const NetDescription& net) {
    collect(net);
    number_ports();
    for (std::size_t f = 1; f < flat_.fragments.size(); ++f) index_ports(flat_.fragments[f]);
    for (std::size_t f = 1; f < flat_.fragments.size(); ++f) check_ports(static_cast<int>(f));
    for (std::size_t f = 0; f < flat_.fragments.size(); ++f) resolve_links(static_cast<int>(f));
    for (std::size_t f = 0; f < flat_.fragments.size(); ++f) resolve_demands(static_cast<int>(f));
    mark_gated();
    for (int p = 0; p < flat_.primitive_count(); ++p) check_inputs(p);
  }

 private:
  void collect(const NetDescription& net);
  void add_primitive(int fragment, const PrimitiveDescription& description, int index);
  void add_fragments(int parent);
  bool add_name(const std::string& full_id, const std::string& id, const std::string& pointer, int value);
  const std::pair<const PrimitiveInfo*, const Maker*>& type_of(const std::string& type);
  void check_parameters(int primitive);
  void check_on_null(int primitive);
  void number_ports();
  void index_ports(FlatFragment& fragment);
  void check_ports(int fragment);

  void resolve_links(int fragment);
  void resolve_demands(int fragment);
  bool split(std::string_view text, std::string_view& id, std::string_view& port, const std::string* pointer);
  const int* find_name(int fragment, std::string_view id);
  bool is_outside(int fragment, std::string_view id);
  void unknown_id(int fragment, std::string_view id, const std::string& pointer);
  void unknown_port(std::string_view port, std::string_view owner, std::string_view kind,
                    const std::vector<std::string>& choices, const std::string& pointer);
  bool resolve_output(int fragment, std::string_view text, const std::string& pointer, Endpoint& found);
  void resolve_inputs(int fragment, std::string_view text, const std::string& pointer, std::vector<Endpoint>& found);
  void connect(const FlatLink& link);
  void mark_gated();
  void check_inputs(int primitive);

  FlatNet& flat_;
  LoadReport& report_;
  /// Full id -> primitive number, or -1 - fragment number. The ids lie in flat_, which does not move them any more.
  std::unordered_map<std::string_view, int> names_;
  std::unordered_map<std::string_view, std::pair<const PrimitiveInfo*, const Maker*>> types_;
  std::string scratch_;
};

void Flattener::collect(const NetDescription& net) {
  flat_.fragments.push_back({.id = "", .pointer = "", .net = &net, .inputs = {}, .outputs = {}});
  std::size_t primitives = 0;
  for (std::size_t f = 0; f < flat_.fragments.size(); ++f) {
    primitives += flat_.fragments[f].net->primitives.size();
    add_fragments(static_cast<int>(f));
  }
  flat_.primitives.reserve(primitives);
  names_.reserve(primitives + flat_.fragments.size());
  for (std::size_t f = 0; f < flat_.fragments.size(); ++f) {
    const NetDescription& inner = *flat_.fragments[f].net;
    for (std::size_t i = 0; i < inner.primitives.size(); ++i) {
      add_primitive(static_cast<int>(f), inner.primitives[i], static_cast<int>(i));
    }
  }
  for (std::size_t f = 1; f < flat_.fragments.size(); ++f) {
    const FlatFragment& fragment = flat_.fragments[f];
    add_name(fragment.id, fragment.description->id, fragment.pointer.substr(0, fragment.pointer.size() - 4),
             -1 - static_cast<int>(f));
  }
}

void Flattener::add_primitive(int fragment, const PrimitiveDescription& description, int index) {
  const std::string& scope = flat_.fragments[static_cast<std::size_t>(fragment)].id;
  const auto [info, maker] = type_of(description.type);
  const int number = flat_.primitive_count();
  flat_.primitives.push_back(
      {scope.empty() ? description.id : scope + "/" + description.id, &description, info, maker, fragment, index});
  const FlatPrimitive& primitive = flat_.primitives.back();
  if (!valid_id(description.id) || !names_.emplace(primitive.id, number).second) {
    add_name(primitive.id, description.id, flat_.primitive_pointer(number), number);
  }
  if (info == nullptr) {
    report_.error(Code::kUnknownName, flat_.primitive_pointer(number) + "/type",
                  fmt::format("unknown type '{}'", shown(description.type)),
                  description.type.size() <= kMaxIdBytes
                      ? report_.nearest(description.type, [] { return Registry::global().names(); })
                      : std::string());
  } else {
    check_parameters(number);
    if (!description.on_null.empty()) check_on_null(number);
  }
}

void Flattener::add_fragments(int parent) {
  // References into flat_.fragments do not outlive a push_back.
  const NetDescription& net = *flat_.fragments[static_cast<std::size_t>(parent)].net;
  const std::string scope = flat_.fragments[static_cast<std::size_t>(parent)].id;
  const std::string pointer = flat_.fragments[static_cast<std::size_t>(parent)].pointer + "/fragments";
  for (std::size_t i = 0; i < net.fragments.size(); ++i) {
    const FragmentDescription& description = net.fragments[i];
    const std::string place = pointer + pointer_segment(i);
    const std::string id = scope.empty() ? description.id : scope + "/" + description.id;
    if (static_cast<std::size_t>(std::ranges::count(id, '/')) >= kMaxNesting) {
      report_.error(Code::kTooLarge, place, fmt::format("fragments nest deeper than {} levels", kMaxNesting),
                    "Move a fragment out of its parent: it may stand beside it as well");
      continue;
    }
    flat_.fragments.push_back({.id = id,
                               .pointer = place + "/net",
                               .description = &description,
                               .net = &description.net,
                               .parent = parent,
                               .inputs = {},
                               .outputs = {}});
  }
}

/// @return whether the name is new and valid; otherwise it is reported.
bool Flattener::add_name(const std::string& full_id, const std::string& id, const std::string& pointer, int value) {
  if (!valid_id(id)) {
    report_.error(Code::kInvalidName, pointer + "/id", fmt::format("invalid id '{}'", shown(id)),
                  "Use 1 to 128 bytes without '.', '/', blanks and control characters");
    return false;
  }
  if (names_.emplace(full_id, value).second) return true;
  report_.error(Code::kDuplicate, pointer + "/id", fmt::format("duplicate id '{}'", id),
                "Give each primitive and fragment of a net an id of its own");
  return false;
}

const std::pair<const PrimitiveInfo*, const Maker*>& Flattener::type_of(const std::string& type) {
  const auto found = types_.find(type);
  if (found != types_.end()) return found->second;
  return types_[type] = {Registry::global().find(type), Registry::global().maker(type)};
}

void Flattener::check_parameters(int number) {
  const FlatPrimitive& primitive = flat_.primitives[static_cast<std::size_t>(number)];
  const Json& parameters = primitive.description->parameters;
  if (!parameters.is_object()) {
    report_.error(Code::kWrongType, flat_.primitive_pointer(number) + "/parameters", "parameters are no JSON object");
    return;
  }
  for (auto item = parameters.begin(); item != parameters.end(); ++item) {
    const std::string& key = item.key();
    if (find_port(primitive.info->inputs, key) >= 0) continue;
    if (std::ranges::find(primitive.info->parameters, key, &PrimitiveInfo::Parameter::name) !=
        primitive.info->parameters.end()) {
      continue;
    }
    const auto choices = [&] {
      std::vector<std::string> names = port_names(primitive.info->inputs);
      for (const auto& parameter : primitive.info->parameters) names.push_back(parameter.name);
      return names;
    };
    report_.error(Code::kUnknownName, flat_.primitive_pointer(number) + "/parameters" + pointer_segment(shown(key)),
                  fmt::format("{} has no parameter '{}'", primitive.info->type, shown(key)),
                  report_.nearest(shown(key), choices));
  }
}

/// What the net declares about null (rows N3, N4).
void Flattener::check_on_null(int number) {
  const FlatPrimitive& primitive = flat_.primitives[static_cast<std::size_t>(number)];
  const PrimitiveInfo& info = *primitive.info;
  const std::string place = flat_.primitive_pointer(number) + "/on_null";
  if (!primitive.description->on_null.is_object()) {
    report_.error(Code::kWrongType, place, "\"on_null\" is not a JSON object",
                  "Write {\"INPUT\": what null means there}");
    return;
  }
  const auto listed = [](const std::vector<std::string>& names, const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  };
  for (const auto& [key, value] : primitive.description->on_null.items()) {
    if (listed(info.flags, key)) {
      if (value.is_boolean()) continue;
      report_.error(Code::kInvalidValue, place + pointer_segment(key),
                    fmt::format("{} is not what null can mean here", shown(value.dump())), "Give true or false");
    } else if (listed(info.bridgeable_inputs, key)) {
      if (!bridge_error(value)) continue;
      report_.error(Code::kUnknownName, place + pointer_segment(key),
                    fmt::format("{} is not what null can mean here", shown(value.dump())),
                    fmt::format("Give \"stop\", or {{\"bridge_cycles\": N}} with N in [0,{}]", kMostBridgedCycles));
    } else {
      const auto choices = [&info] {
        std::vector<std::string> names = info.flags;
        names.insert(names.end(), info.bridgeable_inputs.begin(), info.bridgeable_inputs.end());
        return names;
      };
      report_.error(Code::kUnknownName, place + pointer_segment(shown(key)),
                    fmt::format("{} has no input '{}' at which a net declares what null means", info.type, shown(key)),
                    choices().empty() ? "this type has none at all" : report_.nearest(shown(key), choices));
    }
  }
}

void Flattener::number_ports() {
  const std::size_t nodes = static_cast<std::size_t>(flat_.node_count());
  flat_.input_base.resize(nodes + 1);
  flat_.output_base.resize(nodes + 1);
  int inputs = 0, outputs = 0;
  for (std::size_t n = 0; n < nodes; ++n) {
    flat_.input_base[n] = inputs;
    flat_.output_base[n] = outputs;
    if (flat_.is_gate(static_cast<int>(n))) {
      ++inputs;
    } else if (const PrimitiveInfo* info = flat_.primitives[n].info) {
      inputs += static_cast<int>(info->inputs.size());
      outputs += static_cast<int>(info->outputs.size());
    }
  }
  flat_.input_base[nodes] = inputs;
  flat_.output_base[nodes] = outputs;
  flat_.input_link.assign(static_cast<std::size_t>(inputs), -1);
}

void Flattener::index_ports(FlatFragment& fragment) {
  const std::string place = fragment.pointer.substr(0, fragment.pointer.size() - 4);  // without "/net"
  const auto index = [&](const auto& declared, PortIndex& ports, std::string_view key, bool output) {
    for (std::size_t i = 0; i < declared.size(); ++i) ports.emplace_back(declared[i].first, static_cast<int>(i));
    const auto text = [&](const auto& port) { return declared[static_cast<std::size_t>(port.second)].second; };
    std::ranges::sort(ports, [&](const auto& a, const auto& b) {
      if (a.first != b.first) return a.first < b.first;
      const std::string &to_a = text(a), &to_b = text(b);
      return to_a != to_b ? to_a < to_b : a.second < b.second;
    });
    for (std::size_t i = 0; i < ports.size(); ++i) {
      const bool reserved = !output && ports[i].first == active_port().name;
      const bool twice =
          i > 0 && ports[i].first == ports[i - 1].first && (output || text(ports[i]) == text(ports[i - 1]));
      if (!reserved && !twice && !ports[i].first.empty()) continue;
      fragment.broken = true;
      report_.error(Code::kDuplicate,
                    place + pointer_segment(key) + pointer_segment(static_cast<std::size_t>(ports[i].second)),
                    twice ? fmt::format("duplicate port '{}'", shown(ports[i].first))
                          : fmt::format("invalid port name '{}'", ports[i].first),
                    reserved ? "Remove it: the input 'active' is there by itself"
                    : twice  ? (output ? "Feed each output from one source" : "Lead an input to each target once")
                             : "Give each port a name");
    }
  };
  index(fragment.description->inputs, fragment.inputs, "inputs", false);
  index(fragment.description->outputs, fragment.outputs, "outputs", true);
}

/// Reports ports of a fragment that lead nowhere, linked or not.
void Flattener::check_ports(int number) {
  const FlatFragment& fragment = flat_.fragments[static_cast<std::size_t>(number)];
  if (fragment.broken) return;
  const std::string place = fragment.pointer.substr(0, fragment.pointer.size() - 4);
  std::vector<Endpoint> inputs;
  for (std::size_t i = 0; i < fragment.description->inputs.size(); ++i) {
    resolve_inputs(number, fragment.description->inputs[i].second, place + "/inputs" + pointer_segment(i) + "/to",
                   inputs);
    inputs.clear();
  }
  for (std::size_t i = 0; i < fragment.description->outputs.size(); ++i) {
    Endpoint output{-1, 0};
    resolve_output(number, fragment.description->outputs[i].second, place + "/outputs" + pointer_segment(i) + "/from",
                   output);
  }
}

void Flattener::resolve_links(int fragment) {
  const NetDescription& net = *flat_.fragments[static_cast<std::size_t>(fragment)].net;
  std::vector<Endpoint> targets;
  for (std::size_t i = 0; i < net.links.size(); ++i) {
    const LinkDescription& description = net.links[i];
    FlatLink link{.delayed = description.delayed, .fragment = fragment, .index = static_cast<int>(i)};
    const std::string pointer = flat_.link_pointer(link);
    Endpoint source{-1, 0};
    const bool found = resolve_output(fragment, description.from, pointer + "/from", source);
    targets.clear();
    resolve_inputs(fragment, description.to, pointer + "/to", targets);
    if (!description.delayed && !description.initial.is_null()) {
      report_.error(Code::kConflict, pointer + "/initial", "only a delayed link has an initial value",
                    "Add \"delayed\": true");
    }
    for (const Endpoint& target : targets) {
      link.to = target.node;
      link.to_port = target.port;
      link.from = found ? source.node : -1;
      link.from_port = source.port;
      connect(link);
    }
  }
}

void Flattener::resolve_demands(int fragment) {
  const NetDescription& net = *flat_.fragments[static_cast<std::size_t>(fragment)].net;
  std::vector<Endpoint> targets;
  for (std::size_t i = 0; i < net.demands.size(); ++i) {
    const DemandDescription& description = net.demands[i];
    FlatDemand demand{.fragment = fragment, .index = static_cast<int>(i)};
    const std::string pointer = flat_.demand_pointer(demand);
    Endpoint source{-1, 0};
    const bool found = resolve_output(fragment, description.from, pointer + "/from", source);
    targets.clear();
    resolve_inputs(fragment, description.to, pointer + "/to", targets);
    if (description.maximum_cycles < 0 || description.minimum_cycles.value_or(0) < 0 ||
        description.minimum_cycles.value_or(0) > description.maximum_cycles) {
      report_.error(Code::kOutOfRange, pointer, "the demanded cycles are no range",
                    "Keep 0 <= minimum_cycles <= maximum_cycles");
    }
    for (const Endpoint& target : targets) {
      if (!found) break;
      demand.from = source.node;
      demand.from_port = source.port;
      demand.to = target.node;
      demand.to_port = target.port;
      flat_.demands.push_back(demand);
    }
  }
}

bool Flattener::split(std::string_view text, std::string_view& id, std::string_view& port, const std::string* pointer) {
  const std::size_t dot = text.rfind('.');
  if (dot == std::string_view::npos || dot == 0 || dot + 1 == text.size()) {
    if (pointer == nullptr) return false;
    report_.error(Code::kUnknownName, *pointer, fmt::format("'{}' names no port", shown(text)),
                  "Name a port as \"id.port\"");
    return false;
  }
  id = text.substr(0, dot);
  port = text.substr(dot + 1);
  return true;
}

const int* Flattener::find_name(int fragment, std::string_view id) {
  const std::string& scope = flat_.fragments[static_cast<std::size_t>(fragment)].id;
  if (!scope.empty()) {
    scratch_.assign(scope);
    scratch_ += '/';
    scratch_ += id;
    id = scratch_;
  }
  const auto found = names_.find(id);
  return found == names_.end() ? nullptr : &found->second;
}

/// Whether a net around the fragment has the id.
bool Flattener::is_outside(int fragment, std::string_view id) {
  while (fragment > 0) {
    fragment = flat_.fragments[static_cast<std::size_t>(fragment)].parent;
    if (find_name(fragment, id) != nullptr) return true;
  }
  return false;
}

void Flattener::unknown_id(int fragment, std::string_view id, const std::string& pointer) {
  const NetDescription& net = *flat_.fragments[static_cast<std::size_t>(fragment)].net;
  const auto choices = [&net] {
    constexpr std::size_t kMost = 2000;
    std::vector<std::string> ids;
    for (const auto& primitive : net.primitives | std::views::take(kMost)) ids.push_back(primitive.id);
    for (const auto& inner : net.fragments | std::views::take(kMost)) ids.push_back(inner.id);
    return ids;
  };
  report_.error(Code::kUnknownName, pointer, fmt::format("there is no primitive or fragment '{}'", shown(id)),
                is_outside(fragment, id)
                    ? "Lead it in or out through a port of the fragment: it lies outside of this one"
                    : report_.nearest(shown(id), choices));
}

void Flattener::unknown_port(std::string_view port, std::string_view owner, std::string_view kind,
                             const std::vector<std::string>& choices, const std::string& pointer) {
  report_.error(Code::kUnknownName, pointer, fmt::format("{} has no {} '{}'", owner, kind, shown(port)),
                choices.empty() ? fmt::format("it has no {}s at all", kind)
                                : report_.nearest(shown(port), [&choices] { return choices; }));
}

bool Flattener::resolve_output(int fragment, std::string_view text, const std::string& pointer, Endpoint& found) {
  // A port of a fragment may lead to a port of a fragment inside it: one level deeper per round. What is wrong further
  // inside has been reported where it stands.
  for (bool report = true;; report = false) {
    std::string_view id, port;
    if (!split(text, id, port, report ? &pointer : nullptr)) return false;
    const int* number = find_name(fragment, id);
    if (number == nullptr) {
      if (report) unknown_id(fragment, id, pointer);
      return false;
    }
    if (*number >= 0) {
      const PrimitiveInfo* info = flat_.primitives[static_cast<std::size_t>(*number)].info;
      if (info == nullptr) return false;  // reported as unknown type
      found = {*number, find_port(info->outputs, port)};
      if (found.port >= 0) return true;
      if (report) {
        unknown_port(port, fmt::format("'{}' ({})", shown(id), info->type), "output", port_names(info->outputs),
                     pointer);
      }
      return false;
    }
    fragment = -1 - *number;
    const FlatFragment& inner = flat_.fragments[static_cast<std::size_t>(fragment)];
    if (inner.broken) return false;
    const auto [first, last] = ports_named(inner.outputs, port);
    if (first == last) {
      if (report) {
        unknown_port(port, fmt::format("fragment '{}'", shown(id)), "output", names_in(inner.outputs), pointer);
      }
      return false;
    }
    text = inner.description->outputs[static_cast<std::size_t>(first->second)].second;
  }
}

void Flattener::resolve_inputs(int fragment, std::string_view text, const std::string& pointer,
                               std::vector<Endpoint>& found) {
  struct Item {
    int fragment;
    std::string_view text;
    bool report;
  };
  std::vector<Item> pending{{fragment, text, true}};
  while (!pending.empty()) {
    const Item item = pending.back();
    pending.pop_back();
    std::string_view id, port;
    if (!split(item.text, id, port, item.report ? &pointer : nullptr)) continue;
    const int* number = find_name(item.fragment, id);
    if (number == nullptr) {
      if (item.report) unknown_id(item.fragment, id, pointer);
      continue;
    }
    if (*number >= 0) {
      const PrimitiveInfo* info = flat_.primitives[static_cast<std::size_t>(*number)].info;
      if (info == nullptr) continue;  // reported as unknown type
      const int index = find_port(info->inputs, port);
      if (index >= 0) {
        found.push_back({*number, index});
      } else if (item.report) {
        unknown_port(port, fmt::format("'{}' ({})", shown(id), info->type), "input", port_names(info->inputs), pointer);
      }
      continue;
    }
    const int inner = -1 - *number;
    if (port == active_port().name) {
      found.push_back({flat_.primitive_count() + inner, 0});
      continue;
    }
    const FlatFragment& target = flat_.fragments[static_cast<std::size_t>(inner)];
    if (target.broken) continue;
    const auto [first, last] = ports_named(target.inputs, port);
    if (first == last && item.report) {
      std::vector<std::string> choices = names_in(target.inputs);
      choices.push_back(active_port().name);
      unknown_port(port, fmt::format("fragment '{}'", shown(id)), "input", choices, pointer);
    }
    for (auto entry = first; entry != last; ++entry) {
      pending.push_back({inner, target.description->inputs[static_cast<std::size_t>(entry->second)].second, false});
    }
  }
}

void Flattener::connect(const FlatLink& link) {
  int& taken =
      flat_.input_link[static_cast<std::size_t>(flat_.input_base[static_cast<std::size_t>(link.to)] + link.to_port)];
  if (taken >= 0) {
    const FlatLink& other = flat_.links[static_cast<std::size_t>(taken)];
    report_.error(
        Code::kDuplicate, flat_.link_pointer(link) + "/to",
        fmt::format("input '{}' is linked twice", flat_.input_name(link.to, link.to_port)),
        fmt::format("Remove one (the other link is {}); fragments that take turns share an input through a Merge",
                    flat_.link_pointer(other)));
    return;
  }
  taken = static_cast<int>(flat_.links.size());
  flat_.links.push_back(link);
  if (link.from < 0) return;
  const PrimitiveInfo::Port& output = flat_.output(link.from, link.from_port);
  const PrimitiveInfo::Port& input = flat_.input(link.to, link.to_port);
  if (output.type != input.type) {
    report_.error(Code::kTypeMismatch, flat_.link_pointer(link),
                  fmt::format("'{}' is {}, but '{}' accepts {}", flat_.output_name(link.from, link.from_port),
                              name_of(output.type), flat_.input_name(link.to, link.to_port), name_of(input.type)),
                  "Put a primitive between that converts it on purpose");
  }
  if (!flat_.is_gate(link.to)) {
    const auto& breaking = flat_.primitives[static_cast<std::size_t>(link.to)].info->loop_breaking_inputs;
    if (std::ranges::find(breaking, input.name) != breaking.end()) flat_.links.back().delayed = true;
  }
}

void Flattener::mark_gated() {
  for (std::size_t f = 1; f < flat_.fragments.size(); ++f) {  // parents stand before their children
    FlatFragment& fragment = flat_.fragments[f];
    const int input = flat_.input_base[static_cast<std::size_t>(flat_.primitive_count()) + f];
    fragment.gated = flat_.input_link[static_cast<std::size_t>(input)] >= 0 ||
                     flat_.fragments[static_cast<std::size_t>(fragment.parent)].gated;
  }
}

void Flattener::check_inputs(int number) {
  const PrimitiveInfo* info = flat_.primitives[static_cast<std::size_t>(number)].info;
  if (info == nullptr) return;
  for (std::size_t i = 0; i < info->inputs.size(); ++i) {
    const int port = static_cast<int>(i);
    const int link =
        flat_.input_link[static_cast<std::size_t>(flat_.input_base[static_cast<std::size_t>(number)] + port)];
    const bool constant = flat_.constant(number, port) != nullptr;
    if (link >= 0 && constant) {
      report_.error(
          Code::kConflict, flat_.primitive_pointer(number) + "/parameters" + pointer_segment(info->inputs[i].name),
          fmt::format("input '{}' has both a link and a constant", flat_.input_name(number, port)),
          fmt::format("Remove one: the link is {}", flat_.link_pointer(flat_.links[static_cast<std::size_t>(link)])));
    } else if (link < 0 && !constant && !info->inputs[i].spec.optional) {
      report_.error(
          Code::kUnlinkedInput, flat_.primitive_pointer(number),
          fmt::format("input '{}' ({}) is not linked", flat_.input_name(number, port), name_of(info->inputs[i].type)),
          fmt::format("Link it, or give it a constant as parameter \"{}\"", info->inputs[i].name));
    }
  }
}

}  // namespace

FlatNet flatten(const NetDescription& net, LoadReport& report) {
  FlatNet flat;
  Flattener(flat, report).run(net);
  return flat;
}

}  // namespace takt::net
