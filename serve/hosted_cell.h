#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cell/build/cell_builder.h"
#include "cell/run/cell_run.h"
#include "cell/run/session.h"
#include "serve/follow_log.h"
#include "serve/recordings.h"
#include "serve/served_cell.h"

namespace takt::serve {

/// A cell with its core and without a program: whoever wants something of it asks the core directly (what is marked
/// "any thread" there), or looks at a copy. Owned by whoever serves it; run() has a thread, everything else is for any
/// other.
class HostedCell final : public ServedCell {
 public:
  struct Options {
    cell::OpenOptions open;
    cell::RunOptions run;                   ///< `realtime`: the wall clock's pace; else time goes on by steps() alone
    std::filesystem::path recordings = {};  ///< folder of those that clients ask for; empty: they may not
  };

  /// Reads and builds the cell of a scenario, or a cell without a program. @return it, or all that is wrong with it.
  [[nodiscard]] static Result<std::unique_ptr<HostedCell>> open(const std::filesystem::path& file,
                                                                const device::ModelLibrary& models,
                                                                const Options& options);
  ~HostedCell() override;

  /// Until stop() or an interrupt. Then everything that runs comes to rest. @return the report
  [[nodiscard]] cell::RunReport run();
  /// Any thread.
  void stop();

  [[nodiscard]] const Diagnostics& warnings() const { return warnings_; }
  [[nodiscard]] Recordings* recordings() override { return &recordings_; }
  [[nodiscard]] bool realtime() const override { return options_.run.realtime; }
  [[nodiscard]] bool steps(std::int64_t cycles, std::function<void(const CellView& view)> done) override;
  [[nodiscard]] HostedCell* hosted() override { return this; }
  void stop_all(const std::string& by) override;

  [[nodiscard]] FollowLog& follow_log() { return *follow_; }
  /// STOP: ends all nets in the next cycle. One thread; needs no room, and nothing comes before it.
  void stop_nets(const net::Text& why);
  /// Has something done by whoever runs the cell, between two cycles and in order with steps().
  void between_cycles(std::function<void(cell::CellRun& run)> task);
  /// What a program means to touch from now on; in real time, where it is told late, what it meant until now stays so
  /// for a moment. Whoever runs the cell.
  void set_touching(std::set<std::string, std::less<>> devices);
  /// Wakes whoever runs the cell, if he waits for steps().
  void wake();

 private:
  HostedCell(cell::Description description, cell::BuiltCell built, std::vector<cell::ScheduledFault> faults,
             Diagnostics warnings, const Options& options);

  [[nodiscard]] bool interrupted() const;
  [[nodiscard]] bool end_asked() const { return stop_asked_ || interrupted(); }
  [[nodiscard]] bool clear() const;
  [[nodiscard]] bool have_set_points() const;
  void run_lockstep();
  [[nodiscard]] bool cycle_lockstep();
  /// Before each cycle, on its thread. Realtime: cyclic.
  void begin_cycle();
  void do_tasks();
  void run_realtime();
  void settle_lockstep();
  void look_around();

  struct Order {
    std::int64_t cycles;
    std::function<void(const CellView& view)> done;
  };

  Options options_;
  cell::Description description_;
  cell::BuiltCell built_;
  std::vector<cell::ScheduledFault> faults_;
  Diagnostics warnings_;
  Recordings recordings_;
  std::optional<FollowLog> follow_;  ///< once there are holders
  std::vector<std::unique_ptr<cell::Expectation>> expectations_;
  std::optional<cell::CellRun> run_;
  std::atomic<bool> stop_asked_ = false;
  bool failed_ = false;
  std::set<std::string, std::less<>> touching_, touched_;  ///< now, and until then
  std::int64_t touching_since_ = 0;                        ///< cycle
  std::condition_variable wake_;
  std::deque<Order> orders_;
  std::vector<std::function<void(cell::CellRun& run)>> tasks_;
  net::Text stop_why_;  ///< valid with stop_nets_
  std::atomic<bool> stop_nets_ = false;
  bool woken_ = false;
};

}  // namespace takt::serve
