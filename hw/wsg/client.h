#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/newest_slot.h"
#include "core/device/driver.h"
#include "core/emulation/state_hash.h"
#include "hw/wire/byte_link.h"
#include "hw/wsg/protocol/commands.h"

namespace takt::hw::wsg {

/// How a gripper is reached and driven.
struct ClientOptions {
  Endpoint remote{kLoopback, kPort};
  Nanoseconds update = 8 * kMillisecond;  ///< period of its automatic updates, whole milliseconds
  bool home = false;                      ///< references fingers that are not: they go to their end
  Nanoseconds transport = 0;              ///< that is known of the wire; counts for the age of samples
};

/// Causes of a gripper that is not ready (GripperSample::fault).
enum class Fault : std::uint32_t {
  kNone = 0,
  kNotConnected = 0x5747'0001,
  kStarting,
  kWrongGripper,   ///< its limits are not those of the model
  kNotReferenced,  ///< the fingers have to be homed
  kFastStop,
  kHardware,  ///< power, current, temperature or a finger
  kRefused,   ///< it refused a command: the news say which, and why
  kLost       ///< not connected any more
};

/// What was measured of a driver; counters only grow.
struct ClientCounts {
  std::uint64_t samples = 0;
  std::uint64_t connections = 0;  ///< that opened
  std::uint64_t motions = 0;      ///< commands that move the fingers
  std::uint64_t damaged = 0;      ///< packets with another checksum, and answers of another form
};

/// The driver of a WSG gripper, without its thread. What is commanded becomes a force limit and a motion: closing is
/// "grasp part", opening of fingers that hold a part "release part", all else "move". One motion at a time: one that is
/// under way is stopped before the next. poll() is called by one thread, the functions of GripperBackend by the cycle.
///
/// FAST STOP and faults are acknowledged at the first connection; later ones, as after a connection that broke, wait
/// for reset(). After it the fingers stay where they are until the next command.
class Client {
 public:
  /// @param network, clock  outlive the client
  Client(const ClientOptions& options, const device::GripperRequest& request, Network& network, const Clock& clock);

  // -- The cycle. Realtime: cyclic. ----------------------------------------------------------------------------------
  bool read(device::GripperSample& sample);
  void write(const device::GripperSetPoint& set_point);

  // -- Any thread ----------------------------------------------------------------------------------------------------
  void reset() { reset_ = true; }
  [[nodiscard]] static std::string fault_text(std::uint32_t fault);
  [[nodiscard]] std::vector<std::string> news();
  /// As of DeviceDriver.
  [[nodiscard]] std::string refusal() const;

  // -- The driver's thread -------------------------------------------------------------------------------------------
  /// Takes what has come, and sends what is due.
  void poll();
  /// Until something comes, at most `timeout` ns.
  void wait(Nanoseconds timeout) { (void)link_.wait(timeout); }
  /// Says good-bye, so that the gripper keeps what it holds.
  void leave();
  [[nodiscard]] bool connected() const { return link_.open(); }
  [[nodiscard]] const ClientCounts& counts() const { return counts_; }
  void add_state(emulation::StateHash& hash) const;

 private:
  /// What the client waits for before commands count, in this order.
  enum class Step : std::uint8_t {
    kIdle,
    kLimits,
    kAcknowledge,
    kState,
    kHome,
    kAcceleration,
    kUpdates,
    kRunning,
    kFailed
  };

  void service_connection(Nanoseconds now);
  void connect(Nanoseconds now);
  void watch_silence(Nanoseconds now);
  void lose(Nanoseconds now, const std::string& why);
  void ask(Command command, std::string_view payload, Nanoseconds now);
  void go_on(Step step, Nanoseconds now);
  void handle(const Packet& packet, Nanoseconds now);
  bool handle_set_up(Command command, const Answer& answer, Nanoseconds now);
  void handle_limits(const Answer& answer, Nanoseconds now);
  void handle_update(Command command, const Answer& answer, Nanoseconds now);
  void handle_motion(const Answer& answer);
  void refuse(Command command, Status status);
  void follow(Nanoseconds now);
  void begin_motion(Nanoseconds now);
  void acknowledge_on_reset(Nanoseconds now);
  void publish(Nanoseconds now);
  [[nodiscard]] Fault fault() const;
  [[nodiscard]] device::GripperState state();
  [[nodiscard]] bool holds() const;
  void tell(std::string line);
  /// Tells it, and keeps it until the device is tried again; empty: it is.
  void keep_refusal(std::string why);

  ClientOptions options_;
  std::shared_ptr<const device::GripperDescription> description_;
  Network& network_;
  const Clock& clock_;

  // Between the threads
  NewestSlot<device::GripperSetPoint> commands_;
  NewestSlot<device::GripperSample> samples_;
  std::atomic<bool> reset_ = false;
  mutable std::mutex news_mutex_;  // of news_ and refusal_ alone: the cycle never takes it
  std::vector<std::string> news_;
  std::string refusal_;

  // The connection
  ByteLink link_;
  PacketParser parser_;
  Step step_ = Step::kIdle;
  Nanoseconds next_try_ = 0, asked_at_ = 0, heard_at_ = 0;
  Command awaited_ = Command::kLoop;  // of the set-up
  std::size_t updates_asked_ = 0;

  // What the gripper says
  std::uint32_t flags_ = 0;
  GraspState grasp_ = GraspState::kIdle;
  double width_ = 0.0, speed_ = 0.0, force_ = 0.0;

  // What it is told
  device::GripperSetPoint wanted_, current_;
  std::optional<Command> motion_;     // under way
  std::optional<double> setting_;     // force limit that is being set, N
  std::optional<double> limit_;       // force limit that holds, N
  bool stopping_ = false;             // of the motion under way
  bool settled_ = true;               // the grasping state is newer than the end of the last motion
  bool blocked_ = false;              // the last motion was a move that met something
  std::optional<double> pressed_at_;  // width at which it did, m
  bool part_lost_ = false;            // what a move met is gone
  bool interrupted_ = false;          // the connection broke while a command was carried out
  bool refused_ = false, wrong_ = false;
  bool ran_ = false;            // once: it can be lost
  std::uint64_t answered_ = 0;  // the command that the gripper has accepted last
  device::GripperSample sample_;
  ClientCounts counts_;
};

}  // namespace takt::hw::wsg
