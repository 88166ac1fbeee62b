#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/diagnostics.h"
#include "core/net/compiled_net.h"
#include "core/rcc/control_core.h"
#include "core/rcc/net_bits.h"

namespace takt::rcc {

/// A loaded net with its life. Who may touch what: the loader until the state is Ready or Rejected; then the cycle
/// thread; `cause` and the cycles may be read by all once the state is Terminated.
struct NetEntry : std::enable_shared_from_this<NetEntry> {
  NetId id = 0;
  LoadOptions options;
  std::atomic<NetState> state = NetState::kLoading;
  std::unique_ptr<net::CompiledNet> net;
  Diagnostics diagnostics;
  std::vector<int> claims;  ///< places in the resource table
  struct DeclaredSeam {
    int place;
    device::Seam seam;
  };
  std::vector<DeclaredSeam> begins, ends;
  /// What the net declares of its end; nothing while it is Loading and another thread writes it. Any thread.
  [[nodiscard]] std::span<const DeclaredSeam> known_ends() const {
    if (state.load(std::memory_order_acquire) == NetState::kLoading) return {};
    return ends;
  }
  struct NeededState {
    int place;
    std::string state;  ///< of the device while the net runs, such as a control mode
  };
  std::vector<NeededState> needs;
  std::int64_t cancel_bound_cycles = 0;
  const net::Slot<net::Boolean>*goes_on = nullptr, *stopped = nullptr;  ///< LoadOptions; null: there is none
  /// Finds both of them in the net. Realtime: setup.
  void bind_flags(Diagnostics& wrong);
  std::vector<int> on_path;            ///< of the claims: what comes to rest by itself when the net is asked to stop
  std::int64_t stop_bound_cycles = 0;  ///< and how long that takes at most
  double cost_ns = 0.0;                ///< of a cycle, on this machine

  net::Cause cause;
  std::atomic<std::int64_t> first_cycle = -1, last_cycle = -1;
  std::int64_t cancel_cycle = -1;
  std::int64_t cancel_counts_from = -1;  ///< the bound does; later than the cancel while something goes on
  std::int64_t stop_cycle = -1;          ///< in which it was asked to stop (row S1)
  net::Cause stop_cause;
  std::int64_t abort_cycle = -1;  ///< in which the cycle took its abort; it does not start in that cycle

  std::atomic<bool> abort_asked = false, retire_asked = false;  ///< by any thread, with the bit of the slot
};

/// A counted handle: what it points to stays in memory as long as somebody has one, unloaded or not.
using EntryHandle = std::shared_ptr<const NetEntry>;

/// All nets by number. Loading and forgetting happens on any thread under a lock that the cycle never takes.
///
/// Who may look at a net: the cycle thread by find(), since only that thread takes a net out of its slot; every other
/// thread by hold(), which counts. An entry is destroyed by a loader, or by the last thread that gives its handle
/// back; never inside of a cycle.
class NetTable {
 public:
  /// Fits a compiled net into the core: claims, seams, bounds, cost. @return why it does not fit. Realtime: setup.
  using Bind = std::function<Diagnostics(NetEntry&)>;

  NetTable(int capacity, net::Environment& environment, Bind bind);
  ~NetTable();

  [[nodiscard]] Result<NetId> load(const net::NetDescription& description, const LoadOptions& options);
  [[nodiscard]] NetId load_async(net::NetDescription description, const LoadOptions& options);

  /// @return the entry or nullptr. Cycle thread. Realtime: cyclic, wait-free.
  [[nodiscard]] NetEntry* find(NetId id) const;
  /// The same for any thread, lock-free; nullptr: not loaded.
  [[nodiscard]] EntryHandle hold(NetId id) const { return share(id); }

  /// Requests that need no room. Any thread, lock-free. @return false if the net is not loaded.
  bool ask_abort(NetId id);
  bool ask_retire(NetId id);
  /// Calls abort(NetEntry&) for each net whose abort was asked for since the last call. Cycle thread. Realtime: cyclic.
  template <class Abort>
  void take_aborts(Abort abort) {
    aborts_.take([&](std::size_t slot) {
      NetEntry* entry = slots_[slot].entry.load(std::memory_order_acquire);
      if (entry != nullptr && entry->abort_asked.exchange(false, std::memory_order_acq_rel)) abort(*entry);
    });
  }
  /// Lets go of the nets that were asked to be forgotten, of those that are active by now when they have ended: they
  /// are not found any more, and a loader frees them. Cycle thread. Realtime: cyclic.
  void take_retired();

 private:
  struct Slot {
    std::atomic<NetEntry*> entry = nullptr;          ///< what find() and hold() see
    std::atomic<NetEntry*> retired = nullptr;        ///< what the cycle thread has let go of
    mutable std::atomic<std::uint32_t> looking = 0;  ///< threads in hold() just now
    bool taken = false;                              ///< under mutex_; until the entry is freed
  };
  struct Job {
    std::shared_ptr<NetEntry> entry;
    net::NetDescription description;
  };
  [[nodiscard]] std::shared_ptr<NetEntry> share(NetId id) const;
  /// An entry of its own slot that nobody finds yet; nullptr: no slot is free.
  std::shared_ptr<NetEntry> reserve(const LoadOptions& options);
  void publish(NetEntry& entry);
  /// Gives back what was never published.
  void drop(const std::shared_ptr<NetEntry>& entry);
  void collect();
  void compile(NetEntry& entry, const net::NetDescription& description) noexcept;
  void compile_or_throw(NetEntry& entry, const net::NetDescription& description);
  void work(const std::stop_token& stop);
  [[nodiscard]] std::size_t slot_of(NetId id) const { return id % slots_.size(); }

  std::vector<Slot> slots_;
  NetBits aborts_, retirements_;
  net::Environment& environment_;
  Bind bind_;
  NetId last_id_ = 0;
  std::vector<std::shared_ptr<NetEntry>> entries_;

  std::mutex mutex_;  ///< loaders among themselves
  std::mutex compile_mutex_;
  std::condition_variable_any wake_;
  std::deque<Job> jobs_;
  std::jthread worker_;
};

}  // namespace takt::rcc
