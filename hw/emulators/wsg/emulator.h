#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/device/driver.h"
#include "core/device/gripper.h"
#include "hw/wire/byte_link.h"
#include "hw/wire/network.h"
#include "hw/wsg/protocol/commands.h"

namespace takt::hw::wsg {

/// Settings of the gripper, as its web page has them.
struct EmulatorOptions {
  bool referenced = true;     ///< the fingers were homed since it was switched on
  bool stop_on_leave = true;  ///< "error state on TCP disconnect": FAST STOP when a client goes without a word
};

/// A gripper of the WSG series on the wire, around a machine that does what it is told. One client at a time, one
/// motion at a time. One thread.
class Emulator final : public device::ControllerEmulator {
 public:
  /// @param network  outlives the emulator
  Emulator(const EmulatorOptions& options, std::shared_ptr<const device::GripperDescription> description,
           Network& network, std::shared_ptr<device::GripperBackend> machine);
  /// Opens the port. Realtime: setup.
  [[nodiscard]] Result<void> listen(const Endpoint& local);

  /// A cycle of the machine: look(), serve() and update() in one.
  void advance(Nanoseconds now) override;
  /// Reads the machine.
  void look();
  /// Accepts clients and answers what they have sent.
  void serve();
  /// Sends the updates that are due.
  void update(Nanoseconds now);
  [[nodiscard]] std::vector<std::string> news() override;

  /// Cuts the client off, as a gripper does that restarts; what was set up is gone.
  void restart();
  /// A fault of the machine, as if its power failed.
  void set_fault(std::uint32_t flag) { fault_flags_ |= flag; }
  [[nodiscard]] GraspState grasp_state() const { return grasp_; }
  [[nodiscard]] std::uint32_t flags() const;
  [[nodiscard]] bool has_client() const { return client_ != nullptr; }
  [[nodiscard]] const device::GripperSetPoint& set_point() const { return set_point_; }

 private:
  struct Client {
    ByteLink link;
    PacketParser parser;
    bool leaves = false;  ///< it has said so
  };
  struct Update {
    bool on = false, on_change_only = false;
    Nanoseconds period = 0, due = 0;
    std::string sent;  ///< last
  };
  static constexpr std::uint8_t kFirstUpdate = 0x40, kUpdateCount = 7;

  void accept();
  void drop_client();
  void handle(const Packet& packet);
  void handle_motion(Command command, const Packet& packet);
  void handle_stop(Command command);
  void handle_state(Command command, const Packet& packet);
  [[nodiscard]] bool handle_setting(Command command, const Packet& packet);
  void answer(Command command, Status status, std::string_view parameters = {});
  [[nodiscard]] std::optional<std::string> state_payload(Command command) const;
  void finish_motion();
  void abort_motion();
  void stand();
  void go(double width, double speed);

  EmulatorOptions options_;
  std::shared_ptr<const device::GripperDescription> description_;
  Network& network_;
  std::shared_ptr<device::GripperBackend> machine_;
  std::unique_ptr<StreamListener> listener_;
  std::unique_ptr<Client> client_;
  std::array<Update, kUpdateCount> updates_;
  std::vector<std::string> news_;

  device::GripperSample sample_;
  device::GripperSetPoint set_point_;
  std::optional<Command> motion_;  // under way
  bool stop_on_block_ = false;     // of it
  bool stop_asked_ = false;        // a stop waits for the fingers to stand
  GraspState grasp_ = GraspState::kIdle;
  bool referenced_, fast_stopped_ = false;
  std::uint32_t fault_flags_ = 0, motion_flags_ = 0;
  double acceleration_, force_limit_;
};

}  // namespace takt::hw::wsg
