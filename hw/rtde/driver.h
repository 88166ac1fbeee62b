#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/base/newest_slot.h"
#include "core/device/arm_agent.h"
#include "core/device/driver.h"
#include "core/device/force_torque_agent.h"
#include "core/emulation/state_hash.h"
#include "hw/rtde/client.h"
#include "hw/rtde/control_program.h"
#include "hw/rtde/dashboard_client.h"
#include "hw/rtde/modes.h"
#include "hw/rtde/terminals.h"
#include "hw/wire/byte_link.h"

namespace takt::hw::rtde {

/// How a UR controller is reached and driven.
struct DriverOptions {
  std::uint32_t host = hw::kLoopback;
  bool e_series = false;      ///< 5.x, 500 Hz; else CB3, 125 Hz
  std::string model = "UR5";  ///< begin of what "get robot model" must answer
  RegisterHalf registers = RegisterHalf::kUpper;
  double lookahead = 0.03, gain = 2000.0;  ///< of servoj()
  Nanoseconds margin = kMillisecond;       ///< for jitter of the wire and of both ends
  Nanoseconds transport = 0;               ///< that is known of the wire; counts for the age of samples
  bool power_on = false;                   ///< powers on and releases the brakes when it connects; else a person does

  [[nodiscard]] Nanoseconds cycle() const { return e_series ? 2 * kMillisecond : 8 * kMillisecond; }
};

/// Cycles of the controller from a package to the set point that answers it: one for the way there, two of its
/// interpolator.
inline constexpr int kLeadCycles = 3;

/// Causes of an arm that is not ready (ArmSample::fault).
enum class DriverFault : std::uint32_t {
  kNone = 0,
  kNotConnected = 0x5200'0001,
  kRefused,     ///< problems() says why
  kNotRunning,  ///< no power, or brakes closed
  kProtectiveStop,
  kSafetyStop,       ///< emergency stop, safeguard stop, violation, fault
  kOtherProgram,     ///< somebody else's program runs
  kProgramStopped,   ///< ours was stopped at the controller: reset()
  kProgramFailed,    ///< ours did not start
  kPackagesMissing,  ///< the program on the controller heard nothing for too long and braked
  kPaused,
  kPayload,  ///< the controller counts with another payload than it was told
  kStarting,
  kFreedrive,
  kConnectionLost,  ///< it was there; reset() once it is back
  kResetMissing     ///< the robot could move again, but nobody has called reset()
};

/// What was measured of a driver; counters only grow.
struct DriverCounts {
  std::uint64_t packages = 0;     ///< of data that came
  std::uint64_t sent = 0;         ///< answers
  std::uint64_t connections = 0;  ///< attempts
  std::uint64_t uploads = 0;      ///< of the program
  std::uint64_t misshapen = 0;    ///< packages that were not as agreed
  std::uint64_t repeated = 0;     ///< packages with the time of the one before: they say nothing new
  int loop_delay = 0;             ///< packages between what was sent and what the program followed last
};

/// The driver of a UR robot: RTDE for state and set points, the dashboard for power and the model, the secondary
/// interface for the program that it uploads. Everything of the wire happens in poll(), which one thread calls; the
/// functions of ArmBackend are for the cycle and wait-free, but for set_payload().
///
/// The program is uploaded only while no net holds the arm. After it has run and ended, whatever the cause (somebody at
/// the controller, a safety stop, a lost connection), it is uploaded again only after reset().
class Driver : public device::ArmDriver {
 public:
  /// @param network, clock  outlive the driver
  Driver(const DriverOptions& options, const device::DriverRequest& request, hw::Network& network, const Clock& clock);
  ~Driver() override;

  // -- The cycle -----------------------------------------------------------------------------------------------------
  void set_held(bool held) override;
  bool read(device::ArmSample& sample) override;
  void write(const device::ArmSetPoint& set_point) override { agent_.write(set_point); }
  void set_payload(const device::PayloadSetting& payload) override;
  void brake() override;
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override;
  [[nodiscard]] device::BackendTiming timing() const override;
  [[nodiscard]] device::ForceTorqueBackend* force_torque() override { return &force_; }
  [[nodiscard]] std::optional<Nanoseconds> packet_time() const override { return agent_.report().packet_time; }
  [[nodiscard]] device::IoDriver* terminals(const device::IoTerminals& /*machine*/) override { return block_.get(); }
  [[nodiscard]] device::ConnectionCounts connection() const override {
    const device::AgentReport& report = agent_.report();
    return {report.samples, report.dry, report.drift};
  }
  [[nodiscard]] std::vector<std::string> news() override;
  [[nodiscard]] std::string refusal() const override;

  // -- The wire: one thread
  // --------------------------------------------------------------------------------------------
  /// All that is due now.
  void poll();
  /// Waits until a package comes, at most so long.
  void wait(Nanoseconds timeout) { (void)rtde_link_.wait(timeout); }
  [[nodiscard]] const DriverCounts& counts() const { return counts_; }
  [[nodiscard]] const Diagnostics& problems() const { return problems_; }
  /// For the cycle's thread.
  [[nodiscard]] device::AgentReport agent_report() const { return agent_.report(); }
  [[nodiscard]] std::uint64_t hash() const;

  // -- People, any thread
  // ----------------------------------------------------------------------------------------------
  /// The cause of a stop was looked into: the program may be uploaded again.
  void reset() override { reset_.store(true); }
  /// The arm can be led by hand; only while no net holds it.
  void set_freedrive(bool on) { freedrive_wanted_.store(on); }

 private:
  enum class Stage : std::uint8_t { kApart, kConnecting, kSettingUp, kWaiting, kUploading, kStreaming, kRefused };
  struct ForceBackend final : device::ForceTorqueBackend {
    explicit ForceBackend(Driver& owner) : driver(owner) {}
    bool read(device::WrenchSample& sample) override { return driver.force_agent_.read(sample); }
    [[nodiscard]] device::BackendTiming timing() const override { return driver.timing(); }
    Driver& driver;
  };

  [[nodiscard]] static ClientRequest request_for(const DriverOptions& options, const TerminalBlock* block);
  [[nodiscard]] Nanoseconds now() const { return clock_.read().machine; }
  void set_stage(Stage stage);
  void begin_connecting();
  void lose_connection(const std::string& why);
  void step_connecting();
  void step_dashboard();
  void check_answer(const DashboardClient::Answer& answer);
  void receive();
  [[nodiscard]] bool is_new_package();
  void take_package();
  void watch_echo();
  void step_program();
  void step_waiting(RuntimeState runtime);
  void step_streaming(RuntimeState runtime);
  void note_stop();
  void upload();
  void answer_package();
  void take_force(std::uint64_t sequence, Nanoseconds instant);
  void take_terminals();
  void send(ControlMode mode, const motion::JointSample* state);
  void send_payload();
  void check_payload();
  void refuse(const Diagnostics& problems);
  void tell(std::string line);

  [[nodiscard]] const FieldValue& value(std::size_t field) const { return client_.values()[field]; }
  [[nodiscard]] int integer(std::size_t field) const { return static_cast<int>(value(field)[0]); }
  [[nodiscard]] bool running() const;
  [[nodiscard]] bool alive() const;
  [[nodiscard]] DriverFault state_fault() const;

  const DriverOptions options_;
  const std::shared_ptr<const device::ArmDescription> arm_;
  hw::Network& network_;
  const Clock& clock_;
  device::ArmAgent agent_;
  device::ForceTorqueAgent force_agent_;
  ForceBackend force_{*this};
  std::unique_ptr<TerminalBlock> block_;  // null: nobody asked for terminals
  ControlProgram program_;

  hw::ByteLink rtde_link_, dashboard_link_, script_link_;
  Client client_;
  DashboardClient dashboard_;
  Stage stage_ = Stage::kApart;
  double timestamp_ = -1.0;  ///< s, of the newest package; -1: none since the connection was made
  Nanoseconds stage_since_ = 0, last_package_ = 0, last_gap_ = -kSecond * 3600;
  bool model_known_ = false, may_upload_ = true;
  DriverFault fault_ = DriverFault::kNotConnected;
  std::int32_t sequence_ = 0;
  std::int32_t echo_ = 0;     // the number that the program says it followed last
  int echo_age_ = 1'000'000;  // packages since it changed
  bool uploaded_ = false;     // our program was seen running, and not seen stopped since
  DriverCounts counts_;
  Diagnostics problems_;
  std::vector<FieldValue> package_;  // to be sent

  // What the cycle and people ask for.
  /// Why nothing comes over the wire; kNone while packages do.
  std::atomic<DriverFault> wire_fault_ = DriverFault::kNotConnected;
  std::atomic<bool> held_ = false, brake_ = false, reset_ = false, freedrive_wanted_ = false;
  NewestSlot<device::PayloadSetting> payload_slot_;
  bool payload_told_ = false, payload_sent_ = false;
  Nanoseconds payload_since_ = 0;

  mutable std::mutex news_mutex_;
  std::vector<std::string> news_;
  std::string refusal_;  // guarded by news_mutex_
};

}  // namespace takt::hw::rtde
