#include "core/net/description.h"

#include <fmt/format.h>

#include "core/base/object_reader.h"

namespace takt::net {
namespace {

using Json = nlohmann::ordered_json;
using Ports = std::vector<std::pair<std::string, std::string>>;

/// Fragments nest at most this deep; the reader below goes level by level, files are bounded to the like anyway.
/// Eleven days at 1 ms: a bound beyond that is a slip.
constexpr double kMostDemandedCycles = 1e9;

PrimitiveDescription read_primitive(const Json& json, const std::string& pointer, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  PrimitiveDescription primitive;
  primitive.id = reader.text("id");
  primitive.type = reader.text("type");
  if (const Json* parameters = reader.object("parameters", false)) primitive.parameters = *parameters;
  if (const Json* on_null = reader.object("on_null", false)) primitive.on_null = *on_null;
  reader.finish();
  return primitive;
}

LinkDescription read_link(const Json& json, const std::string& pointer, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  LinkDescription link;
  link.from = reader.text("from");
  link.to = reader.text("to");
  link.delayed = reader.boolean("delayed", false);
  if (const Json* initial = reader.child("initial")) link.initial = *initial;
  reader.finish();
  return link;
}

DemandDescription read_demand(const Json& json, const std::string& pointer, Diagnostics& diagnostics) {
  ObjectReader reader(json, pointer, diagnostics);
  DemandDescription demand;
  demand.from = reader.text("from");
  demand.to = reader.text("to");
  demand.maximum_cycles = reader.integer("maximum_cycles", {}, {.low = 0.0, .high = kMostDemandedCycles});
  if (reader.has("minimum_cycles")) {
    demand.minimum_cycles =
        reader.integer("minimum_cycles", {}, {.low = 0.0, .high = static_cast<double>(demand.maximum_cycles)});
  }
  reader.finish();
  return demand;
}

Ports read_ports(ObjectReader& reader, std::string_view key, std::string_view inner_key) {
  Ports ports;
  const Json* array = reader.array(key, false);
  for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
    ObjectReader port((*array)[i], reader.at(key) + pointer_segment(i), reader.diagnostics());
    std::string name = port.text("port");
    ports.emplace_back(std::move(name), port.text(inner_key));
    port.finish();
  }
  return ports;
}

/// A "net" object that is still to be read, and where it goes.
struct Pending {
  const Json* json;
  std::string pointer;
  NetDescription* net;
  std::size_t depth;
};

void read_fragments(const Json& array, const std::string& pointer, const Pending& parent, Diagnostics& diagnostics,
                    std::vector<Pending>& pending) {
  NetDescription& net = *parent.net;
  net.fragments.resize(array.size());  // all at once: `pending` keeps pointers into it
  for (std::size_t i = 0; i < array.size(); ++i) {
    FragmentDescription& fragment = net.fragments[i];
    ObjectReader reader(array[i], pointer + pointer_segment(i), diagnostics);
    fragment.id = reader.text("id");
    fragment.when_inactive = reader.choice("when_inactive", {"reset", "keep"}, "reset") == "keep"
                                 ? WhenInactive::kKeep
                                 : WhenInactive::kReset;
    fragment.inputs = read_ports(reader, "inputs", "to");
    fragment.outputs = read_ports(reader, "outputs", "from");
    if (const Json* inner = reader.object("net")) {
      pending.push_back({inner, reader.at("net"), &fragment.net, parent.depth + 1});
    }
    reader.finish();
  }
}

void read_net(const Pending& item, Diagnostics& diagnostics, std::vector<Pending>& pending) {
  if (item.depth > kMaxNesting) {
    diagnostics.error(Code::kTooLarge, item.pointer, fmt::format("fragments nest deeper than {} levels", kMaxNesting));
    return;
  }
  ObjectReader reader(*item.json, item.pointer, diagnostics);
  item.net->name = reader.text("name", "");
  const auto each = [&](std::string_view key, const auto& read) {
    const Json* array = reader.array(key, false);
    for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
      read((*array)[i], reader.at(key) + pointer_segment(i));
    }
  };
  each("primitives", [&](const Json& json, const std::string& pointer) {
    item.net->primitives.push_back(read_primitive(json, pointer, diagnostics));
  });
  each("links", [&](const Json& json, const std::string& pointer) {
    item.net->links.push_back(read_link(json, pointer, diagnostics));
  });
  each("demands", [&](const Json& json, const std::string& pointer) {
    item.net->demands.push_back(read_demand(json, pointer, diagnostics));
  });
  if (const Json* array = reader.array("fragments", false)) {
    read_fragments(*array, reader.at("fragments"), item, diagnostics, pending);
  }
  reader.finish();
}

Json ports_to_json(const Ports& ports, const char* inner_key) {
  Json array = Json::array();
  for (const auto& [name, inner] : ports) array.push_back({{"port", name}, {inner_key, inner}});
  return array;
}

Json link_to_json(const LinkDescription& link) {
  Json json = {{"from", link.from}, {"to", link.to}};
  if (link.delayed) json["delayed"] = true;
  if (!link.initial.is_null()) json["initial"] = link.initial;
  return json;
}

Json demand_to_json(const DemandDescription& demand) {
  Json json = {{"from", demand.from}, {"to", demand.to}, {"maximum_cycles", demand.maximum_cycles}};
  if (demand.minimum_cycles) json["minimum_cycles"] = *demand.minimum_cycles;
  return json;
}

/// All of a net but its fragments.
Json flat_to_json(const NetDescription& net) {
  Json json = Json::object();
  if (!net.name.empty()) json["name"] = net.name;
  Json& primitives = json["primitives"] = Json::array();
  for (const PrimitiveDescription& p : net.primitives) {
    primitives.push_back({{"id", p.id}, {"type", p.type}});
    if (!p.parameters.empty()) primitives.back()["parameters"] = p.parameters;
    if (!p.on_null.empty()) primitives.back()["on_null"] = p.on_null;
  }
  Json& links = json["links"] = Json::array();
  for (const LinkDescription& link : net.links) links.push_back(link_to_json(link));
  for (const DemandDescription& demand : net.demands) json["demands"].push_back(demand_to_json(demand));
  return json;
}

Json fragment_to_json(const FragmentDescription& fragment) {
  return {{"id", fragment.id},
          {"when_inactive", fragment.when_inactive == WhenInactive::kKeep ? "keep" : "reset"},
          {"inputs", ports_to_json(fragment.inputs, "to")},
          {"outputs", ports_to_json(fragment.outputs, "from")},
          {"net", nullptr}};
}

}  // namespace

bool NetDescription::operator==(const NetDescription&) const = default;
bool FragmentDescription::operator==(const FragmentDescription&) const = default;

FragmentList::~FragmentList() {
  using Level = std::vector<FragmentDescription>;
  std::vector<Level> pending;
  if (!empty()) pending.push_back(std::move(static_cast<Level&>(*this)));
  while (!pending.empty()) {
    Level level = std::move(pending.back());
    pending.pop_back();
    for (FragmentDescription& fragment : level) {
      Level& inner = fragment.net.fragments;
      if (!inner.empty()) pending.push_back(std::move(inner));
    }
  }
}

NetDescription& NetDescription::add(std::string id, std::string type, Json parameters) {
  primitives.push_back({std::move(id), std::move(type), std::move(parameters), Json::object()});
  return *this;
}

NetDescription& NetDescription::link(std::string from, std::string to) {
  links.push_back({std::move(from), std::move(to), false, nullptr});
  return *this;
}

NetDescription& NetDescription::demand(std::string from, std::string to, std::int64_t maximum_cycles) {
  demands.push_back({std::move(from), std::move(to), maximum_cycles, std::nullopt});
  return *this;
}

NetDescription& NetDescription::link_delayed(std::string from, std::string to, Json initial) {
  links.push_back({std::move(from), std::move(to), true, std::move(initial)});
  return *this;
}

Result<NetDescription> net_from_json(const Json& json) {
  NetDescription net;
  Diagnostics diagnostics;
  std::vector<Pending> pending{{&json, "", &net, 0}};
  while (!pending.empty()) {
    const Pending item = std::move(pending.back());
    pending.pop_back();
    read_net(item, diagnostics, pending);
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return net;
}

Json net_to_json(const NetDescription& net) {
  Json json;
  std::vector<std::pair<const NetDescription*, Json*>> pending{{&net, &json}};
  while (!pending.empty()) {
    const auto [item, place] = pending.back();
    pending.pop_back();
    *place = flat_to_json(*item);
    if (item->fragments.empty()) continue;
    Json& array = (*place)["fragments"] = Json::array();
    for (const FragmentDescription& fragment : item->fragments) array.push_back(fragment_to_json(fragment));
    for (std::size_t i = 0; i < item->fragments.size(); ++i) {
      pending.emplace_back(&item->fragments[i].net, &array[i]["net"]);
    }
  }
  return json;
}

}  // namespace takt::net
