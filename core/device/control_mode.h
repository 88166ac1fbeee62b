#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"
#include "core/kinematics/types.h"
#include "core/net/value.h"

/// How an arm follows its set points, and how it may go from one way to another (docs/control-modes.md).
namespace takt::device {

using kinematics::JointVector;

enum class ControlMode : std::uint8_t {
  kPosition,           ///< stiff: the joints are where the set point is
  kJointImpedance,     ///< each joint is a spring and a damper about the set point
  kCartesianImpedance  ///< the tool is one about the pose that the set point gives; the posture has a weak one too
};

/// All modes, and their names in device files and nets.
[[nodiscard]] std::span<const ControlMode> all_control_modes();
[[nodiscard]] std::string_view name_of(ControlMode mode);
/// @return nothing for a text that names no mode. Realtime: cyclic.
[[nodiscard]] std::optional<ControlMode> control_mode_of(std::string_view name);

/// When a device can change from one mode to another (row L4).
enum class ChangeClass : std::uint8_t {
  kSeamless,      ///< at any time, in the cycle in which it is asked for
  kAtStandstill,  ///< while its set point stands; it takes the declared time
  kOutsideNet     ///< as before, and only while no net holds the device
};
[[nodiscard]] std::string_view name_of(ChangeClass change);

struct ModeChange {
  ControlMode from = ControlMode::kPosition, to = ControlMode::kPosition;
  ChangeClass change = ChangeClass::kAtStandstill;
  Nanoseconds duration = 0;  ///< 0 for a seamless one
};

/// The modes of a device model and the changes between them. A change that is not listed is forbidden.
struct ControlModes {
  std::vector<ControlMode> modes = {ControlMode::kPosition};  ///< the first is the one after power-on
  std::vector<ModeChange> changes;

  [[nodiscard]] bool has(ControlMode mode) const;
  /// @return nullptr: forbidden. Realtime: cyclic.
  [[nodiscard]] const ModeChange* find(ControlMode from, ControlMode to) const;
  /// "position, joint_impedance". Realtime: setup.
  [[nodiscard]] std::string list() const;
};

/// How an arm gives way: what a net sets beside the set point in a mode of impedance. One entry per axis: the joints in
/// joint impedance (Nm/rad, Nm; for prismatic joints N/m, N); x, y, z and the rotations about them in Cartesian
/// impedance (N/m, Nm/rad; N, Nm). Size 0 in mode position.
struct Compliance {
  ControlMode mode = ControlMode::kPosition;
  /// Cartesian: the axes are those of the tool T, else those of the base B; the spring acts at the origin of T.
  bool in_tool_axes = false;
  JointVector stiffness = {};
  JointVector damping_ratio = {};    ///< of critical damping, for each axis by itself
  JointVector feed_forward = {};     ///< torques of the joints, or the wrench that the tool exerts, added to the spring
  double nullspace_stiffness = 0.0;  ///< Cartesian: Nm/rad of what the tool does not feel, towards q of the set point
  double nullspace_damping_ratio = 0.0;  ///< Cartesian

  [[nodiscard]] bool operator==(const Compliance& other) const;
  /// Nothing pushes: no torque beside springs and dampers.
  [[nodiscard]] bool neutral() const { return feed_forward.size() == 0 || feed_forward.isZero(0.0); }
};

/// What the device allows in one mode, element by element.
struct ComplianceRange {
  Compliance lower, upper;
  Compliance standard;         ///< with which the mode begins
  bool stiff_on_stop = false;  ///< a stop makes it as stiff as it can be; else it stays as it is
};

/// Both modes of impedance of a device model, as far as it has them.
struct ImpedanceDescription {
  ComplianceRange joint, cartesian;
  Nanoseconds ramp = kSecond / 2;  ///< in which a value may go through its whole range: bounds all rates

  /// `mode` is not position.
  [[nodiscard]] const ComplianceRange& range(ControlMode mode) const {
    return mode == ControlMode::kJointImpedance ? joint : cartesian;
  }
  /// The compliance with which a mode begins; empty for position.
  [[nodiscard]] Compliance standard(ControlMode mode) const {
    return mode == ControlMode::kPosition ? Compliance{} : range(mode).standard;
  }
};

/// One value of a compliance that is not as it must be; for the guard. Realtime: cyclic.
/// @param last   what was sent in the last cycle, in the same mode
/// @param share  of its whole range that a value may change by in a cycle
/// @return what is wrong, with axis and numbers, or nothing.
[[nodiscard]] std::optional<net::Text> find_fault(const Compliance& next, const Compliance& last,
                                                  const ComplianceRange& range, double share);

/// `from` on its way to `to`: every value goes as far as it may in one cycle. Same mode, same sizes. Realtime: cyclic.
[[nodiscard]] Compliance approach(const Compliance& from, const Compliance& to, const ComplianceRange& range,
                                  double share);

/// What a stop leads to: no feed-forward; as stiff as can be where the device says so. Realtime: cyclic.
[[nodiscard]] Compliance stopped(const Compliance& compliance, const ComplianceRange& range);

}  // namespace takt::device
