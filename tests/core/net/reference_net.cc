#include "tests/core/net/reference_net.h"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

#include "core/net/setup_impl.h"
#include "core/net/value_json.h"

namespace takt::net {
namespace {

using Json = nlohmann::ordered_json;

/// A slot of its own on the heap, of a type known at run time.
struct AnySlot {
  explicit AnySlot(ValueType t) : type(t) {
    visit_type(type, [&]<class T>(std::type_identity<T>) {
      bytes.resize((sizeof(Slot<T>) + sizeof(Word) - 1) / sizeof(Word));
      set_null();
    });
  }
  void set_null() {
    visit_type(type, [&]<class T>(std::type_identity<T>) { Out<T>(as<T>()).set_null(); });
  }
  void read(const Json& json) {
    if (json.is_null()) return set_null();
    visit_type(type, [&]<class T>(std::type_identity<T>) {
      T value = null_payload<T>();
      if (!value_from_json(json, value).empty()) throw std::runtime_error("a constant does not fit");
      Out<T>(as<T>()).set(value);
    });
  }
  void copy_from(const AnySlot& other) {
    visit_type(type, [&]<class T>(std::type_identity<T>) {
      if (other.as<T>()->null != 0) return set_null();
      Out<T>(as<T>()).set(other.as<T>()->value);
    });
  }
  template <class T>
  Slot<T>* as() const {
    return reinterpret_cast<Slot<T>*>(const_cast<Word*>(bytes.data()));
  }
  [[nodiscard]] std::string text() const {
    return visit_type(type, [&]<class T>(std::type_identity<T>) -> std::string {
      if (as<T>()->null != 0) return "null";
      std::string out;
      const auto* p = reinterpret_cast<const unsigned char*>(&as<T>()->value);
      for (std::size_t i = 0; i < sizeof(T); ++i) out += fmt::format("{:02x}", p[i]);
      return out;
    });
  }

  struct alignas(32) Word {
    std::array<std::byte, 32> bytes{};
  };
  ValueType type;
  std::vector<Word> bytes = std::vector<Word>(1);
};

std::string join(const std::string& scope, const std::string& id) { return scope.empty() ? id : scope + "/" + id; }

std::pair<std::string, std::string> split(const std::string& port) {
  const std::size_t dot = port.rfind('.');
  return {port.substr(0, dot), port.substr(dot + 1)};
}

}  // namespace

struct ReferenceNet::Node {
  std::string id;
  const PrimitiveDescription* description;
  const PrimitiveInfo* info;
  int group;
  std::map<std::string, std::unique_ptr<AnySlot>> inputs,
      outputs;  ///< an input has a slot of its own: values are copied
  std::unique_ptr<std::byte[]> memory;
  Primitive* primitive = nullptr;
  bool done = false;
  std::vector<std::pair<AnySlot*, Link*>> feeds;  ///< the linked inputs

  ~Node() {
    if (primitive != nullptr) primitive->~Primitive();
  }
};

struct ReferenceNet::Group {
  int parent;
  bool can_rest = false;
  WhenInactive when_inactive;
  std::string active_input;  ///< "path.active"
  bool known = false, running = true, begun = false, restarted = false;
  std::int64_t cycles = 0;
};

struct ReferenceNet::Link {
  Node* from;
  std::string to;
  bool delayed;
  Json initial;
  int group;
  std::unique_ptr<AnySlot> memory;
  AnySlot* source;  ///< the output it reads
};

ReferenceNet::~ReferenceNet() = default;

ReferenceNet::ReferenceNet(const NetDescription& description) {
  groups_.push_back(
      std::make_unique<Group>(Group{.parent = -1, .when_inactive = WhenInactive::kReset, .active_input = {}}));
  build(description, "", 0);
  int group = 0;
  connect(description, "", group);
  // Fragments were numbered in the order of build: depth first.
  struct Item {
    const NetDescription* net;
    std::string scope;
  };
  std::vector<Item> pending{{&description, ""}};
  for (std::size_t i = 0; i < pending.size(); ++i) {
    const Item item = pending[i];
    for (const FragmentDescription& f : item.net->fragments) {
      const std::string scope = join(item.scope, f.id);
      for (std::size_t g = 1; g < groups_.size(); ++g) {
        if (groups_[g]->active_input == scope + ".active") group = static_cast<int>(g);
      }
      connect(f.net, scope, group);
      pending.push_back({&f.net, scope});
    }
  }
  find_feeds();
  for (std::size_t g = 1; g < groups_.size(); ++g) {
    groups_[g]->can_rest = link_into_.contains(groups_[g]->active_input) ||
                           groups_[static_cast<std::size_t>(groups_[g]->parent)]->can_rest;
  }
}

/// What feeds each node, by name once and not in every cycle.
void ReferenceNet::find_feeds() {
  for (const auto& node : nodes_) {
    for (const auto& [name, slot] : node->inputs) {
      const auto link = link_into_.find(node->id + "." + name);
      if (link != link_into_.end()) node->feeds.emplace_back(slot.get(), link->second);
    }
  }
}

void ReferenceNet::build(const NetDescription& description, const std::string& scope, int group) {
  for (const PrimitiveDescription& p : description.primitives) {
    auto node = std::make_unique<Node>();
    node->id = join(scope, p.id);
    node->description = &p;
    node->info = Registry::global().find(p.type);
    node->group = group;
    std::vector<const void*> inputs;
    std::vector<void*> outputs;
    for (const auto& port : node->info->inputs) {
      auto& slot = node->inputs[port.name] = std::make_unique<AnySlot>(port.type);
      if (p.parameters.contains(port.name)) slot->read(p.parameters.at(port.name));
      inputs.push_back(slot->bytes.data());
    }
    for (const auto& port : node->info->outputs) {
      outputs.push_back((node->outputs[port.name] = std::make_unique<AnySlot>(port.type))->bytes.data());
    }
    Setup::Impl impl;
    impl.info = node->info;
    impl.parameters = &p.parameters;
    impl.inputs = inputs;
    impl.outputs = outputs;
    Setup setup(impl);
    const Maker& maker = *Registry::global().maker(p.type);
    node->memory = std::make_unique<std::byte[]>(maker.size);
    node->primitive = maker.construct(node->memory.get(), setup);
    nodes_.push_back(std::move(node));
  }
  for (const FragmentDescription& f : description.fragments) {
    const std::string inner = join(scope, f.id);
    fragments_[inner] = &f;
    groups_.push_back(std::make_unique<Group>(
        Group{.parent = group, .when_inactive = f.when_inactive, .active_input = inner + ".active"}));
    build(f.net, inner, static_cast<int>(groups_.size()) - 1);
  }
}

std::string ReferenceNet::output_port(const std::string& scope, const std::string& port) const {
  const auto [id, name] = split(port);
  const auto fragment = fragments_.find(join(scope, id));
  if (fragment == fragments_.end()) return join(scope, port);
  for (const auto& [outer, inner] : fragment->second->outputs) {
    if (outer == name) return output_port(fragment->first, inner);
  }
  throw std::runtime_error("no such output");
}

std::vector<std::string> ReferenceNet::input_ports(const std::string& scope, const std::string& port) const {
  const auto [id, name] = split(port);
  const auto fragment = fragments_.find(join(scope, id));
  if (fragment == fragments_.end() || name == "active") return {join(scope, port)};
  std::vector<std::string> all;
  for (const auto& [outer, inner] : fragment->second->inputs) {
    if (outer != name) continue;
    for (std::string& found : input_ports(fragment->first, inner)) all.push_back(std::move(found));
  }
  return all;
}

void ReferenceNet::connect(const NetDescription& description, const std::string& scope, int group) {
  for (const LinkDescription& l : description.links) {
    const auto [from_id, from_port] = split(output_port(scope, l.from));
    Node* from = nullptr;
    for (const auto& node : nodes_) {
      if (node->id == from_id) from = node.get();
    }
    for (const std::string& to : input_ports(scope, l.to)) {
      bool delayed = l.delayed;
      const auto [to_id, to_port] = split(to);
      for (const auto& node : nodes_) {
        if (node->id != to_id) continue;
        for (const std::string& breaking : node->info->loop_breaking_inputs) delayed = delayed || breaking == to_port;
      }
      auto link = std::make_unique<Link>(Link{from, to, delayed, l.initial, group,
                                              std::make_unique<AnySlot>(from->outputs.at(from_port)->type),
                                              from->outputs.at(from_port).get()});
      link->memory->read(l.initial);
      link_into_[to] = link.get();
      links_.push_back(std::move(link));
    }
  }
}

/// A node may run when its fragment has been looked at and all it reads in this cycle is done.
bool ReferenceNet::ready(const Node& node) const {
  if (node.done || !groups_[static_cast<std::size_t>(node.group)]->known) return false;
  return std::ranges::all_of(node.feeds, [](const auto& f) { return f.second->delayed || f.second->from->done; });
}

void ReferenceNet::look_at(Group& group, const Cycle&) {
  const Group& parent = *groups_[static_cast<std::size_t>(group.parent)];
  bool active = parent.running;
  const auto found = link_into_.find(group.active_input);
  if (found != link_into_.end()) {
    const AnySlot& slot = found->second->delayed ? *found->second->memory : *found->second->source;
    active = active && slot.as<Boolean>()->null == 0 && slot.as<Boolean>()->value;
  }
  if (parent.restarted) group.begun = false;
  const bool was_running = group.running && group.can_rest && group.cycles > 0;
  group.restarted = active && !group.begun;
  if (group.restarted) {
    group.cycles = 0;
    group.begun = true;
    for (const auto& link : links_) {
      if (groups_[static_cast<std::size_t>(link->group)].get() == &group && group.can_rest)
        link->memory->read(link->initial);
    }
  }
  if (!active && was_running && group.when_inactive == WhenInactive::kReset) group.begun = false;
  group.running = active;
  group.known = true;
}

void ReferenceNet::update(Node& node, const Cycle& outer) {
  node.done = true;
  const Group& group = *groups_[static_cast<std::size_t>(node.group)];
  if (!group.running) {
    for (const auto& [name, slot] : node.outputs) slot->set_null();
    return;
  }
  for (const auto& [slot, link] : node.feeds) slot->copy_from(link->delayed ? *link->memory : *link->source);
  // What the net declares about null: here the value itself stands in for it.
  for (const auto& [name, meaning] : node.description->on_null.items()) {
    AnySlot& slot = *node.inputs.at(name);
    if (slot.as<Boolean>()->null != 0) slot.read(meaning);
  }
  Cycle cycle = outer;
  cycle.index_in_net = group.cycles;
  cycle.first = group.cycles == 0;
  cycle.signals = &signals_;
  node.primitive->update(cycle);
}

void ReferenceNet::evaluate(const Cycle& cycle) {
  for (const auto& node : nodes_) node->done = false;
  for (const auto& group : groups_) group->known = false;
  groups_[0]->known = true;
  for (bool progress = true; progress;) {
    progress = false;
    for (std::size_t g = 1; g < groups_.size(); ++g) {
      Group& group = *groups_[g];
      const auto link = link_into_.find(group.active_input);
      const bool fed = link == link_into_.end() || link->second->delayed || link->second->from->done;
      if (group.known || !fed || !groups_[static_cast<std::size_t>(group.parent)]->known) continue;
      look_at(group, cycle);
      progress = true;
    }
    for (const auto& node : nodes_) {
      if (!ready(*node)) continue;
      update(*node, cycle);
      progress = true;
    }
  }
  for (const auto& node : nodes_) {
    if (!node->done) throw std::runtime_error(node->id + " never became ready");
  }
  for (const auto& link : links_) {
    if (link->delayed && groups_[static_cast<std::size_t>(link->group)]->running) {
      link->memory->copy_from(*link->source);
    }
  }
  for (const auto& group : groups_) {
    if (group->running) ++group->cycles;
  }
}

std::map<std::string, std::string> ReferenceNet::outputs() const {
  std::map<std::string, std::string> all;
  for (const auto& node : nodes_) {
    for (const auto& [name, slot] : node->outputs) all[node->id + "." + name] = slot->text();
  }
  return all;
}

std::vector<ReferenceNet::Output> ReferenceNet::output_slots() const {
  std::vector<Output> all;
  for (const auto& node : nodes_) {
    for (const auto& [name, slot] : node->outputs)
      all.push_back({node->id + "." + name, slot->type, slot->bytes.data()});
  }
  return all;
}

}  // namespace takt::net
