#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>
#include <string_view>

#include <Eigen/Geometry>

#include "core/net/value.h"

/// Datagrams of FRI 1.0 (KRC2lr): the measurement that the controller sends each cycle, and the command that answers
/// it. Inside of the project everything is in SI, in double precision, with torques in the order x, y, z; on the wire
/// it is binary32, little endian, with torques in the order z, y, x. This file is where the one becomes the other.
/// Source: the table of fields in docs/hardware.md, "Datagrams".
namespace takt::hw::fri {

inline constexpr int kJoints = 7;
inline constexpr std::size_t kMeasurementSize = 916, kCommandSize = 376;  ///< bytes
inline constexpr std::uint16_t kMeasurementId = 0x2006, kCommandId = 0x1005;
inline constexpr std::uint16_t kPort = 49'938;  ///< on which the remote side listens
inline constexpr std::uint16_t kAllDrives = 0x7f;

using Joints = Eigen::Matrix<double, kJoints, 1>;
using Axes = Eigen::Matrix<double, 6, 1>;  ///< x, y, z, about x, about y, about z

enum class State : std::uint16_t { kOff, kMonitor, kCommand };
enum class Quality : std::uint16_t { kUnacceptable, kBad, kOk, kPerfect };
enum class Control : std::uint16_t { kOther, kPosition, kCartesianImpedance, kJointImpedance };
[[nodiscard]] std::string_view name_of(State state);      ///< "OFF", "MON", "CMD"
[[nodiscard]] std::string_view name_of(Quality quality);  ///< "unacceptable", ...
[[nodiscard]] std::string_view name_of(Control control);

/// Values that KRL program and remote side exchange. KRL counts from 1, these arrays from 0.
struct KrlValues {
  std::array<float, 16> real{};
  std::array<std::int32_t, 16> integer{};
  std::uint16_t boolean = 0;  ///< bit i is element i
};

/// Means over the last 100 cycles, made by the controller.
struct Statistics {
  double answer_rate = 0.0;  ///< 1: every datagram was answered
  double latency = 0.0;      ///< s, there and back
  double jitter = 0.0;       ///< s
  double miss_rate = 0.0;
  std::uint32_t misses = 0;  ///< since the interface was opened
};

/// Controller to remote side. Frames: B base of the robot, T tool as KRL has it.
struct Measurement {
  std::uint16_t sequence = 0;   ///< of this datagram; wraps
  std::uint16_t reflected = 0;  ///< `sequence` of the command that came last
  KrlValues krl;                ///< $FRI_TO_...
  double timestamp = 0.0;       ///< s of the controller's clock; coarse after some hours
  State state = State::kOff;
  Quality quality = Quality::kUnacceptable;
  double measurement_period = 0.0;  ///< s between datagrams
  double command_period = 0.0;      ///< s, in which commands are expected
  double safety_limits = 0.0;       ///< share of the limits that friStart() asked for
  Statistics statistics;
  std::uint16_t power = 0;  ///< a bit per drive; kAllDrives: all are on
  Control control = Control::kOther;
  std::uint16_t error = 0, warning = 0;  ///< a bit per drive
  Joints temperature = Joints::Zero();   ///< deg C
  Joints q = Joints::Zero();             ///< rad, measured
  Eigen::Isometry3d X_BT = Eigen::Isometry3d::Identity();
  Joints q_before = Joints::Zero();  ///< rad, commanded by the controller itself, before FRI
  Joints q_offset = Joints::Zero();  ///< rad, added by FRI: the drives follow q_before + q_offset
  Eigen::Isometry3d X_BT_before = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d X_offset = Eigen::Isometry3d::Identity();
  Joints tau = Joints::Zero();           ///< Nm, measured
  Joints tau_external = Joints::Zero();  ///< Nm, what the surroundings exert, estimated
  net::Wrench wrench_external;           ///< the same at the tool, N and Nm, in the task frame of KRL
  Eigen::Matrix<double, 6, kJoints> jacobian = Eigen::Matrix<double, 6, kJoints>::Zero();
  Eigen::Matrix<double, kJoints, kJoints> mass = Eigen::Matrix<double, kJoints, kJoints>::Zero();  ///< kg m^2
  Joints gravity = Joints::Zero();                                                                 ///< Nm
};

/// Whether all seven drives have power; with any of them off the arm stands. Bits beyond the seven drives do not count.
[[nodiscard]] inline bool drives_on(const Measurement& m) { return (m.power & kAllDrives) == kAllDrives; }

/// Which parts of a command count.
enum CommandFlag : std::uint32_t {
  kJointPosition = 0x0001,
  kJointTorque = 0x0004,
  kJointStiffness = 0x0010,
  kJointDamping = 0x0020,
  kCartesianPosition = 0x0100,
  kCartesianWrench = 0x0400,
  kCartesianStiffness = 0x1000,
  kCartesianDamping = 0x2000,
};
inline constexpr std::uint32_t kPositionFlags = kJointPosition;
inline constexpr std::uint32_t kJointImpedanceFlags = kJointPosition | kJointTorque | kJointStiffness | kJointDamping;
/// With a joint position: towards it the arm goes with what the tool does not feel.
inline constexpr std::uint32_t kCartesianImpedanceFlags =
    kJointPosition | kCartesianPosition | kCartesianWrench | kCartesianStiffness | kCartesianDamping;

/// Remote side to controller.
struct Command {
  std::uint16_t sequence = 0;
  std::uint16_t reflected = 0;  ///< `sequence` of the measurement that this answers
  KrlValues krl;                ///< $FRI_FRM_...
  std::uint32_t flags = 0;
  Joints q = Joints::Zero();  ///< rad
  Eigen::Isometry3d X_BT = Eigen::Isometry3d::Identity();
  Joints tau = Joints::Zero();                                                ///< Nm, added
  net::Wrench wrench;                                                         ///< N and Nm, that the tool exerts, added
  Joints stiffness = Joints::Zero(), damping = Joints::Zero();                ///< Nm/rad; share of critical
  Axes cartesian_stiffness = Axes::Zero(), cartesian_damping = Axes::Zero();  ///< N/m, Nm/rad; share of critical
};

/// Why a datagram is none of these.
enum class Misread : std::uint8_t {
  kSize,        ///< not as long as its kind is
  kPacketSize,  ///< says another length than it has
  kId,          ///< another version or direction
  kValue        ///< a state, quality or control mode that does not exist
};

/// Realtime: cyclic, all four.
void encode(const Measurement& measurement, std::span<std::byte, kMeasurementSize> bytes);
void encode(const Command& command, std::span<std::byte, kCommandSize> bytes);
/// Numbers come as they are, NaN and infinity too: what they are for judges them.
[[nodiscard]] std::expected<Measurement, Misread> decode_measurement(std::span<const std::byte> bytes);
[[nodiscard]] std::expected<Command, Misread> decode_command(std::span<const std::byte> bytes);

}  // namespace takt::hw::fri
