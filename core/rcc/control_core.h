#pragma once

#include <concepts>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/base/time.h"
#include "core/device/arm.h"
#include "core/device/channel.h"
#include "core/device/device.h"
#include "core/net/compiled_net.h"
#include "core/rcc/channel_log.h"
#include "core/rcc/cooperation.h"
#include "core/rcc/digest.h"
#include "core/rcc/net_state.h"
#include "core/rcc/rules.h"
#include "core/rcc/statistics.h"
#include "core/rcc/watch.h"

namespace takt::rcc {

/// A net as seen from outside: its state, and why it is in it.
struct NetStatus {
  NetState state = NetState::kLoading;
  net::Cause cause;                      ///< of the end; code kNone before
  std::int64_t first_cycle = -1;         ///< core cycle of its first evaluation
  std::int64_t last_cycle = -1;          ///< core cycle in which it ended
  std::int64_t cancel_bound_cycles = 0;  ///< from a cancel to the end, at most; 0 while Loading
  double cost_ns = 0.0;                  ///< of a cycle on this machine, as far as its primitives declare it
};

/// A counted handle of a net: it stays in memory while somebody has one, whoever unloads it meanwhile. To be given back
/// before the core is destroyed.
using NetHandle = std::shared_ptr<const net::CompiledNet>;

/// How a net takes over, or leaves, a device that it drives (row L3).
struct NetSeam {
  std::string device;
  device::Seam seam;
};

/// What a net is loaded with.
struct LoadOptions {
  /// Cycles from a cancel to the end; then the net is aborted (row L6). Not given: what the net says or its structure
  /// gives (net::StopBound), else kDefaultCancelBound.
  static constexpr std::int64_t kDefaultCancelBound = 10'000;
  std::optional<std::int64_t> cancel_bound_cycles = {};
  /// A Boolean of the net ("id.port"): while it is true, something runs that a cancel does not end, and the bound does
  /// not count. Empty: there is nothing of that kind.
  std::string goes_on = {};
  /// A Boolean of the net: it has ended because it was stopped from inside, which counts as cancelled.
  std::string stopped = {};
  /// How the net takes its devices over: checked when its start is agreed, and again against what was really sent. A
  /// device that is named several times may be taken over in any of these ways.
  std::vector<NetSeam> begins = {};
  /// How it leaves them when it ends in order; what schedule_after() compares the successor with.
  std::vector<NetSeam> ends = {};
};

/// A cycle that does not end, and what it is doing.
struct Stall {
  std::int64_t cycle = -1;
  NetId net = 0;                    ///< 0: it is not in a net: a device, a rule, the digest
  std::string net_name, primitive;  ///< the primitive that was begun last
};

/// The robot control core: devices, nets and the cycle (docs/cycle.md).
///
/// One step is one cycle: take the newest device samples, evaluate the running nets, apply requests and synchronisation
/// rules on one snapshot, guard and hand over the set points, take the digest. step() is for one thread, the cycle
/// thread; in lock-step that is the thread that does everything else too. What is marked "any thread" may be called
/// beside a running cycle; it never blocks the cycle.
class ControlCore {
 public:
  struct Options {
    Nanoseconds period = kMillisecond;
    bool digest = true;       ///< take the digest each cycle
    bool measure = false;     ///< measure wall time per phase (costs about 0.1 us a cycle)
    int net_capacity = 4096;  ///< loaded nets at one time
    /// Real time: most that all running nets together may cost in a cycle (row T5). A net that does not fit beside
    /// those that run is rejected, and its start is refused. 0: lock-step, cost is only reported.
    Nanoseconds budget = 0;
    SeparateArms separate = {};  ///< groups of arms of which no net may drive two
    int latch_capacity = 0;      ///< values from outside that are kept for take_latches(); 0: none
  };

  explicit ControlCore(const Options& options);
  ~ControlCore();
  ControlCore(const ControlCore&) = delete;
  ControlCore& operator=(const ControlCore&) = delete;

  // -- Devices: before the first step. Realtime: setup. --------------------------------------------------------------
  /// A name that is taken is a programming error (abort).
  /// While an EmergencyStop is latched, no net starts and nets that hold what stops in an emergency end (rows S1, S4).
  template <std::derived_from<device::Device> D>
  D& add(std::unique_ptr<D> device) {
    D& added = *device;
    keep(std::move(device));
    return added;
  }
  /// Any other resource that primitives may find by name.
  net::Resource& add(std::string name, std::unique_ptr<net::Resource> resource);
  [[nodiscard]] net::Environment& environment();
  [[nodiscard]] device::Arm* find_arm(std::string_view name);
  /// All arms in the order of their names.
  [[nodiscard]] std::span<device::Arm* const> arms() const;

  // -- Channels (docs/channels.md) -----------------------------------------------------------------------------------
  /// Makes a channel, as a device of that name. Before the first step. Realtime: setup.
  /// @return the channel, to write to from any thread; or all that is wrong, a name that is taken included.
  Result<device::Channel*> declare(const device::ChannelDescription& description);
  /// @return nullptr if there is none of this name. Any thread. Realtime: setup.
  [[nodiscard]] device::Channel* find_channel(std::string_view name);
  /// Takes what came from outside since the last call, in order. One thread. Realtime: setup.
  [[nodiscard]] std::vector<Latch> take_latches();
  /// Values from outside that latch_capacity had no room for.
  [[nodiscard]] std::int64_t latches_dropped() const;

  /// Watches a monitor of a net, or any of its outputs ("id.port"), from the next cycle in which the net runs until it
  /// ends. Any thread. Realtime: setup. @return the watch, or what is wrong, with the nearest name.
  [[nodiscard]] Result<std::shared_ptr<Watch>> watch(NetId net, std::string_view port,
                                                     const WatchOptions& options = {});
  /// The same for a channel.
  [[nodiscard]] Result<std::shared_ptr<Watch>> watch(std::string_view channel, const WatchOptions& options = {});
  /// Nothing comes any more; the watch says ended() once the cycle has let go of it. Never refused. Any thread.
  void unwatch(const std::shared_ptr<Watch>& watch);

  // -- Nets. Any thread. Realtime: setup. ----------------------------------------------------------------------------
  /// Verifies and compiles; a net that is right is Ready.
  [[nodiscard]] Result<NetId> load(const net::NetDescription& description, const LoadOptions& options = {});
  /// The same on a worker thread: Loading now, Ready or Rejected later (row L1). For real time; in lock-step load().
  [[nodiscard]] NetId load_async(net::NetDescription description, const LoadOptions& options = {});
  /// Why a net was rejected.
  [[nodiscard]] Diagnostics diagnostics(NetId net) const;
  /// Forgets a net that is not active, in the next cycle. Needs no room: it is refused for no other reason.
  /// @return false while it is active or Loading, or unknown.
  bool unload(NetId net);

  [[nodiscard]] bool knows(NetId net) const;
  [[nodiscard]] NetStatus status(NetId net) const;
  [[nodiscard]] NetState state(NetId net) const { return status(net).state; }
  /// The net itself; nullptr: not loaded, or still Loading. Name, ports, monitors and report may be read at any time;
  /// values of ports between steps (lock-step) or from the cycle thread: beside a running cycle watch() gives them.
  [[nodiscard]] NetHandle net(NetId net) const;

  // -- Requests. Any thread, lock-free. Carried out in the next step, after the nets were evaluated. ------------------
  /// @return the number that kDone or kRefused will carry; 0: the queue is full (512 since the last step), nothing will
  /// be done, and the caller has to ask again.
  RequestId start(NetId net) { return post(Transaction{.abort = {}, .cancel = {}, .start = {net}}); }
  RequestId cancel(NetId net) { return post(Transaction{.abort = {}, .cancel = {net}, .start = {}}); }
  /// The stop reaction, now. It has a path of its own, without a queue and without a limit: if the net is active in the
  /// next step, it is aborted there, and if it is not, it does not start there.
  /// @return as start(), but 0 only says that no event will carry an answer.
  RequestId abort(NetId net);
  [[nodiscard]] RequestId post(const Transaction& transaction) {
    return post(Rule{.condition = {}, .action = transaction});
  }
  [[nodiscard]] RequestId post(const Rule& rule);

  /// Brings an arm into another control mode while no net holds it; any class of change (row L4) is allowed here.
  /// kDone tells that the device is there, kRefused why it is not. Any thread, wait-free.
  /// @return as start(); 0 also for an arm that is not in this core.
  RequestId change_mode(std::string_view arm, device::ControlMode mode);

  /// Starts `successor` in the cycle in which `predecessor` ends, so that no cycle is empty (row L3). The seam is
  /// checked now, as far as both nets declare it, and again in that cycle against what is really sent. If it does not
  /// fit then, `from_rest` is started instead once its devices are at rest; without it the start is refused and the
  /// devices stop.
  /// @return the number of kDone or kRefused; or why it cannot be. Any thread. Realtime: setup.
  [[nodiscard]] Result<RequestId> schedule_after(NetId predecessor, NetId successor, NetId from_rest = 0);

  // -- The cycle. Cycle thread. Realtime: cyclic. --------------------------------------------------------------------
  void step();
  /// Ends every active net in the next step with this cause; their arms brake within their limits. No later request of
  /// that step starts anything. For an overrun or a second Ctrl-C. Any thread, wait-free; never refused.
  void stop_all(net::Cause::Code code, std::string_view text);
  /// Counts cycles that began late; for the real-time clock.
  void count_overruns(std::int64_t late_cycles);
  /// The next cycle to be run: 0 before the first step.
  [[nodiscard]] std::int64_t cycle() const;
  /// Time of the next cycle: cycle() * period.
  [[nodiscard]] Nanoseconds time() const;
  [[nodiscard]] Nanoseconds period() const;
  /// What happened in the last step, in order; valid until the next.
  [[nodiscard]] std::span<const Event> events() const;
  [[nodiscard]] Digest& digest();
  /// What a block of the digest is, for people: "net 3 'tare'", "device 'arm'". Realtime: setup.
  [[nodiscard]] std::string block_name(std::uint64_t block) const;
  /// The device that a block of the digest belongs to; nullptr: it is none of a device. Realtime: setup.
  [[nodiscard]] const device::Device* device_of_block(std::uint64_t block) const;
  [[nodiscard]] const Statistics& statistics() const;

  // -- For the watchdog. Any thread. ---------------------------------------------------------------------------------
  /// The cycle that is being run just now. Wait-free.
  [[nodiscard]] std::optional<std::int64_t> running_cycle() const;
  /// What a cycle that does not end is doing. Only while it is stuck. Realtime: setup.
  [[nodiscard]] Stall where_it_is() const;

 private:
  void keep(std::unique_ptr<device::Device> device);
  [[nodiscard]] Result<std::shared_ptr<Watch>> attach(NetId net, std::unique_ptr<Watch> watch);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace takt::rcc
