#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cell/build/built_cell.h"
#include "cell/file/description.h"
#include "cell/run/cell_camera.h"
#include "serve/holders.h"

namespace takt::serve {

class HostedCell;
class ProgramDesk;
class Recordings;

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
  std::int64_t fault_cycle = 0;  ///< in which the fault came
};

/// A force/torque sensor as it was after a cycle.
struct SensorView {
  std::string name;
  std::optional<net::Wrench> wrench = {};  ///< as measured, in its measuring frame; nothing: no sample that counts
};

/// A gripper as it was after a cycle.
struct GripperView {
  std::string name;
  std::optional<device::GripperSample> sample = {};  ///< nothing: no sample yet
  bool held = false;
};

/// A digital or analog signal as it was after a cycle.
struct SignalView {
  std::string name;
  std::optional<device::ChannelValue> value = {};  ///< of an output what was sent last; nothing: no sample that counts
  bool held = false;                               ///< of an output: by a net
};

/// A cell after a cycle, copied for whoever asks.
struct CellView {
  std::int64_t cycle = 0;
  Nanoseconds time = 0;
  rcc::Digest::Value digest;
  bool connected = false;  ///< all devices are there: nets may start
  std::vector<ArmView> arms;
  std::vector<SensorView> sensors;
  std::vector<GripperView> grippers;
  std::vector<SignalView> signals;  ///< digital inputs, analog inputs, digital outputs, analog outputs
  struct Channel {
    std::string name;
    std::optional<device::ChannelValue> value = {};
    std::optional<Nanoseconds> age = {};
  };
  std::vector<Channel> channels;
  std::int64_t overruns = 0;         ///< cycles that began late
  Nanoseconds worst_cycle = 0;       ///< the longest one took so long; 0: it is not measured
  bool emergency_stop = false;       ///< somebody has pressed it, and it is not reset
  std::int64_t emergency_cycle = 0;  ///< in which that was
  cell::PictureState picture;        ///< where everything is, for pictures and poses
};

/// The channels by which somebody outside moves an arm by hand. They belong to the server and not to the cell: no
/// digest has them, no list of channels names them.
struct JogChannels {
  device::Channel* tool = nullptr;    ///< Twist, m/s and rad/s
  device::Channel* joints = nullptr;  ///< JointArray, rad/s or m/s
};

/// What a server sees of a cell, whoever runs it: nobody's program (HostedCell) or one that is watched (WatchedRun). No
/// function of it makes the cycle wait: copies are made between two cycles and published afterwards. Any thread, but
/// for what says otherwise.
class ServedCell {
 public:
  static constexpr std::size_t kEvents = 65'536;  ///< that are kept for whoever comes back
  virtual ~ServedCell();
  ServedCell(const ServedCell&) = delete;
  ServedCell& operator=(const ServedCell&) = delete;

  [[nodiscard]] rcc::ControlCore& core() { return *built_->core; }
  [[nodiscard]] Nanoseconds period() const { return built_->core->period(); }
  [[nodiscard]] const cell::BuiltCell& built() const { return *built_; }
  [[nodiscard]] const cell::Description& description() const { return *description_; }
  [[nodiscard]] Holders& holders() { return *holders_; }
  [[nodiscard]] rcc::Lease& lease() { return holders_->lease(); }
  [[nodiscard]] CellView view() const;

  /// Time goes on at the wall clock's pace, not by steps().
  [[nodiscard]] virtual bool realtime() const = 0;
  /// The program that commands this cell; null: its clients do.
  [[nodiscard]] virtual ProgramDesk* program() { return nullptr; }
  /// The cell that clients command; null: a program does.
  [[nodiscard]] virtual HostedCell* hosted() { return nullptr; }
  /// What clients record; null: who runs the program has decided that.
  [[nodiscard]] virtual Recordings* recordings() { return nullptr; }
  /// Lock-step: runs so many cycles, then calls `done` with the view after the last one, on the thread that runs the
  /// cell. Orders are carried out one after the other. @return false: the cell runs in real time, or too many wait
  [[nodiscard]] virtual bool steps(std::int64_t cycles, std::function<void(const CellView& view)> done);
  /// Ends all nets in the next cycle, and a program with them. @param by  who asked for it
  virtual void stop_all(const std::string& by);

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
  /// Who is told when there is something new to see, on the thread that publishes, outside of the cycle; empty: nobody.
  void on_news(std::function<void()> listener);
  /// Of an arm of the cell; where a program commands there are none.
  [[nodiscard]] JogChannels jog_channels(const std::string& arm) const { return jog_channels_.at(arm); }

 protected:
  ServedCell() = default;
  /// Once, before anything else. Both outlive this.
  void begin(const cell::Description& description, const cell::BuiltCell& built);
  void add_jog_channels();
  /// Before each cycle, on its thread. Realtime: cyclic.
  void begin_jog_channels();
  /// Between two cycles. Realtime loop: under its lock, so that it only copies.
  void copy(std::span<const rcc::Event> events);
  /// Outside of the loop's lock, never while copy() runs: what was copied may be looked at from now on.
  void publish();
  /// That there is something to see beside the view.
  void tell_listener();
  /// Cycles that began late by the pace of whoever runs this; the thread that copies.
  void count_late(std::int64_t cycles) { late_ += cycles; }
  [[nodiscard]] std::size_t unpublished() const { return fresh_events_.size(); }
  [[nodiscard]] const CellView& fresh() const { return fresh_; }

  std::atomic<bool> connected_ = false;  ///< all devices are there: nets may start
  mutable std::mutex mutex_;             ///< never taken while a cycle could wait for it

 private:
  const cell::Description* description_ = nullptr;
  const cell::BuiltCell* built_ = nullptr;
  std::optional<Holders> holders_;
  std::map<std::string, JogChannels, std::less<>> jog_channels_;
  std::int64_t late_ = 0;
  CellView fresh_;                         ///< of the thread that copies
  std::vector<LoggedEvent> fresh_events_;  ///< likewise, with no numbers yet
  CellView view_;
  std::deque<LoggedEvent> log_;
  std::int64_t next_sequence_ = 1;
  std::mutex listener_mutex_;
  std::function<void()> listener_;
};

}  // namespace takt::serve
