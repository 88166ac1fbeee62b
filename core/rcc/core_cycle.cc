#include "core/rcc/control_core.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "core/device/emergency_stop.h"
#include "core/net/format_text.h"
#include "core/net/stop_bound.h"
#include "core/rcc/admission.h"
#include "core/rcc/core_impl.h"
#include "core/rcc/stopwatch.h"

namespace takt::rcc {

/// Places of what the net claims, its seams, its bound, its cost.
Diagnostics ControlCore::Impl::bind(NetEntry& entry) {
  Diagnostics diagnostics;
  for (const net::Resource* claim : entry.net->claims()) entry.claims.push_back(resources.place_of(claim));
  bind_states(entry, diagnostics);
  check_cooperation(*entry.net, arms, options.separate, diagnostics);
  entry.begins = bind_seams(entry, entry.options.begins, "/begins", diagnostics);
  entry.ends = bind_seams(entry, entry.options.ends, "/ends", diagnostics);
  const net::StopBound* bound = entry.net->stop_bound();
  entry.cancel_bound_cycles = entry.options.cancel_bound_cycles.value_or(
      bound != nullptr ? bound->in_cycles(options.period) : LoadOptions::kDefaultCancelBound);
  entry.bind_flags(diagnostics);
  bind_path_stop(entry);
  entry.cost_ns = entry.net->cost_ns() * machine_factor();
  const double load = executor.load_ns(), budget = static_cast<double>(options.budget);
  if (budget > 0.0 && load + entry.cost_ns > budget)
    diagnostics.error(
        Code::kOverBudget, "",
        fmt::format("the net costs about {:.1f} us a cycle, the running ones {:.1f} us; the budget is {:.1f} us",
                    1e-3 * entry.cost_ns, 1e-3 * load, 1e-3 * budget),
        "Make the net smaller, or run fewer at one time");
  return diagnostics;
}

void ControlCore::Impl::bind_path_stop(NetEntry& entry) const {
  const net::PathStop& stop = entry.net->path_stop();
  for (const net::Resource* device : stop.devices) {
    const int place = resources.place_of(device);
    const device::Actuator* actuator = place < 0 ? nullptr : resources.at(place).actuator;
    const bool known = std::ranges::count(entry.on_path, place) > 0;
    if (actuator != nullptr && actuator->follows_paths() && !known) entry.on_path.push_back(place);
  }
  entry.stop_bound_cycles = static_cast<std::int64_t>(std::ceil(stop.seconds / to_seconds(options.period))) + 2;
}

/// What all drivers of a device agree on is needed at the start. Where they differ, the net changes it by turns.
void ControlCore::Impl::bind_states(NetEntry& entry, Diagnostics& diagnostics) const {
  std::map<int, std::vector<std::string>> states;
  for (const net::ClaimState& one : entry.net->claim_states()) {
    const int place = resources.place_of(one.device);
    if (place >= 0 && resources.at(place).actuator != nullptr) states[place].push_back(one.state);
  }
  for (auto& [place, wanted] : states) {
    const bool agree = std::ranges::all_of(wanted, [&](const std::string& one) { return one == wanted.front(); });
    if (const auto why = resources.at(place).actuator->conflict(wanted))
      diagnostics.error(Code::kConflict, "", *why, "Make a net for each, or use one state for all");
    if (agree && !wanted.front().empty()) entry.needs.push_back({place, wanted.front()});
  }
}

std::vector<NetEntry::DeclaredSeam> ControlCore::Impl::bind_seams(const NetEntry& entry,
                                                                  const std::vector<NetSeam>& seams,
                                                                  const std::string& pointer,
                                                                  Diagnostics& diagnostics) {
  std::vector<NetEntry::DeclaredSeam> bound;
  for (std::size_t i = 0; i < seams.size(); ++i) {
    const int place = resources.place_of(devices.find(seams[i].device));
    const std::string where = fmt::format("{}/{}", pointer, i);
    if (place < 0 || resources[place].actuator == nullptr || std::ranges::count(entry.claims, place) == 0) {
      diagnostics.error(Code::kUnknownName, where + "/device",
                        fmt::format("the net does not drive '{}'", seams[i].device));
    } else if (const auto why = resources[place].actuator->seam_mismatch(seams[i].seam, seams[i].seam)) {
      diagnostics.error(Code::kNotPossibleNow, where, std::string(why->view()), "Feed a set point of this device");
    } else {
      bound.push_back({place, seams[i].seam});
    }
  }
  return bound;
}

std::optional<net::Text> ControlCore::Impl::seam_mismatch(const NetEntry::DeclaredSeam& end,
                                                          const NetEntry& successor) {
  std::optional<net::Text> first;
  for (const auto& [place, begin] : successor.begins) {
    if (place != end.place) continue;
    const auto why = resources[place].actuator->seam_mismatch(end.seam, begin);
    if (!why) return std::nullopt;
    if (!first) first = why;
  }
  return first;
}

void ControlCore::Impl::take_samples(std::int64_t k, Nanoseconds now) {
  for (device::Device* device : in_order) device->begin_cycle(k, now);
}

void ControlCore::Impl::note_latches(std::int64_t k) {
  if (latches == nullptr) return;
  for (const device::Channel* channel : channels) {
    if (!channel->latched()) continue;
    RawLatch latch{.cycle = k, .channel = channel};
    std::memcpy(latch.slot.data(), channel->raw_slot(), channel->slot_size());
    if (!latches->push(latch)) latches_dropped.fetch_add(1, std::memory_order_relaxed);
  }
}

void ControlCore::Impl::sample_watches(std::int64_t k) {
  watches.sample(k, [this](NetId id) {
    const NetEntry* entry = nets.find(id);
    return entry != nullptr && is_active(entry->state.load(std::memory_order_relaxed));
  });
}

void ControlCore::Impl::take_requests() {
  nets.take_retired();
  Posted posted;
  // No more than the queue holds: who posts faster than the cycle takes does not keep it here.
  for (std::size_t i = 0; i < kQueueCapacity && queue.pop(posted); ++i) {
    if (posted.watch != nullptr) {
      if (!watches.attach(posted.watched, *posted.watch)) posted.watch->end();
    } else if (posted.arm != nullptr) {
      take_mode_request({.id = posted.id, .arm = posted.arm, .mode = posted.mode});
    } else if (!rules.add(posted.id, posted.rule)) {
      answer(posted.id, net::format_text("{} rules wait, and there is no room for more", RuleBook::kMostWaiting));
    }
  }
}

void ControlCore::Impl::answer(RequestId id, const std::optional<net::Text>& refusal) {
  Event event{.kind = Event::Kind::kDone, .state = {}, .net = 0, .request = id, .cause = {}};
  if (refusal) {
    event.kind = Event::Kind::kRefused;
    event.cause.code = net::Cause::Code::kConflict;
    event.cause.text = *refusal;
  }
  event.cause.cycle = cycle.load(std::memory_order_relaxed);
  events.add(event);
}

void ControlCore::Impl::take_mode_request(const ControlModeParameters& request) {
  auto refusal = request.arm->refuse_change(request.mode);
  if (!refusal && mode_requests.size() == mode_requests.capacity())
    refusal = net::format_text("{} changes of mode are under way, and there is no room for more", kQueueCapacity);
  if (refusal) return answer(request.id, refusal);
  request.arm->change_mode(request.mode);
  mode_requests.push_back(request);
}

void ControlCore::Impl::look_at_mode_requests() {
  std::erase_if(mode_requests, [this](const ControlModeParameters& request) {
    const device::Arm& arm = *request.arm;
    if (arm.phase() == device::Arm::Phase::kChanging) return false;
    if (arm.mode() == request.mode && !arm.lost()) {
      answer(request.id, std::nullopt);
    } else {
      answer(request.id, net::format_text("{}: did not go into mode {}", arm.name(), name_of(request.mode)));
    }
    return true;
  });
}

void ControlCore::Impl::guard_and_hand_over(std::int64_t k) {
  // All are looked at before anything is sent: a net that trips at one device stops all its devices in this cycle.
  for (auto& place : resources.all()) {
    if (place.actuator == nullptr) continue;
    const bool moving = !place.actuator->at_rest();
    const auto trip = place.actuator->check();
    if (!trip) continue;
    const net::Cause cause{.code = net::Cause::Code::kGuard, .text = *trip, .cycle = k};
    NetEntry* owner = nets.find(place.owner);
    if (moving) {
      Event event{.kind = Event::Kind::kStopped, .state = {}, .net = place.owner, .request = 0, .cause = cause};
      events.add(event);
    }
    if (owner != nullptr && is_active(owner->state.load(std::memory_order_relaxed))) executor.abort(*owner, cause, k);
  }
  executor.forget_ended();
  for (device::Actuator* actuator : actuators) actuator->hand_over();
}

void ControlCore::Impl::digest_nets(std::int64_t k) {
  const std::array<std::int64_t, 1> number = {k};
  digest.take(0, std::as_bytes(std::span(number)));
  for (const NetEntry* entry : executor.active()) digest.take(entry->id, entry->net->slots());
}

constexpr std::uint64_t kFirstDevice = 0x8000'0000'0000'0000ull;  // apart from the numbers of nets

void ControlCore::Impl::digest_devices() {
  std::uint64_t number = kFirstDevice;
  for (const device::Device* device : in_order) {
    device::StateWords words;
    device->add_state(words);
    digest.take(number++, words.bytes());
  }
  digest.take_added_blocks();
}

ControlCore::ControlCore(const Options& options) : impl_(std::make_unique<Impl>(options)) {}
ControlCore::~ControlCore() = default;

void ControlCore::keep(std::unique_ptr<device::Device> device) {
  Impl& core = *impl_;
  device::Device* added = device.get();
  core.keep(added->name(), std::move(device));
  const auto insert = [](auto& list, auto* one) {
    if (one != nullptr)
      list.insert(std::ranges::upper_bound(list, one->name(), {}, [](auto* d) { return d->name(); }), one);
  };
  insert(core.in_order, added);
  insert(core.actuators, dynamic_cast<device::Actuator*>(added));
  insert(core.arms, dynamic_cast<device::Arm*>(added));
  insert(core.channels, dynamic_cast<device::Channel*>(added));
  if (auto* stop = dynamic_cast<device::EmergencyStop*>(added)) core.stops.add(stop);
  if (auto* arm = dynamic_cast<device::Arm*>(added)) core.stops.add(arm);
}

net::Resource& ControlCore::add(std::string name, std::unique_ptr<net::Resource> resource) {
  return impl_->keep(std::move(name), std::move(resource));
}

net::Environment& ControlCore::environment() { return impl_->devices; }

device::Arm* ControlCore::find_arm(std::string_view name) {
  return dynamic_cast<device::Arm*>(impl_->devices.find(name));
}

std::span<device::Arm* const> ControlCore::arms() const { return impl_->arms; }

Result<device::Channel*> ControlCore::declare(const device::ChannelDescription& description) {
  auto channel = device::Channel::make(description);
  Diagnostics diagnostics = channel ? Diagnostics{} : std::move(channel.error());
  if (impl_->devices.find(description.name) != nullptr)
    diagnostics.error(Code::kDuplicate, "/name", fmt::format("'{}' exists already", description.name), "Rename it");
  if (diagnostics.has_errors()) return std::unexpected(std::move(diagnostics));
  return &add(std::move(*channel));
}

device::Channel* ControlCore::find_channel(std::string_view name) {
  return dynamic_cast<device::Channel*>(impl_->devices.find(name));
}

std::vector<Latch> ControlCore::take_latches() {
  std::vector<Latch> taken;
  RawLatch raw;
  while (impl_->latches != nullptr && impl_->latches->pop(raw)) {
    Latch& latch = taken.emplace_back(Latch{.cycle = raw.cycle, .channel = raw.channel->name(), .value = {}});
    latch.value = device::value_in(raw.channel->description().type, raw.slot.data());
  }
  return taken;
}

std::int64_t ControlCore::latches_dropped() const { return impl_->latches_dropped.load(std::memory_order_relaxed); }

std::optional<std::int64_t> ControlCore::running_cycle() const {
  const std::int64_t begun = impl_->begun.load(std::memory_order_relaxed);
  return begun == impl_->cycle.load(std::memory_order_relaxed) ? std::optional(begun) : std::nullopt;
}

Stall ControlCore::where_it_is() const {
  Stall stall{.cycle = running_cycle().value_or(-1), .net = impl_->executor.current(), .net_name = {}, .primitive = {}};
  const EntryHandle entry = impl_->nets.hold(stall.net);
  if (stall.net == 0 || entry == nullptr || entry->net == nullptr) return stall;
  stall.net_name = entry->net->name();
  stall.primitive = entry->net->progress();
  return stall;
}

void ControlCore::step() {
  Impl& core = *impl_;
  const std::int64_t k = core.cycle.load(std::memory_order_relaxed);
  core.begun.store(k, std::memory_order_relaxed);
  net::Cycle cycle;
  cycle.index = k;
  cycle.period = core.options.period;
  cycle.time = k * core.options.period;
  cycle.dt = to_seconds(core.options.period);
  core.events.begin_cycle(k);
  core.digest.begin_cycle();

  Stopwatch watch(core.statistics, core.options.measure);
  core.take_samples(k, cycle.time);
  core.note_latches(k);
  core.stops.begin(k);
  watch.lap(CyclePhase::kDevices);
  core.executor.evaluate(cycle);
  core.sample_watches(k);
  watch.lap(CyclePhase::kNets);
  if (core.options.digest) core.digest_nets(k);
  watch.lap(CyclePhase::kDigest);
  core.executor.end_finished(k);
  core.stops.finish(k);
  core.look_at_mode_requests();
  core.take_requests();
  core.rules.apply(k);
  watch.lap(CyclePhase::kRules);
  core.guard_and_hand_over(k);
  core.watches.forget_ended([&core](NetId id) {
    const NetEntry* entry = core.nets.find(id);
    return entry == nullptr || entry->state.load(std::memory_order_relaxed) == NetState::kTerminated;
  });
  watch.lap(CyclePhase::kGuard);
  if (core.options.digest) core.digest_devices();
  watch.lap(CyclePhase::kDigest);

  core.statistics.cycles = k + 1;
  core.statistics.events_dropped = core.events.dropped();
  core.cycle.store(k + 1, std::memory_order_relaxed);
}

void ControlCore::count_overruns(std::int64_t late_cycles) { impl_->statistics.overruns += late_cycles; }

std::int64_t ControlCore::cycle() const { return impl_->cycle.load(std::memory_order_relaxed); }
Nanoseconds ControlCore::time() const { return cycle() * impl_->options.period; }
Nanoseconds ControlCore::period() const { return impl_->options.period; }
std::span<const Event> ControlCore::events() const { return impl_->events.view(); }
Digest& ControlCore::digest() { return impl_->digest; }
const device::Device* ControlCore::device_of_block(std::uint64_t block) const {
  const bool one_of_devices = block >= kFirstDevice && block - kFirstDevice < impl_->in_order.size();
  return one_of_devices ? impl_->in_order[block - kFirstDevice] : nullptr;
}

std::string ControlCore::block_name(std::uint64_t block) const {
  if (block == 0) return "number of the cycle";
  if (const device::Device* device = device_of_block(block)) return fmt::format("device '{}'", device->name());
  if (const std::string* added = impl_->digest.name_of(block)) return *added;
  const NetHandle one = block <= UINT32_MAX ? net(static_cast<NetId>(block)) : nullptr;
  if (one != nullptr) return fmt::format("net {} '{}'", block, one->name());
  return fmt::format("block {}", block);
}

const Statistics& ControlCore::statistics() const { return impl_->statistics; }

}  // namespace takt::rcc
