#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "cell/build/cell_builder.h"
#include "cell/file/description.h"
#include "cell/run/cell_camera.h"
#include "cell/run/cell_run.h"
#include "cell/run/session.h"
#include "core/rcc/lease.h"

namespace takt::serve {

/// Something that happened in the core, with its number in the log of the server.
struct LoggedEvent {
  std::int64_t sequence = 0;  ///< from 1 on, without gaps
  std::int64_t cycle = 0;
  rcc::Event event;
};

/// An arm as it was after a cycle. Joints in the order of its URDF, rad or m; size 0: there was nothing yet.
struct ArmView {
  std::string name;
  device::JointVector q_measured = {}, q_commanded = {}, dq_measured = {}, tau_measured = {};
  device::ControlMode mode = device::ControlMode::kPosition;
  bool ready = false, at_rest = false, held = false;
  std::uint32_t fault = 0;
};

/// A cell after a cycle, copied for whoever asks.
struct CellView {
  std::int64_t cycle = 0;
  Nanoseconds time = 0;
  rcc::Digest::Value digest;
  bool connected = false;  ///< all devices are there: nets may start
  std::vector<ArmView> arms;
  struct Channel {
    std::string name;
    std::optional<device::ChannelValue> value = {};
    std::optional<Nanoseconds> age = {};
  };
  std::vector<Channel> channels;
  cell::PictureState picture;  ///< where everything is, for pictures and poses
};

/// The channels by which somebody outside moves an arm by hand. They belong to the server and not to the cell: no
/// digest has them, no list of channels names them.
struct JogChannels {
  device::Channel* tool = nullptr;    ///< Twist, m/s and rad/s
  device::Channel* joints = nullptr;  ///< JointArray, rad/s or m/s
};

/// A cell with its core and without a program: whoever wants something of it asks the core directly (what is marked
/// "any thread" there), or looks at a copy. No function of it makes the cycle wait: copies are made between two cycles
/// and published afterwards. Owned by whoever serves it; run() has a thread, everything else is for any other.
class HostedCell {
 public:
  struct Options {
    cell::OpenOptions open;
    cell::RunOptions run;  ///< `realtime`: the wall clock's pace; else time goes on by steps() alone
  };
  static constexpr std::size_t kEvents = 65'536;  ///< that are kept for whoever comes back

  /// Reads and builds the cell of a scenario, or a cell without a program. @return it, or all that is wrong with it.
  [[nodiscard]] static Result<std::unique_ptr<HostedCell>> open(const std::filesystem::path& file,
                                                                const device::ModelLibrary& models,
                                                                const Options& options);
  ~HostedCell();
  HostedCell(const HostedCell&) = delete;
  HostedCell& operator=(const HostedCell&) = delete;

  /// Until stop() or an interrupt. Then everything that runs comes to rest. @return the report
  [[nodiscard]] cell::RunReport run();
  /// Any thread.
  void stop();

  // -- Any thread ----------------------------------------------------------------------------------------------------
  [[nodiscard]] rcc::ControlCore& core() { return *built_.core; }
  [[nodiscard]] Nanoseconds period() const { return built_.core->period(); }
  [[nodiscard]] const cell::BuiltCell& built() const { return built_; }
  [[nodiscard]] const cell::Description& description() const { return description_; }
  [[nodiscard]] const Diagnostics& warnings() const { return warnings_; }
  [[nodiscard]] bool realtime() const { return options_.run.realtime; }
  [[nodiscard]] rcc::Lease& lease() { return lease_; }
  [[nodiscard]] CellView view() const;

  /// Events from a number on, at most `most`. `lost`: some of them are too old and not kept any more; `next` is the
  /// number to ask for the next time.
  struct Events {
    std::vector<LoggedEvent> events;
    std::int64_t next = 1;
    bool lost = false;
  };
  [[nodiscard]] Events events_from(std::int64_t sequence, std::size_t most) const;
  /// The number that the next event will have.
  [[nodiscard]] std::int64_t next_event() const;
  /// Who is told when there is something new to see, on the thread of run(), outside of the cycle; empty: nobody.
  void on_news(std::function<void()> listener);
  /// Of an arm of the cell.
  [[nodiscard]] JogChannels jog_channels(const std::string& arm) const { return jog_channels_.at(arm); }

  /// Lock-step: runs so many cycles, then calls `done` with the view after the last one, on the thread of run(). Orders
  /// are carried out one after the other. @return false: the cell runs in real time, or too many orders wait
  [[nodiscard]] bool steps(std::int64_t cycles, std::function<void(const CellView& view)> done);

 private:
  HostedCell(cell::Description description, cell::BuiltCell built, std::vector<cell::ScheduledFault> faults,
             Diagnostics warnings, const Options& options);

  [[nodiscard]] bool interrupted() const;
  [[nodiscard]] bool end_asked() const { return stop_asked_ || interrupted(); }
  [[nodiscard]] bool clear() const;
  [[nodiscard]] bool have_set_points() const;
  void copy(std::span<const rcc::Event> events);
  void publish();
  void run_lockstep();
  [[nodiscard]] bool cycle_lockstep();
  void add_jog_channels();
  /// Before each cycle, on its thread. Realtime: cyclic.
  void begin_cycle();
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
  rcc::Lease lease_;
  std::vector<std::unique_ptr<cell::Expectation>> no_expectations_;
  std::optional<cell::CellRun> run_;
  std::map<std::string, JogChannels, std::less<>> jog_channels_;
  std::atomic<bool> stop_asked_ = false;
  bool connected_ = false, failed_ = false;

  CellView fresh_;                         ///< of the thread of run()
  std::vector<LoggedEvent> fresh_events_;  ///< likewise, with no numbers yet
  mutable std::mutex mutex_;               ///< never taken while a cycle could wait for it
  std::condition_variable wake_;
  CellView view_;
  std::deque<LoggedEvent> log_;
  std::int64_t next_sequence_ = 1;
  std::deque<Order> orders_;
  std::mutex listener_mutex_;
  std::function<void()> listener_;
};

}  // namespace takt::serve
