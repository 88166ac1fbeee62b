#include "core/net/compiled_net.h"

#include <chrono>
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

template <class Run>
void CompiledNet::Impl::run_steps(Cycle& cycle, std::size_t& at, const Run& run) {
  for (const NetPlan::Step& step : steps) {
    Gate* gate = step.gate < 0 ? nullptr : &gates[static_cast<std::size_t>(step.gate)];
    if (step.is_gate) {
      look_at(*gate, cycle);
    } else if (gate == nullptr || gate->running) {
      const Cycle& inner = gate == nullptr ? cycle : gate->cycle;
      for (at = step.begin; at < step.end; ++at) run(at, inner);
    }
  }
}

template <class Run>
void CompiledNet::Impl::evaluate(const Cycle& outer, const Run& run) {
  if (signals.fail) return;
  Cycle cycle = outer;
  cycle.index_in_net = cycles;
  cycle.first = cycles == 0;
  cycle.signals = &signals;
  std::size_t at = 0;
  try {
    if (steps.empty()) {
      for (const std::size_t end = primitives.size(); at < end; ++at) run(at, cycle);
    } else {
      run_steps(cycle, at, run);
    }
  } catch (const std::exception& error) {
    std::array<char, 63> text{};
    const auto end = fmt::format_to_n(text.data(), text.size(), "{}: {}", ids[at], error.what());
    signals.fail_with(Cause::Code::kException, {text.data(), std::min(end.size, text.size())}, cycle.index);
  } catch (...) {
    signals.fail_with(Cause::Code::kException, ids[at], cycle.index);
  }
  for (const Delay& delay : delays) std::memcpy(delay.memory, delay.source, delay.size);
  for (const Gate& gate : gates) {
    if (!gate.running) continue;
    for (const Delay& delay : gate.delays) std::memcpy(delay.memory, delay.source, delay.size);
  }
  ++cycles;
}

void CompiledNet::evaluate(const Cycle& cycle) {
  Impl& net = *impl_;
  const auto* primitives = net.primitives.data();
  net.evaluate(cycle, [&net, primitives](std::size_t at, const Cycle& inner) {
    net.newest.store(at, std::memory_order_relaxed);
    primitives[at]->update(inner);
  });
}

void CompiledNet::evaluate_timed(const Cycle& cycle, std::size_t first, std::size_t stride,
                                 std::span<std::int64_t> nanoseconds) {
  using Clock = std::chrono::steady_clock;
  const auto* primitives = impl_->primitives.data();
  impl_->evaluate(cycle, [=](std::size_t at, const Cycle& inner) {
    if (at % stride != first) return primitives[at]->update(inner);
    const auto begin = Clock::now();
    primitives[at]->update(inner);
    nanoseconds[at] += std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - begin).count();
  });
}

const NetSignals& CompiledNet::signals() const { return impl_->signals; }
std::int64_t CompiledNet::cycles() const { return impl_->cycles; }
std::span<const std::byte> CompiledNet::slots() const { return {impl_->values.at(0), impl_->slots_size}; }
const std::vector<CompiledNet::Port>& CompiledNet::ports() const { return impl_->ports; }
const std::vector<CompiledNet::Monitor>& CompiledNet::monitors() const { return impl_->monitors; }
const std::vector<Resource*>& CompiledNet::claims() const { return impl_->claims; }
const std::vector<ClaimState>& CompiledNet::claim_states() const { return impl_->claim_states; }
const NetReport& CompiledNet::report() const { return impl_->report; }
const PathStop& CompiledNet::path_stop() const { return impl_->path_stop; }
const StopBound* CompiledNet::stop_bound() const { return impl_->stop_bound ? &*impl_->stop_bound : nullptr; }
double CompiledNet::cost_ns() const { return impl_->cost_ns; }
const std::string& CompiledNet::name() const { return impl_->name; }
int CompiledNet::primitive_count() const { return static_cast<int>(impl_->primitives.size()); }

std::string_view CompiledNet::progress() const {
  const std::size_t at = impl_->newest.load(std::memory_order_relaxed);
  return at < impl_->ids.size() ? std::string_view(impl_->ids[at]) : std::string_view();
}

const void* CompiledNet::find_slot(std::string_view port, ValueType type) const {
  const auto found = impl_->port_by_name.find(port);
  if (found == impl_->port_by_name.end()) return nullptr;
  const Port& entry = impl_->ports[found->second];
  return entry.type == type ? impl_->values.at(entry.offset) : nullptr;
}

std::string_view name_of(Cause::Code code) {
  static constexpr std::array<std::string_view, 12> kNames = {"none",       "terminated", "cancelled", "aborted",
                                                              "null input", "device",     "guard",     "exception",
                                                              "overrun",    "conflict",   "error",     "taken over"};
  return kNames.at(static_cast<std::size_t>(code));
}

}  // namespace takt::net
