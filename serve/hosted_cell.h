#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "cell/build/cell_builder.h"
#include "cell/run/cell_run.h"
#include "cell/run/session.h"
#include "serve/served_cell.h"

namespace takt::serve {

/// A cell with its core and without a program: whoever wants something of it asks the core directly (what is marked
/// "any thread" there), or looks at a copy. Owned by whoever serves it; run() has a thread, everything else is for any
/// other.
class HostedCell final : public ServedCell {
 public:
  struct Options {
    cell::OpenOptions open;
    cell::RunOptions run;  ///< `realtime`: the wall clock's pace; else time goes on by steps() alone
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
  [[nodiscard]] bool realtime() const override { return options_.run.realtime; }
  [[nodiscard]] bool steps(std::int64_t cycles, std::function<void(const CellView& view)> done) override;

 private:
  HostedCell(cell::Description description, cell::BuiltCell built, std::vector<cell::ScheduledFault> faults,
             Diagnostics warnings, const Options& options);

  [[nodiscard]] bool interrupted() const;
  [[nodiscard]] bool end_asked() const { return stop_asked_ || interrupted(); }
  [[nodiscard]] bool clear() const;
  [[nodiscard]] bool have_set_points() const;
  void run_lockstep();
  [[nodiscard]] bool cycle_lockstep();
  void run_realtime();
  void settle_lockstep();

  struct Order {
    std::int64_t cycles;
    std::function<void(const CellView& view)> done;
  };

  Options options_;
  cell::Description description_;
  cell::BuiltCell built_;
  std::vector<cell::ScheduledFault> faults_;
  Diagnostics warnings_;
  std::vector<std::unique_ptr<cell::Expectation>> no_expectations_;
  std::optional<cell::CellRun> run_;
  std::atomic<bool> stop_asked_ = false;
  bool failed_ = false;
  std::condition_variable wake_;
  std::deque<Order> orders_;
};

}  // namespace takt::serve
