#include "core/net/net_plan.h"

#include <utility>

#include "core/net/compiled_net_impl.h"

namespace takt::net {

SlotShape slot_shape(ValueType type) {
  return visit_type(type, []<class T>(std::type_identity<T>) { return SlotShape{sizeof(Slot<T>), alignof(Slot<T>)}; });
}

namespace {

std::size_t aligned(std::size_t offset, std::size_t alignment) { return (offset + alignment - 1) & ~(alignment - 1); }

class Planner {
 public:
  Planner(const FlatNet& flat, const std::vector<int>& order) : flat_(flat), order_(order) {}

  NetPlan run() {
    plan_.output_place.resize(static_cast<std::size_t>(flat_.output_base.back()));
    plan_.input_place.assign(flat_.input_link.size(), NetPlan::kNowhere);
    place_outputs();
    place_delays();
    place_constants();
    bind_links();
    make_gates();
    make_steps();
    return std::move(plan_);
  }

 private:
  [[nodiscard]] std::size_t input_number(int node, int port) const {
    return static_cast<std::size_t>(flat_.input_base[static_cast<std::size_t>(node)] + port);
  }
  [[nodiscard]] std::size_t& output_place(int node, int port) {
    return plan_.output_place[static_cast<std::size_t>(flat_.output_base[static_cast<std::size_t>(node)] + port)];
  }
  [[nodiscard]] const FlatLink* link_into(int node, int port) const {
    const int link = flat_.input_link[input_number(node, port)];
    return link < 0 ? nullptr : &flat_.links[static_cast<std::size_t>(link)];
  }
  template <class Visit>
  void for_each_input(Visit visit) const {
    for (const int node : order_) {
      for (int port = 0; port < flat_.input_count(node); ++port) visit(node, port);
    }
  }

  std::size_t take(ValueType type) {
    const SlotShape shape = slot_shape(type);
    const std::size_t place = aligned(plan_.size, shape.alignment);
    plan_.size = place + shape.size;
    return place;
  }
  std::size_t add_port(std::string name, ValueType type) {
    const std::size_t place = take(type);
    plan_.ports.push_back({std::move(name), type, place, slot_shape(type).size});
    return place;
  }

  void place_outputs();
  void place_delays();
  void place_constants();
  void bind_links();
  void make_gates();
  void make_steps();

  const FlatNet& flat_;
  const std::vector<int>& order_;
  NetPlan plan_;
  std::vector<int> gate_of_fragment_;
};

void Planner::place_outputs() {
  plan_.ports.reserve(plan_.output_place.size());
  for (const int node : order_) {
    if (!flat_.is_gate(node)) plan_.order.push_back(node);
    for (int port = 0; port < flat_.output_count(node); ++port) {
      output_place(node, port) = add_port(flat_.output_name(node, port), flat_.output(node, port).type);
    }
  }
  plan_.output_count = plan_.ports.size();
}

void Planner::place_delays() {
  for_each_input([&](int node, int port) {
    const FlatLink* link = link_into(node, port);
    if (link == nullptr || !link->delayed || link->from < 0) return;
    const ValueType type = flat_.input(node, port).type;
    const std::size_t memory =
        add_port(flat_.output_name(link->from, link->from_port) + " > " + flat_.input_name(node, port), type);
    plan_.input_place[input_number(node, port)] = memory;
    plan_.delays.push_back({node, port, output_place(link->from, link->from_port), memory, NetPlan::kNowhere,
                            slot_shape(type).size, &flat_.description(*link).initial, link->fragment});
  });
  plan_.slots_size = plan_.size = aligned(plan_.size, Block::kAlignment);
}

void Planner::place_constants() {
  for (NetPlan::Delay& delay : plan_.delays) delay.initial = take(flat_.input(delay.node, delay.port).type);
  for_each_input([&](int node, int port) {
    std::size_t& place = plan_.input_place[input_number(node, port)];
    if (place != NetPlan::kNowhere || flat_.is_gate(node) || flat_.constant(node, port) == nullptr) return;
    place = take(flat_.input(node, port).type);
    plan_.constants.push_back({node, port, place, flat_.constant(node, port)});
  });
}

void Planner::bind_links() {
  for_each_input([&](int node, int port) {
    std::size_t& place = plan_.input_place[input_number(node, port)];
    const FlatLink* link = link_into(node, port);
    if (place != NetPlan::kNowhere || link == nullptr || link->from < 0) return;
    // A link of the wrong type is an error already; nothing may read through it meanwhile.
    if (flat_.output(link->from, link->from_port).type != flat_.input(node, port).type) return;
    place = output_place(link->from, link->from_port);
  });
}

void Planner::make_gates() {
  gate_of_fragment_.assign(flat_.fragments.size(), -1);
  for (std::size_t f = 1; f < flat_.fragments.size(); ++f) {
    const FlatFragment& fragment = flat_.fragments[f];
    if (!fragment.gated) continue;
    gate_of_fragment_[f] = static_cast<int>(plan_.gates.size());
    NetPlan::Gate& gate = plan_.gates.emplace_back();
    gate.parent = gate_of_fragment_[static_cast<std::size_t>(fragment.parent)];
    gate.when_inactive = fragment.description->when_inactive;
    gate.active = plan_.input_place[input_number(flat_.primitive_count() + static_cast<int>(f), 0)];
  }
  // Until here the delays know the fragment in which their link is written.
  for (NetPlan::Delay& delay : plan_.delays) delay.gate = gate_of_fragment_[static_cast<std::size_t>(delay.gate)];
}

void Planner::make_steps() {
  if (plan_.gates.empty()) return;
  std::size_t at = 0;
  for (const int node : order_) {
    const int gate = gate_of_fragment_[static_cast<std::size_t>(flat_.fragment_of(node))];
    if (flat_.is_gate(node)) {
      if (gate >= 0) plan_.steps.push_back({.is_gate = true, .gate = gate});
      continue;
    }
    if (plan_.steps.empty() || plan_.steps.back().is_gate || plan_.steps.back().gate != gate) {
      plan_.steps.push_back({.gate = gate, .begin = at, .end = at});
    }
    plan_.steps.back().end = ++at;
    if (gate < 0) continue;
    for (int port = 0; port < flat_.output_count(node); ++port) {
      plan_.gates[static_cast<std::size_t>(gate)].outputs.push_back(
          {flat_.output(node, port).type, output_place(node, port)});
    }
  }
}

}  // namespace

NetPlan plan_net(const FlatNet& flat, const std::vector<int>& order) { return Planner(flat, order).run(); }

}  // namespace takt::net
