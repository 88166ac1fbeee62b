#pragma once

#include <cstdint>
#include <string>

#include "core/base/time.h"
#include "core/device/control_mode.h"
#include "core/kinematics/types.h"
#include "core/net/value.h"

namespace takt::device {

/// What an arm reports: the newest sample its driver has. Everything in SI, joints in the order of the URDF chain.
struct ArmSample {
  std::uint64_t sequence = 0;  ///< counts samples; 0 = none yet
  Nanoseconds stamp = 0;       ///< when it was measured, on the core's clock
  JointVector q;               ///< rad or m, measured
  JointVector dq;              ///< from the driver, never from differencing held samples
  JointVector tau;             ///< measured joint torque, Nm; size 0 if the arm has no such sensor
  JointVector tau_external;    ///< what the surroundings exert on the joints, estimated by the device, Nm; size 0: none
  /// Where the device is told to be at `stamp`; when it takes set points over, the first one continues from here. Size
  /// 0: it says nothing of the kind, then from `q`.
  JointVector commanded;
  ControlMode mode = ControlMode::kPosition;  ///< in which it follows set points
  bool changing_mode = false;                 ///< on the way to another; set points are not followed
  bool braked = false;                        ///< its brakes are closed
  bool ready = false;                         ///< accepts set points: powered, brakes open, no fault
  std::uint32_t fault = 0;  ///< device-specific cause, 0 = none; ArmBackend::fault_text gives the words
};

/// What an arm is told for the coming cycle.
struct ArmSetPoint {
  std::int64_t cycle = 0;  ///< core cycle that made it
  Nanoseconds stamp = 0;
  JointVector q, dq, ddq;
};

/// Tool and load as the controller is told, in flange axes.
struct PayloadSetting {
  double mass = 0.0;  ///< kg
  Eigen::Vector3d p_FC = Eigen::Vector3d::Zero();
  Eigen::Matrix3d I_C = Eigen::Matrix3d::Zero();
};

/// Declared times between the core and a device, for the certificate of a site (row O7). All zero: the device lives in
/// the core's cycle.
struct BackendTiming {
  Nanoseconds cycle = 0;         ///< of the device
  Nanoseconds sample_age = 0;    ///< oldest that a sample can be at the beginning of a cycle, filters included
  Nanoseconds driver_delay = 0;  ///< from a set point's time to when it leaves for the device
  Nanoseconds dead_time = 0;     ///< from there to when the device is told to be there
};

/// What hangs on the flange, as the controller is told.
struct ToolSetting {
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();  ///< tool centre point T in flange F, m
  PayloadSetting payload;
};

/// How a device comes to rest when it is not the net that stops it (row S3, IEC 60204-1).
enum class StopCategory : std::uint8_t {
  kBrakes,          ///< 0: power off and brakes at once; the way is not planned
  kStopThenBrakes,  ///< 1: the drives brake within the limits, then the brakes close
  kStopAndHold      ///< 2: the drives brake within the limits and hold the arm
};

/// The machine behind a canonical arm: simulated or a driver. Called by the cycle thread only; never blocks, never
/// allocates. A driver with a clock of its own answers from its rings (rows T2, T3).
class ArmBackend {
 public:
  virtual ~ArmBackend() = default;
  /// Copies the newest sample. @return false if there has never been one.
  virtual bool read(ArmSample& sample) = 0;
  /// Before read() in each cycle: a net holds the arm, or none does. A driver whose machine began anew accepts it only
  /// while none does (row S4).
  virtual void set_held(bool /*held*/) {}
  /// Hands over the set point of this cycle. Without one in a cycle the device holds the last position.
  virtual void write(const ArmSetPoint& set_point) = 0;
  /// Before write() in each cycle of a mode of impedance: how the arm gives way from this set point on.
  virtual void write_compliance(const Compliance& /*compliance*/) {}
  /// Begins to change the mode. The sample tells when it is done; a device that refuses stays as it is or stops.
  virtual void change_mode(ControlMode /*mode*/) {}
  virtual void set_payload(const PayloadSetting& payload) = 0;
  /// Payload and tool centre point; a device without modes of impedance needs no tool.
  virtual void set_tool(const ToolSetting& tool) { set_payload(tool.payload); }
  /// Category 0: brakes now (row S3).
  virtual void brake() = 0;
  [[nodiscard]] virtual std::string fault_text(std::uint32_t fault) const = 0;
  [[nodiscard]] virtual BackendTiming timing() const { return {}; }
};

struct WrenchSample {
  std::uint64_t sequence = 0;
  Nanoseconds stamp = 0;
  net::Wrench wrench;     ///< raw reading in measuring frame S: what the surroundings (and gravity on all that hangs on
                          ///< the tool side) exert on the tool side
  bool overload = false;  ///< a channel is at its range
};

/// A six-axis force/torque sensor, raw: tool weight, inertia, bias and noise included.
class ForceTorqueBackend {
 public:
  virtual ~ForceTorqueBackend() = default;
  virtual bool read(WrenchSample& sample) = 0;
  [[nodiscard]] virtual BackendTiming timing() const { return {}; }
};

}  // namespace takt::device
