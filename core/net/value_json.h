#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "core/base/diagnostics.h"
#include "core/net/value.h"

namespace takt::net {

/// How payloads are written in net files. T: Boolean, Integer, Real, Text, std::string, Vector [x,y,z], Rotation
/// [w,x,y,z], Frame {"position":[x,y,z],"quaternion":[w,x,y,z]} (either may be left out), Twist
/// {"linear":[..],"angular":[..]}, Wrench {"force":[..],"torque":[..]}, JointArray [..]. Realtime: setup.

/// Reads `json` into `value` (canonical); `value` is untouched on an error. A quaternion must have norm 1 within 1e-3
/// and is normalised.
/// @return all diagnostics, pointers relative to `json`.
template <class T>
[[nodiscard]] Diagnostics value_from_json(const nlohmann::ordered_json& json, T& value);

template <class T>
[[nodiscard]] nlohmann::ordered_json value_to_json(const T& value);

template <>
Diagnostics value_from_json(const nlohmann::ordered_json& json, Boolean& value);
template <>
Diagnostics value_from_json(const nlohmann::ordered_json& json, Integer& value);
template <>
Diagnostics value_from_json(const nlohmann::ordered_json& json, Real& value);
template <>
Diagnostics value_from_json(const nlohmann::ordered_json& json, std::string& value);
template <>
Diagnostics value_from_json(const nlohmann::ordered_json& json, Text& value);
template <>
Diagnostics value_from_json(const nlohmann::ordered_json& json, Vector& value);
template <>
Diagnostics value_from_json(const nlohmann::ordered_json& json, Rotation& value);
template <>
Diagnostics value_from_json(const nlohmann::ordered_json& json, Frame& value);
template <>
Diagnostics value_from_json(const nlohmann::ordered_json& json, Twist& value);
template <>
Diagnostics value_from_json(const nlohmann::ordered_json& json, Wrench& value);
template <>
Diagnostics value_from_json(const nlohmann::ordered_json& json, JointArray& value);
template <>
nlohmann::ordered_json value_to_json(const Boolean& value);
template <>
nlohmann::ordered_json value_to_json(const Integer& value);
template <>
nlohmann::ordered_json value_to_json(const Real& value);
template <>
nlohmann::ordered_json value_to_json(const std::string& value);
template <>
nlohmann::ordered_json value_to_json(const Text& value);
template <>
nlohmann::ordered_json value_to_json(const Vector& value);
template <>
nlohmann::ordered_json value_to_json(const Rotation& value);
template <>
nlohmann::ordered_json value_to_json(const Frame& value);
template <>
nlohmann::ordered_json value_to_json(const Twist& value);
template <>
nlohmann::ordered_json value_to_json(const Wrench& value);
template <>
nlohmann::ordered_json value_to_json(const JointArray& value);

/// What lies in a slot (const Slot<T>*, T by `type`), null as JSON null.
[[nodiscard]] nlohmann::ordered_json slot_to_json(ValueType type, const void* slot);

/// Checks every number of `value` against an interval text such as "(0,inf)", or a String against words "a|b|c"; an
/// empty range allows everything. A malformed range text is a programming error (abort).
template <class T>
[[nodiscard]] Diagnostics check_range(const T& value, std::string_view range);

}  // namespace takt::net
