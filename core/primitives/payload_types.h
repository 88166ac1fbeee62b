#pragma once

#include <string_view>
#include <type_traits>

#include "core/net/primitive.h"

namespace takt::primitives {

/// The unit text of a port of any type: a variable where the type carries units, two where it carries two, else none.
template <class T>
constexpr const char* free_unit() {
  constexpr bool kPlain = std::is_same_v<T, net::Boolean> || std::is_same_v<T, net::Integer> ||
                          std::is_same_v<T, net::Text> || std::is_same_v<T, net::Rotation> ||
                          std::is_same_v<T, net::Frame>;
  constexpr bool kTwo = std::is_same_v<T, net::Twist> || std::is_same_v<T, net::Wrench>;
  return kPlain ? "" : kTwo ? "u,v" : "u";
}

/// The frame text of a port of any type: variables, so that frames are checked across the primitive.
template <class T>
constexpr const char* free_frame() {
  constexpr bool kPose = std::is_same_v<T, net::Frame> || std::is_same_v<T, net::Rotation>;
  constexpr bool kExpressed =
      std::is_same_v<T, net::Vector> || std::is_same_v<T, net::Twist> || std::is_same_v<T, net::Wrench>;
  return kPose ? "A>B" : kExpressed ? "A" : "";
}

/// What a port of any type says of itself, with unit and frame that are handed on.
template <class T>
constexpr net::PortSpec free_spec(std::string_view doc, net::OnNull on_null = net::OnNull::kPropagate) {
  return {.unit = free_unit<T>(), .frame = free_frame<T>(), .doc = doc, .on_null = on_null};
}
/// An output where null may arise.
template <class T>
constexpr net::PortSpec free_spec_may_be_null(std::string_view doc) {
  return {.unit = free_unit<T>(), .frame = free_frame<T>(), .doc = doc, .may_be_null = true};
}

}  // namespace takt::primitives

/// Names the instances of a class template for the payloads of ports and registers them: IsNullReal, IsNullFrame, ...
#define TAKT_PRIMITIVE_FOR(Template, Suffix, Type, family, doc) \
  using Template##Suffix = Template<Type>;                      \
  TAKT_PRIMITIVE(Template##Suffix, family, doc)

#define TAKT_PRIMITIVE_FOR_ALL(Template, family, doc)                 \
  TAKT_PRIMITIVE_FOR(Template, Boolean, net::Boolean, family, doc);   \
  TAKT_PRIMITIVE_FOR(Template, Integer, net::Integer, family, doc);   \
  TAKT_PRIMITIVE_FOR(Template, Real, net::Real, family, doc);         \
  TAKT_PRIMITIVE_FOR(Template, String, net::Text, family, doc);       \
  TAKT_PRIMITIVE_FOR(Template, Vector, net::Vector, family, doc);     \
  TAKT_PRIMITIVE_FOR(Template, Rotation, net::Rotation, family, doc); \
  TAKT_PRIMITIVE_FOR(Template, Frame, net::Frame, family, doc);       \
  TAKT_PRIMITIVE_FOR(Template, Twist, net::Twist, family, doc);       \
  TAKT_PRIMITIVE_FOR(Template, Wrench, net::Wrench, family, doc);     \
  TAKT_PRIMITIVE_FOR(Template, Joints, net::JointArray, family, doc)
