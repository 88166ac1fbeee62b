#pragma once

#include <type_traits>

#include "core/net/value.h"

namespace takt::primitives {

/// The unit text of a port of any type: a variable where the type carries units, two where it carries two, else none.
template <class T>
constexpr const char* free_unit() {
  if (std::is_same_v<T, net::Twist> || std::is_same_v<T, net::Wrench>) return "u,v";
  constexpr bool kHasUnit = !std::is_same_v<T, net::Boolean> && !std::is_same_v<T, net::Integer> &&
                            !std::is_same_v<T, net::Text> && !std::is_same_v<T, net::Rotation> &&
                            !std::is_same_v<T, net::Frame>;
  return kHasUnit ? "u" : "";
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
