// What programs ask of a core: nets, requests, watches.
#include <utility>

#include "core/rcc/core_impl.h"

namespace takt::rcc {

Result<std::shared_ptr<Watch>> ControlCore::watch(NetId id, std::string_view port, const WatchOptions& options) {
  const NetHandle compiled = net(id);
  if (compiled == nullptr) return failure(Code::kUnknownName, "", fmt::format("net {} is not loaded", id));
  std::vector<std::string> names;
  for (const auto& monitor : compiled->monitors()) {
    if (monitor.name == port)
      return attach(id, std::make_unique<Watch>(monitor.name, monitor.type, monitor.slot, options));
    names.push_back(monitor.name);
  }
  for (const auto& one : compiled->ports()) {
    if (one.name == port)
      return attach(id, std::make_unique<Watch>(one.name, one.type, compiled->slots().data() + one.offset, options));
    names.push_back(one.name);
  }
  return failure(Code::kUnknownName, "", fmt::format("the net '{}' shows no '{}'", compiled->name(), port),
                 nearest_choice(port, names));
}

Result<std::shared_ptr<Watch>> ControlCore::watch(std::string_view channel, const WatchOptions& options) {
  if (const device::Channel* found = find_channel(channel))
    return attach(0, std::make_unique<Watch>(found->name(), found->description().type, found->raw_slot(), options));
  std::vector<std::string> names;
  for (const device::Channel* one : impl_->channels) names.push_back(one->name());
  return failure(Code::kUnknownName, "", fmt::format("there is no channel '{}'", channel),
                 nearest_choice(channel, names));
}

Result<std::shared_ptr<Watch>> ControlCore::attach(NetId net, std::unique_ptr<Watch> watch) {
  const std::lock_guard lock(impl_->watch_mutex);
  std::erase_if(impl_->kept_watches, [](const auto& kept) { return kept.use_count() == 1 && kept->ended(); });
  std::shared_ptr<Watch> kept = impl_->kept_watches.emplace_back(std::move(watch));
  if (impl_->queue.push(Posted{.watch = kept.get(), .watched = net})) return kept;
  impl_->kept_watches.pop_back();
  return std::unexpected(full_queue());
}

void ControlCore::unwatch(const std::shared_ptr<Watch>& watch) { watch->give_up(); }

Result<NetId> ControlCore::load(const net::NetDescription& description, const LoadOptions& options) {
  auto loaded = impl_->nets.load(description, options);
  if (impl_->relay == nullptr || !loaded) return loaded;
  Diagnostics why = impl_->relay->load(*loaded, description, options);
  if (!why.has_errors()) return loaded;
  (void)impl_->nets.ask_retire(*loaded);
  return std::unexpected(std::move(why));
}

NetId ControlCore::load_async(net::NetDescription description, const LoadOptions& options) {
  if (impl_->relay != nullptr) return load(description, options).value_or(0);  // the other core is waited for anyway
  return impl_->nets.load_async(std::move(description), options);
}

bool ControlCore::knows(NetId net) const { return impl_->nets.hold(net) != nullptr; }

Diagnostics ControlCore::diagnostics(NetId net) const {
  const EntryHandle entry = impl_->nets.hold(net);
  const bool known = entry != nullptr && entry->state.load(std::memory_order_acquire) == NetState::kRejected;
  return known ? entry->diagnostics : Diagnostics{};
}

bool ControlCore::unload(NetId net) {
  const EntryHandle entry = impl_->nets.hold(net);
  if (entry == nullptr) return false;
  const NetState state = entry->state.load(std::memory_order_acquire);
  if (is_active(state) || state == NetState::kLoading) return false;
  if (impl_->relay == nullptr) return impl_->nets.ask_retire(net);
  impl_->relay->unload(net);
  return true;
}

NetStatus ControlCore::status(NetId net) const {
  NetStatus status;
  const EntryHandle entry = impl_->nets.hold(net);
  if (entry == nullptr) return status;
  status.state = entry->state.load(std::memory_order_acquire);
  status.first_cycle = entry->first_cycle.load(std::memory_order_relaxed);
  if (status.state != NetState::kLoading) {
    status.cancel_bound_cycles = entry->cancel_bound_cycles;
    status.cost_ns = entry->cost_ns;
  }
  status.last_cycle = entry->last_cycle.load(std::memory_order_relaxed);
  if (status.state == NetState::kTerminated) status.cause = entry->cause;
  return status;
}

NetHandle ControlCore::net(NetId net) const {
  const EntryHandle entry = impl_->nets.hold(net);
  const bool compiled =
      entry != nullptr && entry->state.load(std::memory_order_acquire) != NetState::kLoading && entry->net != nullptr;
  return compiled ? NetHandle(entry, entry->net.get()) : nullptr;
}

RequestId ControlCore::abort(NetId net) {
  // This is the abort; what is posted is only the question how it went.
  if (impl_->relay != nullptr) {
    impl_->relay->abort(net);
  } else {
    impl_->nets.ask_abort(net);
  }
  return post(Transaction{.abort = {net}, .cancel = {}, .start = {}});
}

RequestId ControlCore::post(const Rule& rule) {
  const RequestId id = ++impl_->last_request;
  CommandRelay* const relay = impl_->relay;
  return (relay != nullptr ? relay->post(id, rule) : impl_->queue.push(Posted{.id = id, .rule = rule})) ? id : 0;
}

RequestId ControlCore::change_mode(std::string_view name, device::ControlMode mode) {
  device::Arm* arm = find_arm(name);
  if (arm == nullptr) return 0;
  const RequestId id = ++impl_->last_request;
  if (impl_->relay != nullptr) return impl_->relay->change_mode(id, name, mode) ? id : 0;
  return impl_->queue.push(Posted{.id = id, .arm = arm, .mode = mode}) ? id : 0;
}

Result<RequestId> ControlCore::schedule_after(NetId predecessor, NetId successor, NetId from_rest) {
  Diagnostics diagnostics;
  // Held, so that no other thread can have them freed while they are compared.
  const EntryHandle before = impl_->nets.hold(predecessor), after = impl_->nets.hold(successor);
  const auto check = [&diagnostics](NetId id, const EntryHandle& entry, bool starts) {
    if (entry == nullptr) return diagnostics.error(Code::kUnknownName, "", fmt::format("net {} is not loaded", id));
    const NetState state = entry->state.load(std::memory_order_acquire);
    if (starts && state != NetState::kReady)
      diagnostics.error(Code::kNotPossibleNow, "", fmt::format("net {} is not Ready, it is {}", id, name_of(state)));
  };
  check(predecessor, before, false);
  check(successor, after, true);
  if (from_rest != 0) check(from_rest, impl_->nets.hold(from_rest), true);
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  for (const auto& end : before->known_ends()) {
    if (const auto why = impl_->seam_mismatch(end, *after))
      diagnostics.error(Code::kNotPossibleNow, "",
                        fmt::format("net {} cannot follow net {}: {}: {}", successor, predecessor,
                                    impl_->resources[end.place].actuator->name(), why->view()));
  }
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  Rule rule{.condition = {Term::state(predecessor, {NetState::kTerminated})},
            .action = {.abort = {}, .cancel = {}, .start = {successor}}};
  if (from_rest != 0) rule.otherwise.start = {from_rest};
  if (const RequestId id = post(rule)) return id;
  return std::unexpected(full_queue());
}

void ControlCore::stop_all(net::Cause::Code code, std::string_view text) {
  if (impl_->relay != nullptr) return impl_->relay->stop_all(code, text);
  impl_->stops.stop_all(code, text);
}

}  // namespace takt::rcc
