#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/findings.h"
#include "core/net/compiled_net.h"
#include "core/rcc/control_core.h"

namespace takt::rcc {

/// A loaded net with its life. Who may touch what: the loader until the state is Ready or Rejected; then the cycle
/// thread; `cause` and the cycles may be read by all once the state is Terminated.
struct NetEntry {
  NetId id = 0;
  LoadOptions options;
  std::atomic<NetState> state = NetState::kLoading;
  std::unique_ptr<net::CompiledNet> net;
  Findings findings;
  std::vector<int> claims;  ///< places in the resource table
  struct DeclaredSeam {
    int place;
    device::Seam seam;
  };
  std::vector<DeclaredSeam> begins, ends;
  struct NeededState {
    int place;
    std::string state;  ///< of the device while the net runs, such as a control mode
  };
  std::vector<NeededState> needs;
  std::int64_t cancel_bound_cycles = 0;
  std::vector<int> on_path;            ///< of the claims: what comes to rest by itself when the net is asked to stop
  std::int64_t stop_bound_cycles = 0;  ///< and how long that takes at most
  double cost_ns = 0.0;                ///< of a cycle, on this machine

  net::Cause cause;
  std::atomic<std::int64_t> first_cycle = -1, last_cycle = -1;
  std::int64_t cancel_cycle = -1;
  std::int64_t stop_cycle = -1;  ///< in which it was asked to stop (row S1)
  net::Cause stop_cause;
};

/// All nets by number. Loading and forgetting happens on any thread under a lock that the cycle never takes; the cycle
/// finds entries through atomic pointers. An entry is freed only after the cycle thread has let go of it.
class NetTable {
 public:
  /// Fits a compiled net into the core: claims, seams, bounds, cost. @return why it does not fit. Realtime: setup.
  using Bind = std::function<Findings(NetEntry&)>;

  NetTable(int capacity, net::Environment& environment, Bind bind);
  ~NetTable();

  [[nodiscard]] Result<NetId> load(const net::NetDescription& description, const LoadOptions& options);
  [[nodiscard]] NetId load_async(net::NetDescription description, const LoadOptions& options);

  /// @return the entry or nullptr. Realtime: cyclic, wait-free.
  [[nodiscard]] NetEntry* find(NetId id) const;

  /// The cycle thread lets go of an entry; it is not found any more and freed by collect(). Realtime: cyclic.
  void retire(NetEntry& entry);
  /// Frees retired entries. Realtime: setup.
  void collect();
  /// Names of a net and of the primitive that it began last, while the cycle is stuck in it. Any thread. Realtime:
  /// setup.
  [[nodiscard]] std::pair<std::string, std::string> where_it_is(NetId id);

 private:
  struct Job {
    NetEntry* entry;
    net::NetDescription description;
  };
  NetEntry* make_entry(const LoadOptions& options);
  void compile(NetEntry& entry, const net::NetDescription& description);
  void work(const std::stop_token& stop);

  std::vector<std::atomic<NetEntry*>> slots_;
  net::Environment& environment_;
  Bind bind_;
  NetId last_id_ = 0;
  std::vector<std::unique_ptr<NetEntry>> entries_;
  std::vector<std::atomic<NetEntry*>> retired_;  ///< as slots_: what the cycle thread has let go of

  std::mutex mutex_;  ///< loaders among themselves
  std::mutex compile_mutex_;
  std::condition_variable_any wake_;
  std::deque<Job> jobs_;
  std::jthread worker_;
};

}  // namespace takt::rcc
