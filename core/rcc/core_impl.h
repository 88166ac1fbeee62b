#pragma once

#include <array>
#include <atomic>
#include <cstdlib>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <boost/lockfree/spsc_queue.hpp>

#include "core/rcc/command_relay.h"
#include "core/rcc/control_core.h"
#include "core/rcc/event_buffer.h"
#include "core/rcc/executor.h"
#include "core/rcc/net_table.h"
#include "core/rcc/request_queue.h"
#include "core/rcc/rule_book.h"
#include "core/rcc/stop_supervisor.h"

/// What a ControlCore is made of, for its own files alone.
namespace takt::rcc {

inline constexpr std::size_t kQueueCapacity = 512;

/// What travels to the cycle thread. Copied without allocation.
struct Posted {
  RequestId id = 0;
  Rule rule = {};
  Watch* watch = nullptr;  ///< not nullptr: watch this value of net `watched`, 0 for a channel
  NetId watched = 0;
  device::Arm* arm = nullptr;  ///< not nullptr: bring it into `mode`
  device::ControlMode mode = device::ControlMode::kPosition;
};

inline Diagnostics full_queue() {
  return failure(Code::kNotPossibleNow, "", fmt::format("the queue of {} requests is full", kQueueCapacity)).error();
}

/// A change of mode that somebody asked for and that is under way.
struct ControlModeParameters {
  RequestId id = 0;
  device::Arm* arm = nullptr;
  device::ControlMode mode = device::ControlMode::kPosition;
};

/// A value from outside as the cycle notes it.
struct RawLatch {
  std::int64_t cycle = -1;
  const device::Channel* channel = nullptr;
  std::array<std::byte, 160> slot{};
};

class DeviceTable final : public net::Environment {
 public:
  net::Resource* find(std::string_view name) override {
    const auto found = by_name.find(name);
    return found == by_name.end() ? nullptr : found->second;
  }
  [[nodiscard]] std::vector<std::string> names() const override {
    std::vector<std::string> names;
    for (const auto& [name, resource] : by_name) names.push_back(name);
    return names;
  }
  std::map<std::string, net::Resource*, std::less<>> by_name;
};

struct ControlCore::Impl final : CommandInlet {
  explicit Impl(const Options& given)
      : options(given),
        nets(given.net_capacity, devices, [this](NetEntry& entry) { return bind(entry); }),
        executor(nets, resources, events, given.net_capacity),
        stops(executor),
        rules(executor, events) {
    executor.set_budget(static_cast<double>(options.budget));
    mode_requests.reserve(kQueueCapacity);
    if (options.latch_capacity > 0)
      latches = std::make_unique<LatchRing>(static_cast<std::size_t>(options.latch_capacity));
  }

  net::Resource& keep(std::string name, std::unique_ptr<net::Resource> resource) {
    if (auto* hears = dynamic_cast<CommandRelay*>(resource.get())) {
      relay = hears;
      relay->attach(*this);
      return *owned.emplace_back(std::move(resource));  // no net finds it
    }
    const bool is_new = devices.by_name.emplace(name, resource.get()).second;
    if (!is_new) std::abort();
    resources.add(std::move(name), *resource);
    return *owned.emplace_back(std::move(resource));
  }
  [[nodiscard]] Diagnostics bind(NetEntry& entry);
  void bind_states(NetEntry& entry, Diagnostics& diagnostics) const;
  void bind_path_stop(NetEntry& entry) const;
  [[nodiscard]] std::vector<NetEntry::DeclaredSeam> bind_seams(const NetEntry& entry, const std::vector<NetSeam>& seams,
                                                               const std::string& pointer, Diagnostics& diagnostics);

  /// Why none of the declared ways in which a net takes a device over follows this end of another one; or nothing.
  [[nodiscard]] std::optional<net::Text> seam_mismatch(const NetEntry::DeclaredSeam& end, const NetEntry& successor);

  // What the relay of a follower says.
  void begin_at(std::int64_t first) override { cycle.store(first, std::memory_order_relaxed); }
  [[nodiscard]] bool post(RequestId id, const Rule& rule) override {
    return queue.push(Posted{.id = id, .rule = rule});
  }
  [[nodiscard]] bool change_mode(RequestId id, std::string_view name, device::ControlMode mode) override {
    auto* arm = dynamic_cast<device::Arm*>(devices.find(name));
    return arm != nullptr && queue.push(Posted{.id = id, .arm = arm, .mode = mode});
  }
  void abort(NetId net) override { nets.ask_abort(net); }
  void unload(NetId net) override { (void)nets.ask_retire(net); }
  void stop_all(net::Cause::Code code, std::string_view text) override { stops.stop_all(code, text); }

  void take_samples(std::int64_t k, Nanoseconds now);
  void note_latches(std::int64_t k);
  void sample_watches(std::int64_t k);
  void take_requests();
  void take_mode_request(const ControlModeParameters& request);
  void look_at_mode_requests();
  void answer(RequestId id, const std::optional<net::Text>& refusal);
  void guard_and_hand_over(std::int64_t k);
  void digest_nets(std::int64_t k);
  void digest_devices();

  Options options;
  DeviceTable devices;
  std::vector<std::unique_ptr<net::Resource>> owned;
  std::vector<device::Device*> in_order;     // all devices, by name
  std::vector<device::Actuator*> actuators;  // those that are driven, by name
  std::vector<device::Arm*> arms;            // those that are arms, by name
  std::vector<device::Channel*> channels;    // likewise
  ResourceTable resources;
  NetTable nets;
  EventBuffer events;
  Executor executor;
  StopSupervisor stops;
  RuleBook rules;
  Digest digest;
  Statistics statistics;
  RequestQueue<Posted, kQueueCapacity> queue;
  using LatchRing = boost::lockfree::spsc_queue<RawLatch>;
  std::unique_ptr<LatchRing> latches;  // nullptr: nobody asked for them
  std::atomic<std::int64_t> latches_dropped = 0;
  std::vector<ControlModeParameters> mode_requests;  // never grows in the cycle
  WatchList watches;
  std::mutex watch_mutex;                            // of kept_watches; never taken in the cycle
  std::vector<std::shared_ptr<Watch>> kept_watches;  // until the cycle has let go of them
  CommandRelay* relay = nullptr;                     // of a follower: hears commands in place of this core
  std::atomic<RequestId> last_request = 0;
  std::atomic<std::int64_t> cycle = 0;
  std::atomic<std::int64_t> begun = -1;  // the cycle that was begun last
};

}  // namespace takt::rcc
