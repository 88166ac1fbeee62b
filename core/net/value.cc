#include "core/net/value.h"

#include <algorithm>

namespace takt::net {
namespace {

/// Largest size <= `limit` that does not cut a UTF-8 sequence of `text`.
std::size_t utf8_cut(std::string_view text, std::size_t limit) {
  if (text.size() <= limit) return text.size();
  while (limit > 0 && (static_cast<unsigned char>(text[limit]) & 0xC0u) == 0x80u) --limit;
  return limit;
}

}  // namespace

Text::Text(std::string_view text) : size(static_cast<std::uint8_t>(utf8_cut(text, bytes.size()))) {
  std::copy_n(text.begin(), size, bytes.begin());
}

std::string_view name_of(ValueType type) {
  static constexpr std::array<std::string_view, 10> kNames = {"Boolean",  "Integer", "Real",  "String", "Vector",
                                                              "Rotation", "Frame",   "Twist", "Wrench", "Joints"};
  return kNames.at(static_cast<std::size_t>(type));
}

bool canonicalise(Text& value) {
  if (value.size > value.bytes.size()) return false;
  std::fill(value.bytes.begin() + value.size, value.bytes.end(), '\0');
  return true;
}

bool canonicalise(Rotation& value) {
  value.coeffs().array() += 0.0;
  return value.coeffs().allFinite();
}

bool canonicalise(Frame& value) {
  value.matrix().topRows<3>().array() += 0.0;
  value.makeAffine();
  return value.matrix().topRows<3>().allFinite();
}

bool canonicalise(JointArray& value) {
  if (value.size < 0 || value.size > kJointCapacity) return false;
  bool finite = true;
  for (std::size_t i = 0; i < value.value.size(); ++i) {
    double& entry = value.value[i];
    entry = static_cast<std::int64_t>(i) < value.size ? entry + 0.0 : 0.0;
    finite = finite && std::isfinite(entry);
  }
  return finite;
}

}  // namespace takt::net
