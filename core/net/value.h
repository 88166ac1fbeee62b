#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace takt::net {

/// Most elements of a joint array; equal to kinematics::kMaxJoints (checked where both are known).
inline constexpr int kJointCapacity = 12;

/// Text of at most 63 bytes: a port may carry it without allocation. Longer text is cut at a UTF-8 boundary.
struct Text {
  std::array<char, 63> bytes{};
  std::uint8_t size = 0;

  Text() = default;
  explicit Text(std::string_view text);
  [[nodiscard]] std::string_view view() const { return {bytes.data(), size}; }
};

/// Velocity of a frame: linear of its origin, then angular. Also spatial acceleration; the port's unit says which.
struct Twist {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();
};

/// Force and torque about the origin of the frame that the port names.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
};

/// One number per joint; entries from `size` on are zero, so that bits compare.
struct JointArray {
  std::array<double, kJointCapacity> value{};
  std::int64_t size = 0;

  JointArray() = default;
  template <class Derived>
  explicit JointArray(const Eigen::MatrixBase<Derived>& v) : size(v.size()) {
    for (int i = 0; i < static_cast<int>(size); ++i) value[static_cast<std::size_t>(i)] = v[i];
  }
  [[nodiscard]] Eigen::Map<const Eigen::VectorXd> map() const { return {value.data(), size}; }
  [[nodiscard]] Eigen::Map<Eigen::VectorXd> map() { return {value.data(), size}; }
};

using Boolean = bool;
using Integer = std::int64_t;
using Real = double;
using Vector = Eigen::Vector3d;
using Rotation = Eigen::Quaterniond;
using Frame = Eigen::Isometry3d;

/// The types that a port may have, in the words of net files.
enum class ValueType : std::uint8_t {
  kBoolean,
  kInteger,
  kReal,
  kString,
  kVector,
  kRotation,
  kFrame,
  kTwist,
  kWrench,
  kJoints
};

template <class T>
inline constexpr ValueType kValueType = [] {
  if constexpr (std::is_same_v<T, Boolean>) return ValueType::kBoolean;
  if constexpr (std::is_same_v<T, Integer>) return ValueType::kInteger;
  if constexpr (std::is_same_v<T, Real>) return ValueType::kReal;
  if constexpr (std::is_same_v<T, Text>) return ValueType::kString;
  if constexpr (std::is_same_v<T, Vector>) return ValueType::kVector;
  if constexpr (std::is_same_v<T, Rotation>) return ValueType::kRotation;
  if constexpr (std::is_same_v<T, Frame>) return ValueType::kFrame;
  if constexpr (std::is_same_v<T, Twist>) return ValueType::kTwist;
  if constexpr (std::is_same_v<T, Wrench>) return ValueType::kWrench;
  if constexpr (std::is_same_v<T, JointArray>) return ValueType::kJoints;
}();

[[nodiscard]] std::string_view name_of(ValueType type);

/// Puts a payload into its one canonical bit pattern: -0 becomes +0, unused entries are zero.
/// @return false if a component is not finite; the caller makes null of it (row N5). Realtime: cyclic.
bool canonicalise(Boolean& value);
bool canonicalise(Integer& value);
bool canonicalise(Real& value);
bool canonicalise(Text& value);
bool canonicalise(Vector& value);
bool canonicalise(Rotation& value);
bool canonicalise(Frame& value);
bool canonicalise(Twist& value);
bool canonicalise(Wrench& value);
bool canonicalise(JointArray& value);

/// What lies on an output port: the payload and the null flag beside it. Slots of a net stand side by side in one
/// block without uninitialised bytes, so that the digest can run over the block (row D4).
template <class T>
struct Slot {
  T value;
  std::uint64_t null;  ///< 1 = null; then `value` is the canonical zero of its type
};

}  // namespace takt::net
