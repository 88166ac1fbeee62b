#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/net/primitive.h"
#include "core/rcc/event_buffer.h"
#include "core/rcc/net_table.h"
#include "core/rcc/resources.h"
#include "core/rcc/rules.h"

namespace takt::rcc {

/// Runs the active nets and moves them through their life (rows L1, L5, L6, L7). Cycle thread only.
class Executor {
 public:
  Executor(NetTable& nets, ResourceTable& resources, EventBuffer& events, int capacity);

  /// Evaluates every active net once, in the order of their numbers. Realtime: cyclic.
  void evaluate(const net::Cycle& cycle);
  /// Ends the nets that ended, failed, lost a device or outstayed their cancel bound. Realtime: cyclic.
  void end_finished(std::int64_t cycle);

  /// What a transaction would do, before it is done. @return the net that forbids it and why, or nothing.
  struct Refusal {
    NetId net = 0;
    net::Text text;
    bool later = false;  ///< a device is, or can be, on its way into the state that the net needs: ask again
  };
  [[nodiscard]] std::optional<Refusal> check(const Transaction& transaction) const;
  /// Sets devices on their way into the states that the nets to be started need; check() has said "later".
  void prepare(const Transaction& transaction);
  /// Does it; check() has found nothing. Realtime: cyclic.
  void carry_out(const Transaction& transaction, std::int64_t cycle);

  /// True if every device that the transaction's nets want to start with is at rest after this cycle, free and ready to
  /// be taken.
  [[nodiscard]] bool can_rest(const Transaction& transaction) const;

  /// The net that is evaluated just now; 0: none. Any thread, wait-free.
  [[nodiscard]] NetId current() const { return current_.load(std::memory_order_relaxed); }

  /// Most that the running nets may cost in a cycle, ns (row T5); 0: no bound.
  void set_budget(double budget_ns) { budget_ns_ = budget_ns; }
  /// What the running nets cost in a cycle, ns, as far as it is known. Any thread.
  [[nodiscard]] double load_ns() const { return load_ns_.load(std::memory_order_relaxed); }

  /// Carries out the aborts that were asked for by ControlCore::abort(), which nothing refuses: what runs is aborted,
  /// what does not run is not started in this cycle. Realtime: cyclic.
  void abort_asked(std::int64_t cycle);

  /// Ends a net in which something went wrong: its devices stop (rows S2, L6).
  void abort(NetEntry& entry, const net::Cause& cause, std::int64_t cycle);

  /// Row S1, before evaluate(): nets that lost a device, or all that hold what stops in an emergency, are asked to
  /// bring what moves on paths to rest on them, from this cycle on; they end when it rests, or are aborted at their
  /// bound. Nets that cannot do that are left as they are. Realtime: cyclic.
  void stop_where_lost(std::int64_t cycle);
  void stop_on_path(const net::Cause& cause, std::int64_t cycle);
  /// Aborts all nets that hold what stops in an emergency, or all nets, and refuses every start of this cycle.
  /// @param those_on_path  also those that are coming to rest on their paths. Realtime: cyclic.
  void stop_for_emergency(const net::Cause& cause, bool those_on_path, std::int64_t cycle);
  void stop_all(const net::Cause& cause, std::int64_t cycle);
  /// What latches the emergency stop in this cycle, or nothing: the cause of devices that are lost meanwhile.
  void set_emergency(const std::optional<net::Text>& emergency) { emergency_ = emergency; }
  /// A new cycle: starts are allowed until something stops.
  void allow_starts() { stopped_by_ = {}; }

  /// Takes the nets that have ended off the list; after abort(), which may be called while the list is walked.
  void forget_ended();

  [[nodiscard]] std::span<NetEntry* const> active() const { return active_; }
  [[nodiscard]] NetEntry* find(NetId net) const { return nets_.find(net); }

 private:
  void start(NetEntry& entry, std::int64_t cycle);
  void end(NetEntry& entry, const net::Cause& cause, std::int64_t cycle);
  void move_to(NetEntry& entry, NetState state);
  [[nodiscard]] std::optional<net::Text> refuse_end(const NetEntry& entry, const Transaction& transaction) const;
  [[nodiscard]] std::optional<Refusal> refuse_start(const NetEntry& entry, const Transaction& transaction) const;
  [[nodiscard]] static std::optional<Refusal> refuse_contradiction(const Transaction& transaction);
  /// Row T5 for all nets of a transaction together; what it aborts or ends makes room.
  [[nodiscard]] std::optional<Refusal> refuse_cost(const Transaction& transaction) const;
  /// What a net that starts needs of a device that it claims.
  [[nodiscard]] static device::StateAnswer answer_of(const device::Actuator& actuator, const NetEntry& entry,
                                                     int place);
  [[nodiscard]] std::optional<net::Text> refuse_seam(const NetEntry& entry) const;
  [[nodiscard]] const device::Actuator* lost_actuator(const NetEntry& entry) const;
  [[nodiscard]] net::Cause cause_of_loss(const device::Actuator& lost, std::int64_t cycle) const;
  [[nodiscard]] bool stops_in_emergency(const NetEntry& entry) const;
  void begin_stop(NetEntry& entry, const net::Cause& cause, std::int64_t cycle);
  void go_on_stopping(NetEntry& entry, std::int64_t cycle);

  NetTable& nets_;
  ResourceTable& resources_;
  EventBuffer& events_;
  std::optional<net::Text> stopped_by_;
  std::optional<net::Text> emergency_;
  std::atomic<NetId> current_ = 0;
  std::atomic<double> load_ns_ = 0.0;
  double budget_ns_ = 0.0;
  std::int64_t cycle_ = -1;        ///< that is being run
  std::vector<NetEntry*> active_;  ///< by number; never grows beyond its capacity
};

}  // namespace takt::rcc
