#include <algorithm>
#include <exception>
#include <unordered_map>

#include <fmt/format.h>

#include "core/net/compiled_net_impl.h"
#include "core/net/flat_net.h"
#include "core/net/frame_check.h"
#include "core/net/null_paths.h"
#include "core/net/reaction.h"
#include "core/net/schedule.h"
#include "core/net/setup_impl.h"
#include "core/net/unit_check.h"
#include "core/net/value_json.h"

namespace takt::net {
namespace {

using Json = nlohmann::ordered_json;

std::size_t aligned(std::size_t offset, std::size_t alignment) { return (offset + alignment - 1) & ~(alignment - 1); }

struct Shape {
  std::size_t size, alignment;
};

Shape slot_shape(ValueType type) {
  return visit_type(type, []<class T>(std::type_identity<T>) { return Shape{sizeof(Slot<T>), alignof(Slot<T>)}; });
}

/// Hands out places in a block that is allocated once all are known.
class Layout {
 public:
  std::size_t take(Shape shape) {
    const std::size_t place = aligned(size_, shape.alignment);
    size_ = place + shape.size;
    return place;
  }
  std::size_t take(ValueType type) { return take(slot_shape(type)); }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::size_t size_ = 0;
};

/// Every slot starts as null; a JSON value other than null is written into it.
Findings write_slot(ValueType type, std::byte* place, const Json* json) {
  return visit_type(type, [&]<class T>(std::type_identity<T>) {
    Out<T> out(reinterpret_cast<Slot<T>*>(place));
    out.set_null();
    if (json == nullptr || json->is_null()) return Findings();
    T value = null_payload<T>();
    Findings findings = value_from_json(*json, value);
    if (findings.empty()) out.set(value);
    return findings;
  });
}

const void* null_slot(ValueType type) {
  return visit_type(type, []<class T>(std::type_identity<T>) { return static_cast<const void*>(&kNullSlot<T>); });
}

}  // namespace

/// Lays out, constructs and binds the primitives of a flat net. Findings go to the report; with errors in it the
/// result is of no use.
class Builder {
 public:
  Builder(const FlatNet& flat, const std::vector<int>& order, Environment& environment, LoadReport& report,
          CompiledNet::Impl& net)
      : flat_(flat), order_(order), environment_(environment), report_(report), net_(net) {}

  void run() {
    lay_out();
    write_initial_values();
    make_primitives();
    make_gates();
    make_delays();
  }

 private:
  static constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);

  [[nodiscard]] std::size_t input_number(int node, int port) const {
    return static_cast<std::size_t>(flat_.input_base[static_cast<std::size_t>(node)] + port);
  }
  [[nodiscard]] std::size_t output_number(int node, int port) const {
    return static_cast<std::size_t>(flat_.output_base[static_cast<std::size_t>(node)] + port);
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

  void lay_out();
  void write_initial_values();
  void make_primitives();
  void make_primitive(int primitive, std::byte* place);
  void collect_monitors(int primitive);
  void make_gates();
  void make_delays();
  [[nodiscard]] const void* bound_slot(int node, int port) const;

  const FlatNet& flat_;
  const std::vector<int>& order_;
  Environment& environment_;
  LoadReport& report_;
  CompiledNet::Impl& net_;
  std::vector<std::size_t> output_place_;  ///< offset in `values`, per output
  std::vector<std::size_t> input_place_;   ///< of the delay memory or constant that an input has; kNowhere if none
  std::vector<std::size_t> initial_place_;
  std::vector<int> gate_of_fragment_;
  std::vector<const void*> inputs_;
  std::vector<void*> outputs_;
};

void Builder::lay_out() {
  Layout layout;
  output_place_.resize(static_cast<std::size_t>(flat_.output_base.back()));
  input_place_.assign(flat_.input_link.size(), kNowhere);
  initial_place_.assign(flat_.input_link.size(), kNowhere);
  net_.ports.reserve(output_place_.size());
  const auto add_port = [&](std::string name, ValueType type) {
    const std::size_t place = layout.take(type);
    net_.ports.push_back({std::move(name), type, place, slot_shape(type).size});
    return place;
  };
  for (const int node : order_) {
    for (int port = 0; port < flat_.output_count(node); ++port) {
      output_place_[output_number(node, port)] = add_port(flat_.output_name(node, port), flat_.output(node, port).type);
    }
  }
  const std::size_t output_count = net_.ports.size();
  for_each_input([&](int node, int port) {
    const FlatLink* link = link_into(node, port);
    if (link == nullptr || !link->delayed || link->from < 0) return;
    input_place_[input_number(node, port)] =
        add_port(flat_.output_name(link->from, link->from_port) + " > " + flat_.input_name(node, port),
                 flat_.input(node, port).type);
  });
  net_.slots_size = aligned(layout.size(), Block::kAlignment);
  layout.take({0, Block::kAlignment});
  for_each_input([&](int node, int port) {
    const std::size_t number = input_number(node, port);
    if (input_place_[number] != kNowhere) {
      initial_place_[number] = layout.take(flat_.input(node, port).type);
    } else if (!flat_.is_gate(node) && flat_.constant(node, port) != nullptr) {
      input_place_[number] = layout.take(flat_.input(node, port).type);
    }
  });
  net_.values = Block(layout.size() + Block::kAlignment);
  net_.port_by_name.reserve(output_count);
  for (std::size_t i = 0; i < output_count; ++i) net_.port_by_name.emplace(net_.ports[i].name, i);
}

void Builder::write_initial_values() {
  for (const auto& port : net_.ports) (void)write_slot(port.type, net_.values.at(port.offset), nullptr);
  for_each_input([&](int node, int port) {
    const std::size_t number = input_number(node, port);
    if (input_place_[number] == kNowhere) return;
    const ValueType type = flat_.input(node, port).type;
    if (initial_place_[number] == kNowhere) {
      const Findings findings = write_slot(type, net_.values.at(input_place_[number]), flat_.constant(node, port));
      if (findings.empty()) return;
      report_.append(findings,
                     flat_.primitive_pointer(node) + "/parameters" + pointer_segment(flat_.input(node, port).name));
      return;
    }
    const FlatLink& link = *link_into(node, port);
    const Json& initial = flat_.description(link).initial;
    const Findings findings = write_slot(type, net_.values.at(initial_place_[number]), &initial);
    if (!findings.empty()) report_.append(findings, flat_.link_pointer(link) + "/initial");
    std::memcpy(net_.values.at(input_place_[number]), net_.values.at(initial_place_[number]), slot_shape(type).size);
  });
}

const void* Builder::bound_slot(int node, int port) const {
  const std::size_t number = input_number(node, port);
  if (input_place_[number] != kNowhere) return net_.values.at(input_place_[number]);
  const FlatLink* link = link_into(node, port);
  const ValueType type = flat_.input(node, port).type;
  // A link of the wrong type is an error already; nothing may read through it meanwhile.
  if (link == nullptr || link->from < 0 || flat_.output(link->from, link->from_port).type != type)
    return null_slot(type);
  return net_.values.at(output_place_[output_number(link->from, link->from_port)]);
}

void Builder::make_primitives() {
  Layout layout;
  std::vector<std::pair<int, std::size_t>> places;
  for (const int node : order_) {
    if (flat_.is_gate(node)) continue;
    const Maker* maker = flat_.primitives[static_cast<std::size_t>(node)].maker;
    if (maker != nullptr) places.emplace_back(node, layout.take({maker->size, maker->alignment}));
  }
  net_.objects = Block(layout.size() + Block::kAlignment);
  net_.primitives.reserve(places.size());
  net_.ids.reserve(places.size());
  for (const auto& [node, place] : places) make_primitive(node, net_.objects.at(place));
}

void Builder::make_primitive(int number, std::byte* place) {
  const FlatPrimitive& primitive = flat_.primitives[static_cast<std::size_t>(number)];
  if (!primitive.description->parameters.is_object()) return;  // reported
  inputs_.clear();
  for (int port = 0; port < flat_.input_count(number); ++port) inputs_.push_back(bound_slot(number, port));
  outputs_.clear();
  for (int port = 0; port < flat_.output_count(number); ++port) {
    outputs_.push_back(net_.values.at(output_place_[output_number(number, port)]));
  }
  Setup::Impl impl;
  impl.info = primitive.info;
  impl.parameters = &primitive.description->parameters;
  impl.inputs = inputs_;
  impl.outputs = outputs_;
  impl.environment = &environment_;
  Setup setup(impl);
  try {
    Primitive* made = primitive.maker->construct(place, setup);
    net_.primitives.push_back(made);
    net_.ids.push_back(primitive.id);
    if (!impl.findings.has_errors()) impl.findings.append(made->prepare());
  } catch (const std::exception& error) {
    impl.findings.error({}, fmt::format("{} cannot be made: {}", primitive.info->type, error.what()));
  }
  if (!impl.findings.empty()) report_.append(impl.findings, flat_.primitive_pointer(number) + "/parameters");
  for (Resource* claimed : impl.claims) net_.claims.push_back(claimed);
  collect_monitors(number);
}

void Builder::collect_monitors(int number) {
  const FlatPrimitive& primitive = flat_.primitives[static_cast<std::size_t>(number)];
  if (!primitive.info->monitor) return;
  for (int port = 0; port < flat_.input_count(number); ++port) {
    const auto& input = flat_.input(number, port);
    const bool several = flat_.input_count(number) > 1;
    net_.monitors.push_back({several ? primitive.id + "." + input.name : primitive.id, input.type,
                             inputs_[static_cast<std::size_t>(port)]});
  }
}

void Builder::make_gates() {
  gate_of_fragment_.assign(flat_.fragments.size(), -1);
  for (std::size_t f = 1; f < flat_.fragments.size(); ++f) {
    const FlatFragment& fragment = flat_.fragments[f];
    if (!fragment.gated) continue;
    gate_of_fragment_[f] = static_cast<int>(net_.gates.size());
    CompiledNet::Impl::Gate& gate = net_.gates.emplace_back();
    gate.parent = gate_of_fragment_[static_cast<std::size_t>(fragment.parent)];
    gate.when_inactive = fragment.description->when_inactive;
    const int node = flat_.primitive_count() + static_cast<int>(f);
    if (link_into(node, 0) != nullptr) gate.active = static_cast<const Slot<Boolean>*>(bound_slot(node, 0));
  }
  if (net_.gates.empty()) return;
  std::size_t at = 0;
  for (const int node : order_) {
    const int gate = gate_of_fragment_[static_cast<std::size_t>(flat_.fragment_of(node))];
    if (flat_.is_gate(node)) {
      if (gate >= 0) net_.steps.push_back({.is_gate = true, .gate = gate});
      continue;
    }
    if (net_.steps.empty() || net_.steps.back().is_gate || net_.steps.back().gate != gate) {
      net_.steps.push_back({.gate = gate, .begin = at, .end = at});
    }
    net_.steps.back().end = ++at;
    if (gate < 0) continue;
    for (int port = 0; port < flat_.output_count(node); ++port) {
      net_.gates[static_cast<std::size_t>(gate)].outputs.emplace_back(
          flat_.output(node, port).type, net_.values.at(output_place_[output_number(node, port)]));
    }
  }
}

void Builder::make_delays() {
  for_each_input([&](int node, int port) {
    const std::size_t number = input_number(node, port);
    const FlatLink* link = link_into(node, port);
    if (link == nullptr || initial_place_[number] == kNowhere) return;
    const CompiledNet::Impl::Delay delay{net_.values.at(output_place_[output_number(link->from, link->from_port)]),
                                         net_.values.at(input_place_[number]), net_.values.at(initial_place_[number]),
                                         slot_shape(flat_.input(node, port).type).size};
    const int gate = gate_of_fragment_[static_cast<std::size_t>(link->fragment)];
    (gate < 0 ? net_.delays : net_.gates[static_cast<std::size_t>(gate)].delays).push_back(delay);
  });
}

namespace {

void check_termination(const FlatNet& flat, LoadReport& report) {
  if (std::ranges::any_of(flat.primitives,
                          [](const FlatPrimitive& p) { return p.info != nullptr && p.info->termination; })) {
    return;
  }
  report.error("/primitives", "the net has no Termination, so it could never end",
               "add a primitive of type Termination and link its input");
}

/// One device, one primitive that drives it (row O4).
void check_claims(const FlatNet& flat, NetReport& net_report, LoadReport& report) {
  std::unordered_map<std::string, int> first;
  for (int p = 0; p < flat.primitive_count(); ++p) {
    const FlatPrimitive& primitive = flat.primitives[static_cast<std::size_t>(p)];
    if (primitive.info == nullptr || primitive.info->claims.empty() || !primitive.description->parameters.is_object())
      continue;
    const auto device = primitive.description->parameters.find(primitive.info->claims);
    if (device == primitive.description->parameters.end() || !device->is_string()) continue;
    const auto [other, fresh] = first.emplace(device->get<std::string>(), p);
    if (fresh) {
      net_report.resources.push_back(other->first);
      continue;
    }
    report.error(flat.primitive_pointer(p) + "/parameters" + pointer_segment(primitive.info->claims),
                 fmt::format("device '{}' is driven by both '{}' and '{}'", shown(other->first), flat.id(other->second),
                             primitive.id),
                 "one primitive drives a device");
  }
  std::ranges::sort(net_report.resources);
}

void note_latencies(const FlatNet& flat, LoadReport& report) {
  for (int p = 0; p < flat.primitive_count(); ++p) {
    for (const auto& entry : flat.primitives[static_cast<std::size_t>(p)].info->latencies) {
      if (!entry.latency.data_dependent) continue;
      report.note(flat.primitive_pointer(p), fmt::format("the latency from '{}.{}' to '{}.{}' depends on data",
                                                         flat.id(p), entry.in, flat.id(p), entry.out));
    }
  }
}

}  // namespace

Result<std::unique_ptr<CompiledNet>> CompiledNet::compile(const NetDescription& description, Environment& environment) {
  LoadReport report;
  const FlatNet flat = flatten(description, report);
  const std::vector<int> order = schedule(flat, report);
  std::unique_ptr<CompiledNet> net(new CompiledNet());
  Impl& impl = *net->impl_;
  impl.name = description.name;
  check_termination(flat, report);
  check_claims(flat, impl.report, report);
  check_units(flat, report);
  check_frames(flat, report);
  Builder(flat, order, environment, report, impl).run();
  if (report.has_errors()) return std::unexpected(report.take());
  note_null_paths(flat, report);
  note_latencies(flat, report);
  impl.report.order = impl.ids;
  impl.report.reactions = reactions(flat, report);
  impl.report.notes = report.take();
  return net;
}

}  // namespace takt::net
