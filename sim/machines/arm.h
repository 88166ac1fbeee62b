#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "core/base/random.h"
#include "core/device/backend.h"
#include "core/device/brake_ramp.h"
#include "core/kinematics/chain.h"
#include "sim/machines/arm_law.h"
#include "sim/machines/friction_observer.h"
#include "sim/machines/joint_drive.h"
#include "sim/model/device.h"
#include "sim/model/sample_line.h"
#include "sim/model/world_description.h"

namespace takt::sim {

/// Why a simulated arm takes no set points (ArmSample::fault).
enum class ArmFault : std::uint32_t {
  kNone = 0,
  kSetPointInvalid = 1,    ///< not finite or of the wrong size
  kFollowingError = 2,     ///< a joint is too far from its set point
  kOverspeed = 3,          ///< a joint is faster than the controller allows
  kComplianceInvalid = 4,  ///< outside what the device allows, or of another mode
  kStopped0 = 5,           ///< stopped by category 0, 1, 2 (ArmBackend's StopCategory)
  kStopped1 = 6,
  kStopped2 = 7,
  kExternalTorque = 8,  ///< protective stop: pushed by its surroundings, or pushing
  kTips = 9,            ///< of a base: the load is beyond its wheels
};
/// A fault word is the fault, and from bit 8 on the number of the joint that it is about, from 1; 0: of none.
[[nodiscard]] constexpr ArmFault fault_kind(std::uint32_t word) { return static_cast<ArmFault>(word & 0xffu); }

/// An arm in MuJoCo with its controller: it computes from the URDF and sees only what a real arm measures (row D6).
/// The laws are those of ArmLaw, clipped to the effort limits of the URDF. They run before each physics step, as joint
/// loops are faster than the cycle, and extrapolate the set point within the cycle by its dq and ddq. A set point
/// written in cycle k acts from the step of cycle k on; in a cycle without one the arm holds the last position. Torque
/// sensors are one physics step older than the positions beside them.
///
/// It keeps the classes of mode changes by itself (row L4): what is forbidden, or asked for in motion, changes nothing.
/// A change is bumpless: what the two laws differ by fades away. Owned by its World. Thread: the one that steps the
/// world. Realtime: cyclic but for the constructor.
class SimArm final : public device::ArmBackend, public SimDevice {
 public:
  SimArm(const SimArmDescription& description, ArmPlant plant, std::uint64_t seed);

  bool read(device::ArmSample& sample) override;
  void write(const device::ArmSetPoint& set_point) override;
  void write_compliance(const device::Compliance& compliance) override;
  void change_mode(device::ControlMode mode) override;
  /// The controller believes it, the plant does not change.
  void set_payload(const device::PayloadSetting& payload) override;
  void set_tool(const device::ToolSetting& tool) override;
  void brake() override;
  [[nodiscard]] std::string fault_text(std::uint32_t fault) const override;
  [[nodiscard]] device::BackendTiming timing() const override;

  /// Its own stop, as by a button at the cabinet: nothing of the core is asked. It is told in the sample as a fault,
  /// and release_brakes() is needed after it. A worse stop (a smaller category) may follow at any time.
  void stop(device::StopCategory category);
  /// What the operator does at the panel: forgets the fault, opens the brakes, holds where the arm is.
  void release_brakes();
  [[nodiscard]] bool braked() const { return braked_; }
  [[nodiscard]] device::ControlMode mode() const { return compliance_.mode; }
  [[nodiscard]] const kinematics::Chain& chain() const { return plant_.chain; }
  [[nodiscard]] const kinematics::Payload& payload() const { return payload_; }
  /// Motor torque of the last physics step, Nm.
  [[nodiscard]] const JointVector& motor_torque() const { return motor_torque_; }
  /// The same before it was cut to the effort limits.
  [[nodiscard]] const JointVector& wanted_torque() const { return wanted_torque_; }

  void start(const mjData_& data) override;
  void actuate(mjData_& data, const Substep& step) override;
  void measure(const mjData_& data, Nanoseconds now) override;
  [[nodiscard]] bool stands() const override { return plant_.drive && (braked_ || stuck_); }
  void stream(StateStream& state) override;

 private:
  void read_plant(const mjData_& data);
  void gather(const mjData_& data);
  void compute_torque(const Substep& step);
  [[nodiscard]] JointVector unknown_friction(double duration);
  void supervise();
  void protect();
  /// @param joint  that it is about; -1: none
  void trip(ArmFault fault, Eigen::Index joint = -1);
  void take_set_point();
  void stick_or_let_go();
  [[nodiscard]] JointVector torque_on_plant(double duration);
  void follow_own_stop();
  void continue_change();
  void enter(device::ControlMode mode);
  void fade_from_last_torque() { fade_ = 1.0; }
  void estimate_external(const device::ArmSample& sample);
  void stream_mode(StateStream& state);
  void stream_stop(StateStream& state);
  [[nodiscard]] bool follows() const { return !braked_ && !own_stop_ && !change_; }

  ArmControlParameters control_;
  ArmMeasurement measurement_;
  JointVector torque_offset_;
  double payload_mass_error_ = 0.0;
  ArmPlant plant_;
  kinematics::Payload payload_;  // as the controller believes
  Eigen::Isometry3d X_FT_ = Eigen::Isometry3d::Identity();
  JointDrives drives_;
  ArmLaw law_;
  FrictionObserver friction_;
  ExternalTorqueObserver observer_;
  Random noise_;

  JointVector q_, dq_;            // as measured by the controller
  JointVector q_true_, dq_true_;  // of the plant
  JointVector motor_torque_;
  JointVector joint_torque_;  // behind the gear
  device::ArmSetPoint set_point_;
  bool fresh_set_point_ = false;  // written since the last cycle
  device::Compliance compliance_;
  bool braked_ = false;
  bool stuck_ = false;  // a base that static friction holds
  std::uint32_t fault_ = 0;

  struct Change {
    device::ControlMode to = device::ControlMode::kPosition;
    std::int64_t cycles_left = 0;
  };
  std::optional<Change> change_;
  JointVector wanted_torque_;  // of the last step, before it was clipped
  JointVector fading_;         // what the new law lacks to the torque before a change
  double fade_ = 0.0;          // its share that is still added; 1: the change is now

  struct OwnStop {
    device::StopCategory category = device::StopCategory::kBrakes;
    motion::JointSample begin;
    device::BrakeRamp ramp;
    double time = 0.0;  // s
  };
  std::optional<OwnStop> own_stop_;

  std::uint64_t sequence_ = 0;
  std::int64_t pushed_cycles_ = 0;  // in a row, with an external torque beyond the limit
  SampleLine line_;
};

}  // namespace takt::sim
