#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/device/backend.h"
#include "core/device/brake_ramp.h"
#include "core/device/description.h"
#include "hw/emulators/fri/interpolator.h"
#include "hw/emulators/fri/krl_program.h"
#include "hw/emulators/fri/quality_window.h"

namespace takt::hw::fri {

/// What of a controller is configured, or not known of the real one (docs/hardware.md, "What the emulator assumes").
struct ControllerOptions {
  Nanoseconds cycle = kMillisecond;  ///< of the interface: whole ms, 1 to 100
  std::string krl = "takt";          ///< convention of the KRL program
  QualityRules quality = {};
  int bridged = 20;                  ///< with so many answers missing in a row the arm is stopped
  double start_tolerance = 0.0175;   ///< rad: command and position may differ by that when command state begins
  double start_tolerance_m = 0.005;  ///< the same of a Cartesian command
  double velocity_factor = 1.05;     ///< of the model's limits: what the controller observes
  /// rad/s^2, what it observes of commanded accelerations: 1200 1200 1600 1600 2500 4400 4400 deg/s^2 in the file of
  /// the controller that TUM's FRICheck names. friStart() scales it.
  Joints acceleration{(Joints() << 20.9, 20.9, 27.9, 27.9, 43.6, 76.8, 76.8).finished()};
  bool task_frame_is_tool = true;    ///< $STIFFNESS.TASKFRAME: wrenches and stiffness in axes of the tool, else base
  std::uint16_t first_sequence = 1;  ///< of its counter
};

/// The state machine of a KRC with FRI: monitor and command state, the quality of the connection, what it checks, how
/// it falls back, and the KRL program that opens and starts the interface. It knows no wire. The arm behind it is told
/// where to be by at(); in monitor state it is held where it is. One thread. Realtime: cyclic but for the constructor
/// and news().
class Controller final : private KrlInterface {
 public:
  /// @param arm  7 joints; without a chain poses, Jacobian and dynamics stay empty
  Controller(std::shared_ptr<const device::ArmDescription> arm, const ControllerOptions& options);

  /// A command has come. @param now  the controller's time
  void take(const Command& command, Nanoseconds now);
  /// A cycle begins. @param machine  newest sample of the arm
  void begin_cycle(Nanoseconds now, const device::ArmSample& machine);
  /// What is sent at the beginning of this cycle. @return null in state off: nothing is sent
  [[nodiscard]] const Measurement* measurement() const { return state_ == State::kOff ? nullptr : &measurement_; }

  /// Where the arm is told to be.
  [[nodiscard]] motion::JointSample at(Nanoseconds now) const;
  /// The mode in which it is to follow, and how, in a mode of impedance.
  [[nodiscard]] device::ControlMode mode() const;
  [[nodiscard]] const device::Compliance& compliance() const { return compliance_; }
  /// Tool as KRL has it.
  void set_tool(const device::ToolSetting& tool) override { tool_ = tool; }

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] Quality quality() const { return window_.quality(); }
  /// Commands that counted for nothing: their reflected counter was never sent, or is too old.
  [[nodiscard]] std::uint64_t stale() const { return stale_; }
  /// How often it fell back from command to monitor state by itself.
  [[nodiscard]] std::uint64_t fallbacks() const { return fallbacks_; }
  /// What happened since the last call: "CMD", "MON: FRI interpolation error, joint a3 ...".
  [[nodiscard]] std::vector<std::string> news();

 private:
  struct Sent {
    Nanoseconds time = -1;
    bool answered = false;
    Nanoseconds round_trip = 0;
  };
  // -- KrlInterface
  void fri_open() override { enter(State::kMonitor, "friOpen"); }
  void fri_start(double safety_limits) override;
  void fri_stop() override;
  void fri_close() override;
  bool set_strategy(int strategy) override;
  [[nodiscard]] State fri_state() const override { return state_; }
  [[nodiscard]] Quality fri_quality() const override { return window_.quality(); }
  [[nodiscard]] bool starting() const override { return start_cycles_left_ > 0; }
  [[nodiscard]] const KrlValues& from_remote() const override { return command_.krl; }
  [[nodiscard]] KrlValues& to_remote() override { return to_remote_; }

  void enter(State state, std::string_view why);
  void look_at_machine(const device::ArmSample& machine);
  void judge_answers();
  void poll_krl(Nanoseconds now);
  void try_to_start();
  void follow_command();
  void bridge_gap();
  void continue_stop();
  void fall_back(const net::Text& why);
  void stop_motion();
  void stand(const Joints& q);
  [[nodiscard]] bool machine_is_in_mode() const;
  [[nodiscard]] bool commands_position() const;
  [[nodiscard]] std::optional<net::Text> start_mismatch() const;
  [[nodiscard]] std::optional<net::Text> wrong_command() const;
  [[nodiscard]] std::optional<net::Text> wrong_motion(const Interpolator& next) const;
  [[nodiscard]] std::optional<net::Text> take_compliance();
  [[nodiscard]] std::optional<Joints> commanded_joints() const;
  void fill_measurement(Nanoseconds now, const device::ArmSample& machine);
  void fill_dynamics(const Joints& q);
  [[nodiscard]] Joints commanded() const { return interpolator_.begin(); }

  std::shared_ptr<const device::ArmDescription> arm_;
  ControllerOptions options_;
  double cycle_;  // s
  device::ToolSetting tool_;
  std::unique_ptr<KrlProgram> program_;
  KrlValues to_remote_;
  Nanoseconds next_poll_ = 0;

  State state_ = State::kOff;
  Control control_ = Control::kPosition;
  bool power_ = false;
  double safety_limits_ = 0.0;
  int start_cycles_left_ = 0;
  int held_cycles_ = 0;  // in which the arm has been held where it is now, at least
  QualityWindow window_;
  std::uint16_t sequence_;
  std::array<Sent, 64> sent_{};  // by sequence
  Command command_;              // the newest
  bool has_command_ = false;     // for this cycle

  Nanoseconds begun_ = 0;
  Interpolator interpolator_;
  Joints before_fri_ = Joints::Zero();
  bool standing_ = false;  // knows where the arm is
  bool stopping_ = false;
  device::BrakeRamp ramp_;
  Nanoseconds ramp_begin_ = 0;
  device::Compliance compliance_;
  device::ArmSample machine_;
  Measurement measurement_;
  std::uint64_t stale_ = 0, fallbacks_ = 0;
  std::vector<std::string> news_;
};

}  // namespace takt::hw::fri
