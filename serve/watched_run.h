#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>
#include <vector>

#include "cell/run/session.h"
#include "serve/program_desk.h"
#include "serve/served_cell.h"

namespace takt::serve {

/// The cell of a program that runs in this process: a server shows it, operators steer the program at its desk, and
/// nobody else commands. In lock-step it keeps the pace of the wall clock, and the run is the one without watchers, to
/// the bit, as long as nobody pauses it or changes its speed.
///
/// Use: make it before the server, give its hooks to the run, run the session, then ended(). The session outlives it.
class WatchedRun final : public ServedCell {
 public:
  /// @param options  of the run to come: gets the hooks; what hooks it has are called too. Outlives the run.
  WatchedRun(cell::Session& session, cell::RunOptions& options);
  ~WatchedRun() override;

  [[nodiscard]] bool realtime() const override { return true; }
  [[nodiscard]] ProgramDesk* program() override { return &desk_; }
  void stop_all(const std::string& by) override;
  /// The run is over; what it was may be looked at from now on.
  void ended(const cell::RunReport& report);

 private:
  using WallClock = std::chrono::steady_clock;
  void add_hooks(cell::RunOptions& options);
  /// After each cycle, on its thread. Realtime: cyclic, where the loop is.
  void after_cycle();
  void keep_pace();
  void take_up_pace();
  void publish_news(const std::stop_token& stop);

  const bool beside_loop_;  ///< the cycle has a thread of its own
  ProgramDesk desk_;
  std::mutex fresh_mutex_;           ///< copy() or publish(); the cycle only tries
  std::vector<rcc::Event> pending_;  ///< events that are not copied yet; of the cycle
  std::atomic<std::uint32_t> news_ = 0;
  WallClock::time_point start_;  ///< when the core's time was 0, by its pace
  std::jthread publisher_;       ///< last: it uses what is above
};

}  // namespace takt::serve
