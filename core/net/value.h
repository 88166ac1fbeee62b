#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>

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
  /// Entries past the capacity are left out; canonicalise() then refuses the array through its size.
  template <class Derived>
  explicit JointArray(const Eigen::MatrixBase<Derived>& v) : size(v.size()) {
    for (int i = 0; i < static_cast<int>(size) && i < kJointCapacity; ++i) value[static_cast<std::size_t>(i)] = v[i];
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

/// Calls f(std::type_identity<T>{}) with the payload type that `type` names.
template <class F>
decltype(auto) visit_type(ValueType type, F&& f) {
  switch (type) {
    case ValueType::kBoolean:
      return f(std::type_identity<Boolean>{});
    case ValueType::kInteger:
      return f(std::type_identity<Integer>{});
    case ValueType::kReal:
      return f(std::type_identity<Real>{});
    case ValueType::kString:
      return f(std::type_identity<Text>{});
    case ValueType::kVector:
      return f(std::type_identity<Vector>{});
    case ValueType::kRotation:
      return f(std::type_identity<Rotation>{});
    case ValueType::kFrame:
      return f(std::type_identity<Frame>{});
    case ValueType::kTwist:
      return f(std::type_identity<Twist>{});
    case ValueType::kWrench:
      return f(std::type_identity<Wrench>{});
    case ValueType::kJoints:
      break;
  }
  return f(std::type_identity<JointArray>{});
}

/// Puts a payload into its one canonical bit pattern: -0 becomes +0, unused entries are zero, the last row of a Frame
/// is 0 0 0 1.
/// @return false if a component is not finite or a joint array has no valid size; the caller makes null of it (row
/// N5). Realtime: cyclic.
inline bool canonicalise(Boolean&) { return true; }
inline bool canonicalise(Integer&) { return true; }
inline bool canonicalise(Real& value) {
  value += 0.0;  // the one sum that turns -0 into +0 and leaves all else
  return std::isfinite(value);
}
inline bool canonicalise(Vector& value) {
  value.array() += 0.0;
  return std::isfinite(value.x()) && std::isfinite(value.y()) && std::isfinite(value.z());
}
inline bool canonicalise(Twist& value) {
  const bool linear = canonicalise(value.linear), angular = canonicalise(value.angular);
  return linear && angular;
}
inline bool canonicalise(Wrench& value) {
  const bool force = canonicalise(value.force), torque = canonicalise(value.torque);
  return force && torque;
}
bool canonicalise(Text& value);
bool canonicalise(Rotation& value);
bool canonicalise(Frame& value);
bool canonicalise(JointArray& value);

/// What lies in the payload of a null: zero, or the identity for rotations and frames.
template <class T>
[[nodiscard]] T null_payload() {
  if constexpr (std::is_same_v<T, Rotation> || std::is_same_v<T, Frame>) {
    return T::Identity();
  } else if constexpr (std::is_same_v<T, Vector>) {
    return Vector::Zero();
  } else {
    return T{};
  }
}

/// What lies on an output port: the payload and the null flag beside it. Slots of a net stand side by side in one
/// block without uninitialised bytes, so that the digest can run over the block (row D4). The block is zeroed once;
/// write the members (as Out does) or copy a slot with copy_slot, never assign a whole Slot: that may touch padding.
template <class T>
struct Slot {
  T value = null_payload<T>();
  std::uint64_t null = 1;  ///< 1 = null; then `value` is null_payload<T>()
};

/// Copies payload, flag and (zero) padding. Realtime: cyclic.
template <class T>
void copy_slot(const Slot<T>& from, Slot<T>& to) {
  std::memcpy(static_cast<void*>(&to), static_cast<const void*>(&from), sizeof(Slot<T>));
}

/// The slot that every unbound input reads.
template <class T>
inline const Slot<T> kNullSlot{};

}  // namespace takt::net
