#include "core/net/compiled_net.h"

#include <cstring>
#include <exception>

#include <fmt/format.h>

#include "core/net/compiled_net_impl.h"

namespace takt::net {

CompiledNet::CompiledNet() : impl_(std::make_unique<Impl>()) {}
CompiledNet::~CompiledNet() = default;

/// Brings a gate's state up to this cycle: begins, goes on or rests.
void CompiledNet::Impl::look_at(Gate& gate, const Cycle& outer) {
  const Gate* parent = gate.parent < 0 ? nullptr : &gates[static_cast<std::size_t>(gate.parent)];
  if (parent != nullptr && parent->restarted) gate.begun = false;
  const bool asked = gate.active == nullptr || (gate.active->null == 0 && gate.active->value);
  const bool run = asked && (parent == nullptr || parent->running);
  gate.restarted = run && !gate.begun;
  if (gate.restarted) {
    gate.begun = true;
    gate.cycles = 0;
    for (const Delay& delay : gate.delays) std::memcpy(delay.memory, delay.initial, delay.size);
  }
  if (gate.running && !run) {
    for (const auto& [type, slot] : gate.outputs) {
      visit_type(type, [place = slot]<class T>(std::type_identity<T>) {
        Out<T>(reinterpret_cast<Slot<T>*>(place)).set_null();
      });
    }
    if (gate.when_inactive == WhenInactive::kReset) gate.begun = false;
  }
  gate.running = run;
  if (!run) return;
  gate.cycle = outer;
  gate.cycle.index_in_net = gate.cycles;
  gate.cycle.first = gate.cycles == 0;
  ++gate.cycles;
}

void CompiledNet::Impl::run_steps(Cycle& cycle, std::size_t& at) {
  for (const NetPlan::Step& step : steps) {
    Gate* gate = step.gate < 0 ? nullptr : &gates[static_cast<std::size_t>(step.gate)];
    if (step.is_gate) {
      look_at(*gate, cycle);
    } else if (gate == nullptr || gate->running) {
      const Cycle& inner = gate == nullptr ? cycle : gate->cycle;
      for (at = step.begin; at < step.end; ++at) primitives[at]->update(inner);
    }
  }
}

void CompiledNet::evaluate(const Cycle& outer) {
  Impl& net = *impl_;
  if (net.signals.fail) return;
  Cycle cycle = outer;
  cycle.index_in_net = net.cycles;
  cycle.first = net.cycles == 0;
  cycle.signals = &net.signals;
  std::size_t at = 0;
  try {
    if (net.steps.empty()) {
      for (const std::size_t end = net.primitives.size(); at < end; ++at) net.primitives[at]->update(cycle);
    } else {
      net.run_steps(cycle, at);
    }
  } catch (const std::exception& error) {
    std::array<char, 63> text{};
    const auto end = fmt::format_to_n(text.data(), text.size(), "{}: {}", net.ids[at], error.what());
    net.signals.fail_with(Cause::Code::kException, {text.data(), std::min(end.size, text.size())}, cycle.index);
  } catch (...) {
    net.signals.fail_with(Cause::Code::kException, net.ids[at], cycle.index);
  }
  for (const Impl::Delay& delay : net.delays) std::memcpy(delay.memory, delay.source, delay.size);
  for (const Impl::Gate& gate : net.gates) {
    if (!gate.running) continue;
    for (const Impl::Delay& delay : gate.delays) std::memcpy(delay.memory, delay.source, delay.size);
  }
  ++net.cycles;
}

const NetSignals& CompiledNet::signals() const { return impl_->signals; }
std::int64_t CompiledNet::cycles() const { return impl_->cycles; }
std::span<const std::byte> CompiledNet::slots() const { return {impl_->values.at(0), impl_->slots_size}; }
const std::vector<CompiledNet::Port>& CompiledNet::ports() const { return impl_->ports; }
const std::vector<CompiledNet::Monitor>& CompiledNet::monitors() const { return impl_->monitors; }
const std::vector<Resource*>& CompiledNet::claims() const { return impl_->claims; }
const NetReport& CompiledNet::report() const { return impl_->report; }
const std::string& CompiledNet::name() const { return impl_->name; }
int CompiledNet::primitive_count() const { return static_cast<int>(impl_->primitives.size()); }

const void* CompiledNet::find_slot(std::string_view port, ValueType type) const {
  const auto found = impl_->port_by_name.find(port);
  if (found == impl_->port_by_name.end()) return nullptr;
  const Port& entry = impl_->ports[found->second];
  return entry.type == type ? impl_->values.at(entry.offset) : nullptr;
}

std::string_view name_of(Cause::Code code) {
  static constexpr std::array<std::string_view, 11> kNames = {"none",       "terminated", "cancelled", "aborted",
                                                              "null input", "device",     "guard",     "exception",
                                                              "overrun",    "conflict",   "error"};
  return kNames.at(static_cast<std::size_t>(code));
}

}  // namespace takt::net
