#include <algorithm>
#include <exception>

#include <fmt/format.h>

#include "core/net/compiled_net_impl.h"
#include "core/net/composite.h"
#include "core/net/exclusion.h"
#include "core/net/flat_net.h"
#include "core/net/frame_check.h"
#include "core/net/net_plan.h"
#include "core/net/null_paths.h"
#include "core/net/reaction.h"
#include "core/net/schedule.h"
#include "core/net/setup_impl.h"
#include "core/net/unit_check.h"
#include "core/net/value_json.h"

namespace takt::net {
namespace {

using Json = nlohmann::ordered_json;

/// Every slot starts as null; a JSON value other than null is written into it.
Diagnostics write_slot(ValueType type, std::byte* place, const Json* json) {
  return visit_type(type, [&]<class T>(std::type_identity<T>) {
    Out<T> out(reinterpret_cast<Slot<T>*>(place));
    out.set_null();
    if (json == nullptr || json->is_null()) return Diagnostics();
    T value = null_payload<T>();
    Diagnostics diagnostics = value_from_json(*json, value);
    if (diagnostics.empty()) out.set(value);
    return diagnostics;
  });
}

/// What a claim holds in the end. The depth is that of composites in composites, which their makers have bounded.
void collect_leaves(Resource* resource, std::vector<Resource*>& leaves) {
  const auto* whole = dynamic_cast<const Composite*>(resource);
  if (whole == nullptr) return leaves.push_back(resource);
  for (Resource* part : whole->parts()) collect_leaves(part, leaves);
}

const void* null_slot(ValueType type) {
  return visit_type(type, []<class T>(std::type_identity<T>) { return static_cast<const void*>(&kNullSlot<T>); });
}

}  // namespace

/// Makes the primitives of a flat net and binds them as the plan says. Diagnostics go to the report; with errors in it
/// the result is of no use.
class Builder {
 public:
  Builder(const FlatNet& flat, NetPlan plan, Environment& environment, LoadReport& report, CompiledNet::Impl& net)
      : flat_(flat), plan_(std::move(plan)), environment_(environment), report_(report), net_(net) {}

  void run() {
    write_initial_values();
    make_primitives();
    make_gates();
    make_delays();
  }

 private:
  void write_initial_values();
  void make_primitives();
  void make_primitive(int primitive, std::byte* place);
  void take_claims(int primitive, const std::vector<Resource*>& claims);
  void collect_monitors(int primitive);
  void make_gates();
  void make_delays();
  [[nodiscard]] const FlatLink& link_of(const NetPlan::Delay& delay) const;
  [[nodiscard]] const void* bound_slot(int node, int port) const;

  const FlatNet& flat_;
  NetPlan plan_;
  Environment& environment_;
  LoadReport& report_;
  CompiledNet::Impl& net_;
  std::vector<const void*> inputs_;
  std::vector<void*> outputs_;
  /// Per device that is driven: what was named to claim it, itself or a whole that it belongs to, and by whom.
  std::unordered_map<const Resource*, std::pair<const Resource*, int>> claimed_;
};

const FlatLink& Builder::link_of(const NetPlan::Delay& delay) const {
  const int number = flat_.input_base[static_cast<std::size_t>(delay.node)] + delay.port;
  return flat_.links[static_cast<std::size_t>(flat_.input_link[static_cast<std::size_t>(number)])];
}

void Builder::write_initial_values() {
  net_.ports = std::move(plan_.ports);
  net_.slots_size = plan_.slots_size;
  net_.values = Block(plan_.size + Block::kAlignment);
  net_.port_by_name.reserve(plan_.output_count);
  for (std::size_t i = 0; i < plan_.output_count; ++i) net_.port_by_name.emplace(net_.ports[i].name, i);
  for (const auto& port : net_.ports) (void)write_slot(port.type, net_.values.at(port.offset), nullptr);
  for (const NetPlan::Constant& constant : plan_.constants) {
    const auto& input = flat_.input(constant.node, constant.port);
    const Diagnostics diagnostics = write_slot(input.type, net_.values.at(constant.place), constant.value);
    if (diagnostics.empty()) continue;
    report_.append(diagnostics, flat_.primitive_pointer(constant.node) + "/parameters" + pointer_segment(input.name));
  }
  for (const NetPlan::Delay& delay : plan_.delays) {
    const ValueType type = flat_.input(delay.node, delay.port).type;
    const Diagnostics diagnostics = write_slot(type, net_.values.at(delay.initial), delay.initial_value);
    if (!diagnostics.empty()) report_.append(diagnostics, flat_.link_pointer(link_of(delay)) + "/initial");
    std::memcpy(net_.values.at(delay.memory), net_.values.at(delay.initial), slot_shape(type).size);
  }
}

const void* Builder::bound_slot(int node, int port) const {
  const int number = flat_.input_base[static_cast<std::size_t>(node)] + port;
  const std::size_t place = plan_.input_place[static_cast<std::size_t>(number)];
  return place == NetPlan::kNowhere ? null_slot(flat_.input(node, port).type) : net_.values.at(place);
}

void Builder::make_primitives() {
  std::vector<std::pair<int, std::size_t>> places;
  std::size_t size = 0;
  for (const int primitive : plan_.order) {
    const Maker* maker = flat_.primitives[static_cast<std::size_t>(primitive)].maker;
    if (maker == nullptr) continue;  // reported
    size = (size + maker->alignment - 1) & ~(maker->alignment - 1);
    places.emplace_back(primitive, size);
    size += maker->size;
  }
  net_.objects = Block(size + Block::kAlignment);
  net_.primitives.reserve(places.size());
  net_.ids.reserve(places.size());
  for (const auto& [primitive, place] : places) make_primitive(primitive, net_.objects.at(place));
}

void Builder::make_primitive(int number, std::byte* place) {
  const FlatPrimitive& primitive = flat_.primitives[static_cast<std::size_t>(number)];
  if (!primitive.description->parameters.is_object()) return;  // reported
  inputs_.clear();
  for (int port = 0; port < flat_.input_count(number); ++port) inputs_.push_back(bound_slot(number, port));
  outputs_.clear();
  for (int port = 0; port < flat_.output_count(number); ++port) {
    outputs_.push_back(net_.values.at(
        plan_.output_place[static_cast<std::size_t>(flat_.output_base[static_cast<std::size_t>(number)] + port)]));
  }
  Setup::Impl impl;
  impl.info = primitive.info;
  impl.id = &primitive.id;
  impl.parameters = &primitive.description->parameters;
  impl.on_null = &primitive.description->on_null;
  impl.inputs = inputs_;
  impl.outputs = outputs_;
  impl.environment = &environment_;
  Setup setup(impl);
  try {
    Primitive* made = primitive.maker->construct(place, setup);
    net_.primitives.push_back(made);
    net_.ids.push_back(primitive.id);
    net_.numbers.push_back(number);
    if (!impl.diagnostics.has_errors()) impl.diagnostics.append(made->prepare());
  } catch (const std::exception& error) {
    impl.diagnostics.error(Code::kInternal, {},
                           fmt::format("{} cannot be made: {}", primitive.info->type, error.what()));
  }
  if (!impl.diagnostics.empty()) report_.append(impl.diagnostics, flat_.primitive_pointer(number) + "/parameters");
  take_claims(number, impl.claims);
  net_.claim_states.insert(net_.claim_states.end(), impl.claim_states.begin(), impl.claim_states.end());
  collect_monitors(number);
}

/// A whole is claimed with all its parts: who names it and who names a part of it want the same thing.
void Builder::take_claims(int number, const std::vector<Resource*>& claims) {
  const FlatPrimitive& primitive = flat_.primitives[static_cast<std::size_t>(number)];
  for (Resource* named : claims) {
    std::vector<Resource*> leaves;
    collect_leaves(named, leaves);
    for (Resource* leaf : leaves) {
      net_.drivers.emplace_back(leaf, number);
      const auto [claim, fresh] = claimed_.try_emplace(leaf, std::pair{static_cast<const Resource*>(named), number});
      if (fresh) net_.claims.push_back(leaf);
      if (fresh || claim->second.first == named) continue;
      const auto name_at = [this](int p) {
        const FlatPrimitive& one = flat_.primitives[static_cast<std::size_t>(p)];
        return shown(one.description->parameters.at(one.info->claims).get<std::string>());
      };
      report_.error(Code::kResourceConflict,
                    flat_.primitive_pointer(number) + "/parameters" + pointer_segment(primitive.info->claims),
                    fmt::format("'{}' drives '{}', which shares a part with '{}' that '{}' drives", primitive.id,
                                name_at(number), name_at(claim->second.second), flat_.id(claim->second.second)),
                    "Drive the whole, or its parts one by one");
      break;
    }
  }
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
  for (const NetPlan::Gate& planned : plan_.gates) {
    CompiledNet::Impl::Gate& gate = net_.gates.emplace_back();
    gate.parent = planned.parent;
    gate.when_inactive = planned.when_inactive;
    if (planned.active != NetPlan::kNowhere) {
      gate.active = reinterpret_cast<const Slot<Boolean>*>(net_.values.at(planned.active));
    }
    for (const auto& [type, place] : planned.outputs) gate.outputs.emplace_back(type, net_.values.at(place));
  }
  net_.steps = std::move(plan_.steps);
}

void Builder::make_delays() {
  for (const NetPlan::Delay& planned : plan_.delays) {
    const CompiledNet::Impl::Delay delay{net_.values.at(planned.source), net_.values.at(planned.memory),
                                         net_.values.at(planned.initial), planned.size};
    (planned.gate < 0 ? net_.delays : net_.gates[static_cast<std::size_t>(planned.gate)].delays).push_back(delay);
  }
}

namespace {

void check_termination(const FlatNet& flat, LoadReport& report) {
  if (std::ranges::any_of(flat.primitives,
                          [](const FlatPrimitive& p) { return p.info != nullptr && p.info->termination; })) {
    return;
  }
  report.error(Code::kMissing, "/primitives", "the net has no Termination, so it could never end",
               "Add a primitive of type Termination and link its input");
}

/// Fragments, primitives and links as data.
void describe(const FlatNet& flat, const std::vector<int>& order, NetReport& net_report) {
  for (const FlatFragment& f : flat.fragments) {
    net_report.fragments.push_back(
        {f.id, f.parent, f.gated, f.description == nullptr ? WhenInactive::kReset : f.description->when_inactive});
  }
  net_report.primitives.reserve(flat.primitives.size());
  for (int i = 0; i < flat.primitive_count(); ++i) {
    const FlatPrimitive& p = flat.primitives[static_cast<std::size_t>(i)];
    auto& known = net_report.primitives.emplace_back(NetReport::Primitive{p.id, p.info, p.fragment, 0});
    for (const auto& entry : p.info->latencies)
      known.latencies.push_back({entry.in, entry.out, flat.latency(i, entry), entry.cycles_parameter});
  }
  int place = 0;
  for (const int node : order) {
    if (!flat.is_gate(node)) net_report.primitives[static_cast<std::size_t>(node)].order = place++;
  }
  net_report.links.reserve(flat.links.size());
  for (const FlatLink& link : flat.links) {
    const int to = flat.is_gate(link.to) ? -flat.fragment_of(link.to) : link.to;
    net_report.links.push_back({link.from, link.from_port, to, link.to_port, link.delayed, false});
  }
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

/// Row L6: CANCEL is heard by a Cancel alone.
void note_missing_cancel(const FlatNet& flat, LoadReport& report) {
  const bool hears = std::ranges::any_of(
      flat.primitives, [](const FlatPrimitive& p) { return p.info != nullptr && !p.info->cancel_bound.empty(); });
  if (hears) return;
  report.note("/primitives", "the net has no Cancel, so it can only be aborted: a cancel does not reach it",
              "a primitive of type Cancel whose output leads to the Termination");
}

}  // namespace

void CompiledNet::build(const FlatNet& flat, NetPlan plan, Environment& environment, LoadReport& report) {
  Builder(flat, std::move(plan), environment, report, *impl_).run();
}

std::unique_ptr<CompiledNet> CompiledNet::from_plan(const FlatNet& flat, NetPlan plan, Environment& environment,
                                                    LoadReport& report) {
  std::unique_ptr<CompiledNet> net(new CompiledNet());
  net->build(flat, std::move(plan), environment, report);
  return net;
}

Result<std::unique_ptr<CompiledNet>> CompiledNet::compile(const NetDescription& description, Environment& environment) {
  LoadReport report;
  FlatNet flat = flatten(description, report);
  bind_signals(flat, environment);
  const std::vector<int> order = schedule(flat, report);
  const bool sound = !report.has_errors();
  std::unique_ptr<CompiledNet> net(new CompiledNet());
  Impl& impl = *net->impl_;
  impl.name = description.name;
  check_termination(flat, report);
  check_exclusions(flat, impl.report, report);
  check_units(flat, impl.report, report);
  check_frames(flat, report);
  if (sound) check_demands(flat, impl.report, report);
  net->build(flat, plan_net(flat, order), environment, report);
  if (report.has_errors()) return std::unexpected(report.take());
  impl.report.order = impl.ids;
  describe(flat, order, impl.report);
  note_null_paths(flat, impl.report, report);
  note_latencies(flat, report);
  note_missing_cancel(flat, report);
  certify_reactions(flat, impl.report, report);
  impl.report.notes = report.take();
  impl.stop_bound = find_stop_bound(flat, impl.primitives, impl.report);
  std::vector<Primitive*> by_number(flat.primitives.size(), nullptr);
  for (std::size_t i = 0; i < impl.numbers.size(); ++i)
    by_number[static_cast<std::size_t>(impl.numbers[i])] = impl.primitives[i];
  impl.path_stop = find_path_stop(flat, by_number, impl.drivers);
  for (const FlatPrimitive& primitive : flat.primitives) impl.cost_ns += primitive.info->cost_ns;
  return net;
}

}  // namespace takt::net
